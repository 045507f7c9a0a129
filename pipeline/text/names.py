"""Names: of the program, its commands as they are typed, and the nearest right one."""

import shlex
from collections.abc import Collection
from pathlib import Path

from calib.spelling import nearest_name as nearest_name
from calib.spelling import nearest_names as nearest_names

DISTRIBUTION = "turntable-imu-calibration"  #: the name in pyproject.toml

def program_version() -> str:
    """The version of this program that is installed here."""
    from importlib.metadata import PackageNotFoundError, version  # 15 ms that few commands need

    try:
        return version(DISTRIBUTION)
    except PackageNotFoundError:
        return "(not installed)"


def command(*words: str | Path) -> str:
    """The command with these words, each as a shell reads it.

    >>> command("add", "my log.yaml", "gyroscope.column:Fan speed [1/min]")
    "pipeline add 'my log.yaml' 'gyroscope.column:Fan speed [1/min]'"
    """
    return " ".join(["pipeline", *map(word, words)])


def short_name(path: Path, paths: Collection[Path]) -> str:
    """The name of a file, with as many of its folders as tell it from the others of ``paths``.

    >>> short_name(Path("a/x.csv"), [Path("a/x.csv"), Path("b/x.csv"), Path("b/y.csv")])
    'a/x.csv'
    """
    ends = (path.parts[-n:] for n in range(1, len(path.parts)))
    return next(("/".join(end) for end in ends if not any(
        other.parts[-len(end):] == end for other in {*paths} - {path})), str(path))


def word(text: str | Path) -> str:
    """A word of a command as a shell reads it; a file whose name begins with ``-`` is no option.

    >>> word(Path("-a.yaml"))
    './-a.yaml'
    """
    is_option_like = isinstance(text, Path) and str(text).startswith("-")
    return shlex.quote(f"./{text}" if is_option_like else str(text))
