"""Text from files, made safe for its target: nothing hidden, nothing executed."""

import re

#: Characters that act instead of showing: controls, separators of lines, those that turn or hide
#: the text after them, and halves of characters that no encoding has.
_HIDDEN = (
    "\x00-\x1f\x7f-\x9f\xad\u061c\u115f\u1160\u180e\u200b-\u200f\u2028-\u202e\u2060-\u206f\u3164"
    "\ufeff\uffa0\ufff9-\ufffb\ud800-\udfff\U000e0000-\U000e0fff"
)
HIDDEN = re.compile(f"[{_HIDDEN}]")
#: A cell of a table that begins so is run as a formula by spreadsheet programs.
FORMULA = ("=", "+", "-", "@")


def escape(character: str) -> str:
    r"""A character as Python writes it: ``\x1b``, ``\u202e``."""
    return character.encode("unicode_escape", "surrogatepass").decode()


def one_line(text: str) -> str:
    r"""``text`` in one line, with what is hidden written out.

    >>> one_line("a\nset b = 1\x1b[2J")
    'a set b = 1\\x1b[2J'
    """
    return HIDDEN.sub(lambda match: escape(match[0]), " ".join(text.split()))


def ascii_line(text: str) -> str:
    r"""The same for programs that read ASCII only.

    >>> ascii_line("±19.6 m/s²")
    '+-19.6 m/s^2'
    """
    plain = one_line(text).replace("±", "+-").replace("²", "^2").replace("°", " deg")
    return plain.encode("ascii", "backslashreplace").decode()


def cell(text: str) -> str:
    """A text cell of a table, which no spreadsheet program runs as a formula.

    >>> cell("=1+1"), cell("temperature_c")
    ("'=1+1", 'temperature_c')
    """
    line = one_line(text)
    return f"'{line}" if line.startswith(FORMULA) else line
