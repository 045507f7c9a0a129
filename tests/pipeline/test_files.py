"""Results are whole or not there."""

import json
import os
import signal
import stat
from pathlib import Path

import pytest

from pipeline import files
from pipeline.errors import UnwritableOutput
from pipeline.files import (
    finish_interrupted,
    may_never_end,
    remove_parts,
    write_together,
    write_whole,
)


def test_text_and_bytes_are_written_as_they_are(tmp_path: Path) -> None:
    path = tmp_path / "new" / "folder" / "results.json"
    write_whole(path, "α ± β\n")
    assert path.read_bytes() == "α ± β\n".encode()
    write_whole(path, b"\x00\r\n")
    assert path.read_bytes() == b"\x00\r\n"


@pytest.mark.parametrize("step", ["fsync", "replace"])
@pytest.mark.parametrize("fault", [OSError(28, "No space left on device"), KeyboardInterrupt()])
def test_a_fault_leaves_the_old_file_and_nothing_else(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, step: str, fault: BaseException
) -> None:
    path = tmp_path / "results.json"
    path.write_text("old")

    def fail(*_: object) -> None:
        raise fault

    monkeypatch.setattr(files.os, step, fail)
    with pytest.raises((UnwritableOutput, KeyboardInterrupt), match=r"No space left|^$"):
        write_whole(path, "new")
    assert [each.name for each in tmp_path.iterdir()] == ["results.json"]
    assert path.read_text() == "old"


@pytest.mark.parametrize("fault", ["full disk", "interrupt", "kill"])
@pytest.mark.parametrize("step", ["fsync", "replace"])
@pytest.mark.parametrize("n", range(1, 6))
def test_a_fault_at_any_write_of_several_files_changes_all_or_none(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, step: str, n: int, fault: str
) -> None:
    """Four files and their journal; where it is in place the change goes forward."""
    paths = [tmp_path / name for name in ("config.yaml", "results.json", "report.html", "history")]
    journal, real, calls = tmp_path / ".unfinished.json", getattr(os, step), 0
    for path in paths:
        path.write_text("old")

    def faulty(*arguments: object) -> object:
        nonlocal calls
        calls += 1
        if calls == n and fault == "kill":
            os.kill(os.getpid(), signal.SIGKILL)
        if calls == n:
            raise KeyboardInterrupt if fault == "interrupt" else OSError(28, "No space left")
        return real(*arguments)

    monkeypatch.setattr(files.os, step, faulty)
    if fault != "kill":
        with pytest.raises((UnwritableOutput, KeyboardInterrupt)):
            write_together(dict.fromkeys(paths, "new"), journal)
    elif child := os.fork():
        assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == -signal.SIGKILL
    else:
        try:
            write_together(dict.fromkeys(paths, "new"), journal)
        finally:
            os._exit(0)
    monkeypatch.undo()
    finish_interrupted(journal, paths)
    remove_parts([*paths, journal])
    expected = "new" if step == "replace" and n > 1 else "old"
    assert [path.read_text() for path in paths] == [expected] * 4
    assert {*tmp_path.iterdir()} == {*paths}


def test_a_replaced_file_keeps_its_permissions(tmp_path: Path) -> None:
    path = tmp_path / "results.json"
    write_whole(path, "a")
    mask = os.umask(0)
    os.umask(mask)
    assert stat.S_IMODE(path.stat().st_mode) == 0o666 & ~mask
    path.chmod(0o640)
    write_whole(path, "b")
    assert stat.S_IMODE(path.stat().st_mode) == 0o640


def test_a_folder_that_is_a_file_is_refused(tmp_path: Path) -> None:
    (tmp_path / "out").touch()
    with pytest.raises(UnwritableOutput, match="cannot be written"):
        write_whole(tmp_path / "out" / "results.json", "x")


@pytest.mark.parametrize(("name", "part", "is_moved"), [
    ("results.json", ".results.json.x1.part", True),
    ("config.yaml", ".results.json.x1.part", False),  # belongs to another file
    ("log.csv", ".log.csv.x1.part", False),  # this command does not write that file
    ("results.json", "log.csv", False),
    ("results.json", ".results.json.x1", False),
    ("results.json", "../.results.json.x1.part", False),
    ("results.json", 7, False),
])
def test_a_journal_moves_parts_of_expected_files_alone(
    name: str, part: object, is_moved: bool, tmp_path: Path
) -> None:
    folder = tmp_path / "run"
    folder.mkdir()
    names = ("results.json", "config.yaml", "log.csv")
    for one in names:
        (folder / one).write_text("old")
    if isinstance(part, str) and part not in names:
        (folder / part).write_text("new")
    journal = folder / ".unfinished.json"
    journal.write_text(json.dumps({name: part}))
    expected = [folder / "results.json", folder / "config.yaml"]
    assert finish_interrupted(journal, expected)
    assert not journal.exists()
    assert [one for one in names if (folder / one).read_text() != "old"] == [name] * is_moved
    assert not finish_interrupted(journal, expected)


def test_parts_of_other_files_stay(tmp_path: Path) -> None:
    ours, theirs = tmp_path / ".results.json.x1.part", tmp_path / ".results.json.part.csv"
    others = tmp_path / ".thesis.x1.part"
    for one in (ours, theirs, others):
        one.touch()
    remove_parts([tmp_path / "results.json"])
    assert [one.exists() for one in (ours, theirs, others)] == [False, True, True]


def test_a_pipe_and_a_device_may_never_end(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    os.mkfifo(tmp_path / "pipe")
    (tmp_path / "link").symlink_to("/proc/self/status")
    assert not may_never_end(tmp_path)
    assert not may_never_end(tmp_path / "file")
    for one in ("pipe", "/dev/null", "link"):
        assert may_never_end(tmp_path / one)
