"""No command replaces, or writes through a link, a file that it did not write.

Every command that writes, with every name that it writes, where the user has a file, a link to a
file of another name, a link that leads nowhere, or a folder of that name.
"""

import os
import shutil
from collections.abc import Callable
from pathlib import Path

import pytest

from pipeline.errors import BUG, DONE
from tests.sessions import pipeline

Obstacle = Callable[[Path, Path], None]
TREASURE = "the only copy\n"


def a_file(path: Path, _treasure: Path) -> None:
    path.write_text(TREASURE, encoding="utf-8")


def a_link(path: Path, treasure: Path) -> None:
    path.symlink_to(treasure)


def a_dangling_link(path: Path, treasure: Path) -> None:
    path.symlink_to(treasure.with_name("nowhere"))


def a_folder(path: Path, _treasure: Path) -> None:
    path.mkdir()
    (path / "kept").write_text(TREASURE, encoding="utf-8")


@pytest.fixture(scope="module")
def finished(prepared: Path) -> Path:
    """A session with its results."""
    return prepared.parent


#: the command by its words, and the file that it writes, from the session's folder
WRITERS: list[tuple[tuple[str, ...], str]] = [
    *((("run", "config.yaml", "--output", "out"), f"out/{name}")
      for name in ("results.json", "report.html", "history.jsonl")),
    (("export", "config.run", "--to", "python", "--output", "out/imu.py"), "out/imu.py"),
    (("export", "config.run", "--to", "csv", "--output", "out/it.csv", "--force"), "out/it.csv"),
    (("apply", "config.run", "accelerometer/pose_01.csv", "--output", "out/si.csv"), "out/si.csv"),
    (("init", "out"), "out/config.yaml"),
    (("import", "accelerometer/pose_01.csv", "--output", "out"), "out/config.yaml"),
    (("demo", "out"), "out/config.yaml"),
    *((("fleet", "config.yaml", "--output", "out", "--workers", "1"), f"out/{name}")
      for name in ("fleet.csv", "fleet.parquet", "fleet.html", "population.json")),
]


@pytest.mark.parametrize("obstacle", [a_file, a_link, a_dangling_link, a_folder])
@pytest.mark.parametrize(("words", "name"), WRITERS, ids=[f"{w[0]} {n}" for w, n in WRITERS])
def test_what_the_user_has_there_is_still_there(
    finished: Path, tmp_path: Path, words: tuple[str, ...], name: str, obstacle: Obstacle,
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str],
) -> None:
    session = shutil.copytree(finished, tmp_path / "session")
    treasure = tmp_path / "treasure.csv"
    treasure.write_text(TREASURE, encoding="utf-8")
    (session / "out").mkdir()
    path = session / name
    obstacle(path, treasure)
    before = sorted(file for file in session.rglob("*") if file.is_symlink() or file.is_file())
    monkeypatch.chdir(session)
    code = pipeline(*words)
    message = capsys.readouterr().err
    # An export may be written into a folder that is named.
    into_folder = words[0] == "export" and obstacle is a_folder
    forced = words[-1] == "--force" and obstacle is a_file
    assert code != BUG, message
    assert code != DONE or into_folder or forced
    assert treasure.read_text(encoding="utf-8") == TREASURE
    assert not (tmp_path / "nowhere").exists()
    if obstacle is a_folder:
        assert (path / "kept").read_text(encoding="utf-8") == TREASURE
    elif not forced:
        assert path.is_symlink() or path.read_text(encoding="utf-8") == TREASURE
        assert sorted(f for f in session.rglob("*") if f.is_symlink() or f.is_file()) == before


def test_a_configuration_that_begins_with_a_byte_order_mark_keeps_it(
    finished: Path, tmp_path: Path
) -> None:
    session = shutil.copytree(finished, tmp_path / "session")
    config = session / "config.yaml"
    config_before = config.read_bytes()
    config.write_bytes(b"\xef\xbb\xbf" + config_before)
    assert pipeline("remove", config, "gyroscope.misalignment") == DONE
    changed = config.read_bytes()
    assert changed.startswith(b"\xef\xbb\xbf")
    assert changed.count(b"misalignment") == config_before.count(b"misalignment") - 1


def test_a_demo_that_ends_half_way_leaves_nothing_in_its_place(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def full(*_arguments: object, **_options: object) -> None:
        raise shutil.Error([("a", "b", "No space left on device")])

    with monkeypatch.context() as patched:
        patched.setattr("pipeline.config.template.shutil.copytree", full)
        assert pipeline("demo", tmp_path / "demo") not in (DONE, BUG)
    assert "None" not in capsys.readouterr().err
    assert os.listdir(tmp_path) == []
