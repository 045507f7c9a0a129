"""The example session and the pictures: all are in the wheel, and a copy never replaces anything.
"""

import tomllib
from pathlib import Path

import pytest

from pipeline.cli import main
from pipeline.commands.init import BENCH, LEANING, POSES
from pipeline.config.template import CONFIG, SESSION, copy_session, session_folder
from pipeline.errors import UnwritableOutput
from tests.paths import ROOT
from tests.pipeline.workbench.conftest import written_session

DOCS = ROOT / "data" / "docs"


def test_the_wheel_carries_every_file_of_the_session_and_the_pictures_of_a_new_one() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    carried = {}
    for target, patterns in project["tool"]["setuptools"]["data-files"].items():
        for pattern in patterns:
            carried |= {path: f"{target}/{path.name}" for path in ROOT.glob(pattern)}
    session = ROOT / "data" / SESSION
    files = {path for path in session.rglob("*")
             if path.is_file() and ".run" not in str(path.relative_to(session))}
    pictures = {DOCS / name for name in (POSES, BENCH, LEANING)}
    assert set(carried) == files | pictures
    for path, target in carried.items():
        assert target.endswith(path.relative_to(ROOT / "data").as_posix())


def test_a_copy_is_the_session_and_replaces_nothing(tmp_path: Path) -> None:
    config = copy_session(tmp_path / "demo")
    assert config.read_bytes() == (session_folder() / CONFIG).read_bytes()
    config.write_text("mine")
    with pytest.raises(UnwritableOutput, match="exists and is left as it is"):
        copy_session(tmp_path / "demo")
    assert config.read_text() == "mine"


def test_a_new_session_has_the_pictures_of_the_guide(tmp_path: Path) -> None:
    assert main(["init", str(tmp_path), "--tilted"]) == 0
    for name in (POSES, BENCH, LEANING):
        assert (tmp_path / name).read_bytes() == (DOCS / name).read_bytes()


def test_the_demo_runs_and_names_the_next_command(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """On a session without clips; the tutorial of the README is that of the program's own."""
    small = written_session(tmp_path / "small").parent
    monkeypatch.setattr("pipeline.config.template.session_folder", lambda: small)
    monkeypatch.chdir(tmp_path)
    assert main(["demo"]) == 0
    shown = capsys.readouterr().out
    assert "next: pipeline add pipeline-demo/config.yaml gyroscope.g_sensitivity" in shown
