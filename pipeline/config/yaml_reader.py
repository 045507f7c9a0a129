"""YAML's events in, plain values and their places in the text out; see :mod:`yaml_source`."""

import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import yaml

from pipeline.errors import ConfigError

Key = str | int
PathTo = tuple[Key, ...]  #: keys and list positions from the top, ("gyroscope", "runs", 0, "rate")

#: The configuration's own depth is six; deeper nesting is a mistake or an attack.
DEEPEST = 20
#: Digits; longer whole numbers are read as floats, which range checks then refuse.
LONGEST_INTEGER = 19

_INTEGER = re.compile(r"[-+]?[0-9]+")
_FLOAT = re.compile(r"[-+]?(\.[0-9]+|[0-9]+(\.[0-9]*)?)([eE][-+]?[0-9]+)?")
_WORDS: dict[str, bool | float | None] = {
    word: value
    for value, words in (
        (None, ("", "~", "null", "Null", "NULL")),
        (True, ("true", "True", "TRUE")),
        (False, ("false", "False", "FALSE")),
        (float("inf"), (".inf", ".Inf", ".INF", "+.inf")),
        (float("-inf"), ("-.inf", "-.Inf", "-.INF")),
        (float("nan"), (".nan", ".NaN", ".NAN")),
    )
    for word in words
}


@dataclass(frozen=True)
class Span:
    """Where a value stands: ``text[start:end]``, without blanks or comments after it.

    Parameters
    ----------
    start, end : int
        Positions in the text, in characters.
    line, column : int
        Of ``start``, both counted from 1.
    flow : bool
        Whether it is a list or mapping written in brackets or braces.
    """

    start: int
    end: int
    line: int
    column: int
    flow: bool = False


def path_text(path: PathTo) -> str:
    """``gyroscope.runs[1].rate``; the index of a last list item is left out."""
    keys = path[:-1] if path and isinstance(path[-1], int) else path
    return "".join(f"[{key}]" if isinstance(key, int) else f".{key}" for key in keys)[1:]


#: PyYAML's words for a mistake -> ours; the first that is found in the line or message counts.
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


def syntax_error(path: Path, text: str, error: yaml.YAMLError) -> ConfigError:
    """The error for text that is no YAML: its line, what to look for, and YAML's own words."""
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


class YamlReader:
    """Builds values from PyYAML's events and notes the spans as it goes."""

    def __init__(self, path: Path, text: str) -> None:
        self.path = path
        self.events: Iterator[yaml.Event] = yaml.parse(text, Loader=yaml.SafeLoader)
        self.duplicates: list[tuple[int, str]] = []
        self.spans: dict[PathTo, Span] = {}
        self.key_spans: dict[PathTo, Span] = {}

    def error(self, event: yaml.Event, says: str) -> ConfigError:
        """The error for what begins with ``event``."""
        return ConfigError(f"{self.path}:{_span(event, 0).line}: {says}")

    def document(self) -> dict[str, Any]:
        """The one mapping of the text."""
        next(self.events)  # stream start
        if isinstance(event := next(self.events), yaml.StreamEndEvent):
            raise self.error(event, "the file is empty. `pipeline init` writes a template.")
        value, _ = self.node(event := next(self.events), ())
        if not isinstance(value, dict):
            found = "a list" if isinstance(value, list) else f"the text '{value}'"
            raise self.error(event, f"found {found} at the top level; keys with values are "
                             "expected, such as `sensor: xsens-mti`. `pipeline init` writes a "
                             "template.")
        next(self.events)  # document end
        if not isinstance(event := next(self.events), yaml.StreamEndEvent):
            raise self.error(event, "a second document begins here ('---'); one configuration per "
                             "file is expected. Delete it or move it to a file of its own.")
        return value

    def node(self, event: yaml.Event, path: PathTo) -> tuple[Any, int]:
        """The value that begins with ``event``, and where its text ends."""
        self.refuse_machinery(event)
        if len(path) > DEEPEST:
            raise self.error(event, f"values are nested deeper than {DEEPEST} levels. Check the "
                             "brackets and the indentation.")
        value: Any
        if isinstance(event, yaml.MappingStartEvent):
            value, end = self.mapping(event, path)
        elif isinstance(event, yaml.SequenceStartEvent):
            value, end = self.sequence(event, path)
        else:
            assert isinstance(event, yaml.ScalarEvent)
            value, end = _scalar(event), _end(event)
        self.spans[path] = _span(event, end)
        return value, end

    def refuse_machinery(self, event: yaml.Event) -> None:
        """Raise on what could expand without bound or name a Python object."""
        tag = getattr(event, "tag", None)
        if isinstance(event, yaml.AliasEvent) or getattr(event, "anchor", None):
            raise self.error(event, "anchors (&) and aliases (*) are not allowed in a "
                             "configuration. Write the value out, or quote the text if it begins "
                             "with such a sign.")
        if tag not in (None, "!"):
            raise self.error(event, f"the tag '{tag}' is not allowed in a configuration. "
                             "Delete it, or quote the text.")

    def mapping(self, start: yaml.MappingStartEvent, path: PathTo) -> tuple[dict[str, Any], int]:
        """A mapping; a key given twice is noted, and its first value kept."""
        values: dict[str, Any] = {}
        end = _end(start)
        while not isinstance(event := next(self.events), yaml.MappingEndEvent):
            self.refuse_machinery(event)
            if not isinstance(event, yaml.ScalarEvent):
                raise self.error(event, "a list or mapping stands where a key is expected. A key "
                                 "is plain text, such as `sensor:`.")
            at, key_span = (*path, event.value), _span(event, _end(event))
            if event.value in values:
                self.duplicates.append((key_span.line, (
                    f"{self.path}:{key_span.line}: {path_text(at)}: the key '{event.value}' is "
                    f"given twice, first in line {self.key_spans[at].line}. Delete one of the two."
                )))
                at = (*path, f"{event.value} (line {key_span.line})")
            self.key_spans[at] = key_span
            value, end = self.node(next(self.events), at)
            values.setdefault(event.value, value)
        return values, _end(event) if start.flow_style else end

    def sequence(self, start: yaml.SequenceStartEvent, path: PathTo) -> tuple[list[Any], int]:
        """A list."""
        values: list[Any] = []
        end = _end(start)
        while not isinstance(event := next(self.events), yaml.SequenceEndEvent):
            value, end = self.node(event, (*path, len(values)))
            values.append(value)
        return values, _end(event) if start.flow_style else end


def _scalar(event: yaml.ScalarEvent) -> str | int | float | bool | None:
    """The value of a scalar by YAML 1.2's core rules; quoted and block text is always text."""
    text = str(event.value)
    if event.style is not None:
        return text
    if text in _WORDS:
        return _WORDS[text]
    if _INTEGER.fullmatch(text) and len(text) < LONGEST_INTEGER:
        return int(text)
    return float(text) if _FLOAT.fullmatch(text) else text


def _span(event: yaml.Event, end: int) -> Span:
    mark = event.start_mark
    assert mark is not None  # parsed from text, which marks every event
    flow = bool(getattr(event, "flow_style", False))
    return Span(mark.index, end, mark.line + 1, mark.column + 1, flow)


def _end(event: yaml.Event) -> int:
    assert event.end_mark is not None
    return event.end_mark.index
