"""Name and version of the program, and the nearest right name, for messages about wrong ones."""

from collections.abc import Iterable
from difflib import get_close_matches

DISTRIBUTION = "turntable-imu-calibration"  #: the name in pyproject.toml

#: Similarity (difflib's ratio) under which a suggestion would puzzle more than help.
SIMILAR = 0.6


def program_version() -> str:
    """The version of this program that is installed here."""
    from importlib.metadata import PackageNotFoundError, version  # 15 ms that few commands need

    try:
        return version(DISTRIBUTION)
    except PackageNotFoundError:
        return "(not installed)"


def nearest_names(wrong: str, right: Iterable[str]) -> list[str]:
    """The one of ``right`` that is nearest to ``wrong``, if any is near."""
    by_lower = {name.lower(): name for name in right}
    return [by_lower[name] for name in get_close_matches(wrong.lower(), by_lower, 1, SIMILAR)]


def nearest_name(wrong: str, right: Iterable[str]) -> str:
    """`` (did you mean 'misalignment'?)``, or nothing."""
    return "".join(f" (did you mean '{name}'?)" for name in nearest_names(wrong, right))
