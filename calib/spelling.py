"""The right name that is nearest to a wrong one."""

from collections.abc import Iterable
from difflib import get_close_matches

#: Similarity (difflib's ratio) under which a suggestion would puzzle more; it chooses words only.
SIMILAR = 0.6

FEWEST_LETTERS = 3  #: letters of a beginning that is taken for its name; it chooses words only


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
