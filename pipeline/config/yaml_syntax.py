"""The message for text that cannot be parsed, and names as YAML writes them."""

import json
import re
from pathlib import Path

import yaml

from pipeline.errors import ConfigError

#: PyYAML's words for a mistake -> ours; the first found in the line or message counts.
_HINTS = (
    (r"^\s*\t|'\\t'", "a tab is used where YAML allows spaces only. Replace it with spaces"),
    (r"scanning an alias", "text that begins with * must be quoted, as in '*.csv'"),
    (r"character '[@`%]'", "text that begins with such a sign must be quoted"),
    (r"mapping values are not allowed", "a colon or the indentation is out of place: one `key: "
     "value` a line, keys of one section under each other, text that holds ': ' in quotes"),
    (r"quoted scalar", "a quote is opened and not closed"),
    (r"flow (sequence|mapping)", "a bracket or brace is opened and not closed, a comma is "
     "missing, or text with ? or brackets in it needs quotes, as in 'pose_?.csv'"),
    (r"", "check that each key has a colon with a space after it and stands exactly under its "
     "neighbours"),
)

LONGEST_SHOWN = 60  #: characters of a wrong value that a message repeats


def cut(text: str) -> str:
    """The beginning of a wrong value, as a message repeats it."""
    return text if len(text) <= LONGEST_SHOWN else f"{text[:LONGEST_SHOWN]}..."


def syntax_error(path: Path, text: str, error: yaml.YAMLError) -> ConfigError:
    """The error for text that cannot be parsed: its line, the likely cause, YAML's own words."""
    if isinstance(error, yaml.reader.ReaderError):
        line = text.count("\n", 0, error.position) + 1
        return ConfigError(
            f"{path}:{line}: the character {chr(int(error.character))!r} cannot stand in a YAML "
            f"file. Delete it, or save the file as plain text (UTF-8)."
        )
    assert isinstance(error, yaml.MarkedYAMLError)
    mark = error.problem_mark or error.context_mark
    line = mark.line if mark else 0
    begun = error.context_mark.line if error.context_mark else line
    words = f"{error.context or ''} {error.problem}".strip()
    row = [*text.splitlines(), ""][min(line, len(text.splitlines()))]
    hint = next(ours for theirs, ours in _HINTS
                if re.search(theirs, row) or re.search(theirs, words))
    since = "" if begun == line else f" (begun in line {begun + 1})"
    return ConfigError(f"{path}:{line + 1}: this is not YAML{since}: {hint}. YAML's own words: "
                       f"{words}.")


#: A leading digit is text if letters follow that form no number: 17rpm, not 1e3 or 0x1f.
_PLAIN = re.compile(r"(?:[1-9][0-9]*[A-DF-Za-df-z]|[A-Za-z_])[A-Za-z0-9_./-]*")
#: Plain words that YAML or a reader of it may take for something else.
_NOT_PLAIN = {"y", "n", "yes", "no", "on", "off", "true", "false", "null"}
_COLUMN = re.compile(r"column:[A-Za-z_][A-Za-z0-9_.-]*")
"""An effect of a column: a colon without a blank behind it is text."""


def yaml_word(text: str) -> str:
    """``text`` as a value or an item of a list.

    >>> yaml_word("pose_07.csv"), yaml_word("138.0-145.2 s"), yaml_word("column:fan_rpm")
    ('pose_07.csv', '"138.0-145.2 s"', 'column:fan_rpm')
    """
    plain = _PLAIN.fullmatch(text) or _COLUMN.fullmatch(text)
    if plain and text.lower() not in _NOT_PLAIN:
        return text
    return json.dumps(text, ensure_ascii=False)
