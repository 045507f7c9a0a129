"""Names as they stand in YAML: plain where YAML reads them as text, else in quotation marks."""

import json
import re

#: A digit in front is text where letters follow that make no number: 17rpm, not 1e3 or 0x1f.
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
