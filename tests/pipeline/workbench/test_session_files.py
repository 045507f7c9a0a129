"""Whether the results of a session are those of its files as they are."""

import os
import shutil
from pathlib import Path

import pytest

from pipeline.workbench import session_files
from pipeline.workbench.session_files import SessionFiles
from tests.pipeline.workbench.conftest import Opened, copied
from tests.sessions import pipeline

EFFECT = "\neffects:\n  mine: {python: own.py:own, per: axis, unit: rad/s/s, triad: gyroscope}\n"


def is_run(config: Path) -> bool:
    return SessionFiles(config, config.with_suffix(".run")).is_run()


def written_later(path: Path) -> None:
    """Set the time of a file to after that of any results."""
    os.utime(path, (2e9, 2e9))


def test_a_session_that_is_current_is_opened_without_a_run(opened: Opened) -> None:
    assert opened.said == (f"{opened.config}: was run, and no file has changed since.",)
    history = opened.config.with_suffix(".run") / "history.jsonl"
    assert len(history.read_text(encoding="utf-8").splitlines()) == 1


def test_what_has_changed_since_the_run_is_seen(
    written: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    config = copied(written, tmp_path)
    assert is_run(config)
    shutil.copytree(tmp_path, tmp_path / "moved")
    assert not is_run(tmp_path / "moved" / config.name)  # its page's commands change the first
    shutil.rmtree(tmp_path / "moved")
    monkeypatch.chdir(tmp_path)
    assert is_run(Path(config.name))
    monkeypatch.setattr(session_files, "program_version", lambda: "0.0.7")
    assert not is_run(config)  # a page of another program
    monkeypatch.undo()
    log = next(tmp_path.rglob("pose_07.csv*"))
    before = log.stat().st_mtime
    written_later(log)
    assert not is_run(config)
    os.utime(log, (before, before))
    assert is_run(config)
    text = config.read_text(encoding="utf-8")
    config.write_text(text.replace("misalignment]", "misalignment, quadratic]", 1), "utf-8")
    assert not is_run(config)


def test_the_python_file_of_an_effect_is_a_file_of_the_session(
    written: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    config = copied(written, tmp_path)
    own = tmp_path / "own.py"
    own.write_text("def own(at):\n    return at.time_s\n", encoding="utf-8")
    with config.open("a", encoding="utf-8") as file:
        file.write(EFFECT)
    assert pipeline("run", config, "--allow-python", "--quiet") == 0
    assert is_run(config)
    assert pipeline("open", config) == 2  # as a run of it: Python is not allowed
    assert "--allow-python" in capsys.readouterr().err
    written_later(own)
    assert not is_run(config)
