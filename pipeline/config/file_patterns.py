"""The files that names and patterns in a configuration stand for."""

import os
import re
from collections.abc import Sequence
from itertools import takewhile
from pathlib import Path, PurePath

from pipeline.logs.formats.kinds import is_log_file
from pipeline.text.names import nearest_name

#: How many names of a folder a message shows.
NAMES_SHOWN = 6
DIGITS = re.compile(r"([0-9]+)(?=[^/]*$)")  #: numbers in the name of a file, not of its folder


class NoSuchFile(FileNotFoundError):
    """Nothing has this name or matches this pattern; it may still be recorded.

    Its text is made when it is read: the folder is then searched for the name that was meant.
    """

    def __init__(self, name: str, folder: Path) -> None:
        super().__init__(name)
        self.name, self.folder = name, folder

    def __str__(self) -> str:
        if is_pattern(self.name):
            return f"no file matches '{self.name}'. {_holds(self.folder)}"
        near = nearest_name(Path(self.name).name, _names(self.folder))
        return f"there is no file '{self.name}'{near}. {_holds(self.folder)}"


def natural_key(name: str) -> list[tuple[int, str]]:
    """Sort key that puts ``pose_2`` before ``pose_10``.

    >>> sorted(["pose_10", "pose_2"], key=natural_key)
    ['pose_2', 'pose_10']
    """
    parts = re.split(r"(\d+)", name)
    return [(int(part), part) if part.isdecimal() else (-1, part) for part in parts]


def is_pattern(name: str) -> bool:
    """Whether ``name`` may stand for several files."""
    return any(sign in name for sign in "*?[")


def find_files(name: str, folder: Path) -> tuple[Path, ...]:
    """The files that ``name`` stands for, naturally sorted.

    Parameters
    ----------
    name : str
        A path or a pattern (``*``, ``?``, ``[...]``, ``**``), relative to ``folder``; behind an
        archive or a bag, the name of a table in it.
    folder : Path
        The configuration's folder.

    Raises
    ------
    NoSuchFile
        Nothing is there; the message names the folder and what is in it.
    FileNotFoundError
        The name is a folder's, or the pattern takes in something that is no file: it would be
        missing from the session without a word.
    """
    literal = folder / name
    if is_log_file(literal):
        return (literal,)
    if literal.is_dir():
        raise FileNotFoundError(f"'{name}' is a folder; name the files in it, as in "
                                f"'{name.rstrip('/')}/*.csv'. {_holds(literal)}")
    if not is_pattern(name):
        raise NoSuchFile(name, literal.parent)
    # Path.glob refuses absolute patterns: start at the last folder without a pattern sign in its
    # name. The folder of the configuration is not a pattern, whatever signs its name contains.
    parts = Path(name).parts
    fixed = tuple(takewhile(lambda part: not is_pattern(part), parts))
    start = folder.joinpath(*fixed)
    rest = str(Path(*parts[len(fixed):]))
    if start == Path(start.anchor) and "**" in rest:
        raise FileNotFoundError(f"'{name}' looks through the whole disk; name the folder that "
                                f"holds the logs")
    paths = list(start.glob(rest)) if start.is_dir() else []
    if Path(rest).suffix and not is_pattern(Path(rest).suffix):
        for path in paths:
            _require_log(path, name)
    paths = [path for path in paths if is_log_file(path)]
    if not paths:
        raise NoSuchFile(name, start)
    return tuple(sorted(paths, key=lambda path: natural_key(str(path))))


def takes(pattern: str, path: Path, folder: Path) -> bool:
    """Whether a file at ``path``, there or not, is one that a name or pattern stands for."""
    name = PurePath(path.absolute() if PurePath(pattern).is_absolute() else
                    os.path.relpath(path.absolute(), folder))
    head, deep, tail = pattern.rpartition("**/")
    below = len(PurePath(head).parts)
    return name.match(tail) and (
        name.is_relative_to(head) and ".." not in name.parts[below:] if deep else
        len(name.parts) == len(PurePath(pattern).parts))


def relative_name(path: Path, folder: Path) -> str:
    """The path relative to a configuration's folder; absolute if the file is far from it."""
    relative = Path(os.path.relpath(path.absolute(), folder)).as_posix()
    return path.absolute().as_posix() if relative.startswith("../..") else relative


def names_of(paths: Sequence[Path], folder: Path) -> list[str]:
    """The names of files; those that differ in their digits alone, as a pattern of digits if it
    matches them and no others."""
    names = [relative_name(path, folder) for path in paths]
    alike: dict[tuple[str | int, ...], list[str]] = {}
    for name in names:
        parts = DIGITS.split(name)
        alike.setdefault(tuple(len(part) if i % 2 else part for i, part in enumerate(parts)),
                         []).append(name)
    patterns: dict[str, str] = {}
    for every in (every for every in alike.values() if len(every) > 1):
        pattern = "".join(part if {part} == {*others} else "[0-9]" * len(part) for part, *others in
                          zip(*map(DIGITS.split, every), strict=True))
        if _matches(pattern, every, folder):
            patterns |= dict.fromkeys(every, pattern)
    return [*dict.fromkeys(patterns.get(name, name) for name in names)]


def _matches(pattern: str, names: Sequence[str], folder: Path) -> bool:
    """Whether a pattern stands for these names and no others."""
    try:
        every = [relative_name(path, folder) for path in find_files(pattern, folder)]
    except FileNotFoundError:
        return False
    return sorted(every) == sorted(names)


def _require_log(path: Path, name: str) -> None:
    """Refuse a folder, a dead link or a device that a pattern of files takes in."""
    if is_log_file(path):
        return
    if path.is_dir():
        kind = "a folder"
    elif path.is_symlink() and not path.exists():
        kind = f"a link to {path.readlink()}, which is not there"
    else:
        kind = "a pipe or a device"
    raise FileNotFoundError(f"'{name}' takes in {path.name}, which is {kind}, and a pose would be "
                            f"missing. Put the file there, or remove it")


def _names(folder: Path) -> list[str]:
    if not folder.is_dir():
        return []
    return sorted((entry.name for entry in folder.iterdir()), key=natural_key)


def _holds(folder: Path) -> str:
    """One sentence on the contents of ``folder``, or on how far the path to it exists."""
    if not folder.is_dir():
        there = next(parent for parent in folder.parents if parent.is_dir())
        where = "here" if there == Path() else f"in {there}"
        return f"There is no folder '{folder.relative_to(there)}' {where}. {_holds(there)}"
    names = _names(folder)
    called = "This folder" if folder == Path() else f"The folder {folder}"
    if not names:
        return f"{called} is empty."
    shown = ", ".join(names[:NAMES_SHOWN])
    more = len(names) - NAMES_SHOWN
    return f"{called} holds {shown}{f' and {more} more' if more > 0 else ''}."
