"""What a pattern takes in: every match is a log, or the pattern is refused with what is none."""

import os
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

import pytest

from pipeline.config.file_patterns import find_files, names_of, takes


def dangling(path: Path) -> None:
    path.symlink_to("/nowhere/pose.csv")


def folder(path: Path) -> None:
    path.mkdir()


def pipe(path: Path) -> None:
    os.mkfifo(path)


def device(path: Path) -> None:
    path.symlink_to("/dev/null")


@pytest.mark.parametrize(("other", "kind"), [
    (dangling, "a link to /nowhere/pose.csv, which is not there"), (folder, "a folder"),
    (pipe, "a pipe or a device"), (device, "a pipe or a device"),
])
@pytest.mark.parametrize("pattern", ["pose_*.csv", "**/*.csv"])
def test_a_pose_that_is_no_file_is_not_left_out_silently(
    tmp_path: Path, pattern: str, other: Callable[[Path], None], kind: str
) -> None:
    for i in range(1, 4):
        (tmp_path / f"pose_{i}.csv").write_text("1")
    assert len(find_files(pattern, tmp_path)) == 3
    other(tmp_path / "pose_4.csv")
    with pytest.raises(FileNotFoundError, match=f"takes in pose_4.csv, which is {kind}"):
        find_files(pattern, tmp_path)


def test_folders_beside_the_logs_are_no_fault_of_a_pattern_without_an_ending(
    tmp_path: Path
) -> None:
    (tmp_path / "pose_1.csv").write_text("1")
    (tmp_path / "notes").mkdir()
    assert [path.name for path in find_files("*", tmp_path)] == ["pose_1.csv"]


def test_the_whole_disk_is_not_searched(tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError, match="looks through the whole disk"):
        find_files("/**/pose_*.csv", tmp_path)


def test_files_that_are_numbered_alike_are_one_pattern_each(tmp_path: Path) -> None:
    """One that matches a file which is not meant is none, nor one that would match a later file
    beside them: a log that was corrected, or one to be corrected."""
    names = [f"2/{kind}_{i}.csv" for i in range(1, 13) for kind in ("rest", "turn", "spare")]
    words = [f"2/{word}.csv" for word in ("up", "down", "left")]
    for name in ("1/rest_1.csv", *names, *words):
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text("1")
    meant = [tmp_path / name for name in names if "spare" not in name]
    assert names_of(meant, tmp_path) == [
        f"2/{kind}_{digits}.csv" for digits in ("[0-9]", "[0-9][0-9]") for kind in ("rest", "turn")]
    assert names_of([*meant[1:], tmp_path / "1/rest_1.csv"], tmp_path) == [
        "2/turn_[0-9].csv", *[f"2/rest_{i}.csv" for i in range(2, 10)], "2/rest_[0-9][0-9].csv",
        "2/turn_[0-9][0-9].csv", "1/rest_1.csv"]
    assert names_of([tmp_path / name for name in words], tmp_path) == words


@pytest.mark.parametrize(("pattern", "name", "is_taken"), [
    ("*.csv", "new.csv", True), ("*.csv", "sub/new.csv", False), ("*.csv", "../new.csv", False),
    ("rest/*.csv", "rest/new.csv", True), ("rest/pose_[0-9][0-9].csv", "rest/pose_01.csv", True),
    ("rest/pose_[0-9][0-9].csv", "rest/pose_01.cal.csv", False), ("../a/*.csv", "../a/b.csv", True),
    ("**/*.csv", "new.csv", True), ("rest/**/*.csv", "rest/deep/new.csv", True),
    ("**/*.csv", "../new.csv", False), ("new.csv", "new.csv", True)])
def test_a_pattern_takes_the_files_that_it_would_find(
    tmp_path: Path, pattern: str, name: str, is_taken: bool
) -> None:
    path = tmp_path / "session" / name
    assert takes(pattern, path, tmp_path / "session") == is_taken
    for there in (tmp_path / "session/rest/pose_99.csv", path):
        there.parent.mkdir(parents=True, exist_ok=True)
        there.write_text("1")
    with suppress(FileNotFoundError):
        every = find_files(pattern, tmp_path / "session")
        assert any(one.samefile(path) for one in every) == is_taken
