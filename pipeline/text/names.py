"""Names: of the program, its commands as they are typed, and the nearest right one."""

import shlex
from collections.abc import Iterable
from difflib import get_close_matches
from pathlib import Path

DISTRIBUTION = "turntable-imu-calibration"  #: the name in pyproject.toml

#: Similarity (difflib's ratio) under which a suggestion would puzzle more than help.
SIMILAR = 0.6


FEWEST_LETTERS = 3  #: letters of the beginning of a name that is taken for it


def program_version() -> str:
    """The version of this program that is installed here."""
    from importlib.metadata import PackageNotFoundError, version  # 15 ms that few commands need

    try:
        return version(DISTRIBUTION)
    except PackageNotFoundError:
        return "(not installed)"


def nearest_names(wrong: str, right: Iterable[str]) -> list[str]:
    """The one of ``right`` that is nearest to ``wrong``, or begins like it, if any does.

    >>> nearest_names("gsens", ["bias", "g_sensitivity", "g_squared_sensitivity"])
    ['g_sensitivity']
    """
    by_plain = {_plain(name): name for name in right}
    typed = _plain(wrong)
    begin = [name for name in by_plain if len(typed) >= FEWEST_LETTERS and name.startswith(typed)]
    near = get_close_matches(typed, by_plain, 1, SIMILAR) or sorted(begin, key=len)[:1]
    return [by_plain[name] for name in near]


def _plain(name: str) -> str:
    """A name in small letters without the signs between its words."""
    return "".join(sign for sign in name.lower() if sign not in "_- ")


def nearest_name(wrong: str, right: Iterable[str]) -> str:
    """`` (did you mean 'misalignment'?)``, or nothing."""
    return "".join(f" (did you mean '{name}'?)" for name in nearest_names(wrong, right))


def command(*words: str | Path) -> str:
    """The command with these words, each as a shell reads it.

    >>> command("add", "my log.yaml", "gyroscope.column:Fan speed [1/min]")
    "pipeline add 'my log.yaml' 'gyroscope.column:Fan speed [1/min]'"
    """
    return " ".join(["pipeline", *map(word, words)])


def word(text: str | Path) -> str:
    """A word of a command as a shell reads it; a file whose name begins with ``-`` is no option.

    >>> word(Path("-a.yaml"))
    './-a.yaml'
    """
    is_option_like = isinstance(text, Path) and str(text).startswith("-")
    return shlex.quote(f"./{text}" if is_option_like else str(text))
