"""From YAML text to plain values, with the place in the text of every key and value.

PyYAML composes the text to nodes, which know their places; the values are taken from the nodes
here and not by PyYAML's own constructor, because a configuration needs

- the line of every key for messages, and the exact span of every value so that ``pipeline add``
  can edit the text with its comments kept;
- duplicate keys, anchors, aliases, tags and several documents refused rather than followed, so
  that a file of a few lines cannot expand into gigabytes or call Python;
- YAML 1.2's plain values: ``1e-3`` is a number (YAML 1.1 reads a string), ``no``, ``off`` and
  ``12:30`` are text (YAML 1.1 reads False and 750), and keys are always text (``33:`` is "33").
"""

import re
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import yaml

from pipeline.config.yaml_syntax import cut, syntax_error
from pipeline.errors import ConfigError
from pipeline.files import may_never_end

Key = str | int
PathTo = tuple[Key, ...]  #: keys and list positions from the top, ("gyroscope", "runs", 0, "rate")

#: A session of a thousand poses listed by hand is 40 kB; this much parses in a third of a second.
LARGEST_BYTES = 200_000
#: The configuration's own depth is six; deeper nesting is a mistake or an attack.
DEEPEST = 20
#: Digits; longer whole numbers are read as floats, which range checks then refuse.
LONGEST_INTEGER = 19

HALF_CHARACTER = re.compile("[\ud800-\udfff]")
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
    """Location of a value: ``text[start:end]``, without blanks or comments after it.

    Parameters
    ----------
    start, end : int
        Positions in the text, in characters.
    line : int
        Of ``start``, counted from 1.
    flow : bool
        Whether it is a list or mapping written in brackets or braces.
    """

    start: int
    end: int
    line: int
    flow: bool = False


def path_text(path: PathTo) -> str:
    """``gyroscope.runs[1].rate``; the index of a last list item is left out."""
    keys = path[:-1] if path and isinstance(path[-1], int) else path
    return "".join(f"[{key}]" if isinstance(key, int) else f".{key}" for key in keys)[1:]


@dataclass(frozen=True, eq=False)
class YamlSource:
    """A YAML file's text, its values, and the location of each.

    Parameters
    ----------
    path : Path
        What messages call the file.
    text : str
        The whole text; one mapping at the top level.
    values : dict
        That mapping, as plain dicts, lists, str, int, float, bool and None.
    duplicates : tuple of (path, int, int)
        Every key that is given twice: its path, and the lines of the first and the other.
    spans, key_spans : dict of path to Span
        Where each value and each mapping's key stands.
    """

    path: Path
    text: str
    values: dict[str, Any]
    duplicates: tuple[tuple[PathTo, int, int], ...]
    spans: dict[PathTo, Span]
    key_spans: dict[PathTo, Span]

    def span(self, path: PathTo) -> Span:
        """Location of the value at ``path``; KeyError without a value."""
        return self.spans[path]

    def value(self, path: PathTo) -> Any:
        """The value at ``path``; KeyError without a value."""
        value: Any = self.values
        for key in path:
            value = value[key]
        return value

    def line(self, path: PathTo) -> int:
        """The line, from 1, of the key at ``path``, or of its nearest ancestor in the file."""
        while path and path not in self.spans:
            path = path[:-1]
        if not path:
            return 1
        return (self.key_spans.get(path) or self.spans[path]).line

    def problem(self, path: PathTo, text: str, line: int | None = None) -> str:
        """One paragraph about the value at ``path``: file, line, keys, what is wrong."""
        keys = f"{path_text(path)}: " if path else ""
        return f"{self.path}:{self.line(path) if line is None else line}: {keys}{text}"


def read_source(path: Path) -> YamlSource:
    """Read a YAML file.

    Raises
    ------
    ConfigError
        The file is missing, not text, too large, or not one YAML mapping.
    """
    try:
        if may_never_end(path):
            raise ConfigError(f"{path}: is a pipe or a device; a YAML file is expected.")
        with path.open("rb") as file:
            data = file.read(LARGEST_BYTES + 1)
    except OSError as error:
        raise ConfigError(
            f"{path}: the configuration cannot be read ({error.strerror}). Name an existing file, "
            f"or write a new one with `pipeline init`."
        ) from error
    if len(data) > LARGEST_BYTES:
        raise ConfigError(
            f"{path}: larger than {LARGEST_BYTES // 1000} kB, which no configuration is. Is this "
            f"a log? Name the YAML file, and in it files by patterns such as pose_*.csv."
        )
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = data.count(b"\n", 0, error.start) + 1
        raise ConfigError(
            f"{path}:{line}: byte 0x{data[error.start]:02x} is not UTF-8 text. Save the file as "
            f"UTF-8 (in Notepad: Save as, Encoding)."
        ) from error
    return parse_source(path, text)


def parse_source(path: Path, text: str) -> YamlSource:
    """Parse the text of a YAML file; ``path`` is only its name in messages.

    Raises
    ------
    ConfigError
        The text is not one YAML mapping, or uses what a configuration must not: anchors,
        aliases, tags, several documents, keys that are not plain text.
    """
    try:
        root = _root(text)
        reader = _NodeReader()
        values = reader.mapping(root, ())
    except _Refused as error:
        raise ConfigError(f"{path}:{error.line}: {error}") from error
    except yaml.YAMLError as error:
        raise syntax_error(path, text, error) from error
    return YamlSource(path, text, values, tuple(reader.duplicates), reader.spans, reader.key_spans)


class _Refused(Exception):
    """YAML that no configuration may use, at a mark."""

    def __init__(self, mark: yaml.Mark, reason: str) -> None:
        super().__init__(reason)
        self.line = mark.line + 1


class _Loader(yaml.SafeLoader):
    """Composes nodes; refuses what could expand without bound or name a Python object."""

    depth = 0

    def compose_node(self, parent: yaml.Node | None, index: int) -> yaml.Node | None:
        event: Any = self.peek_event()  # type: ignore[no-untyped-call]
        mark, tag = event.start_mark, getattr(event, "tag", None)
        if event.anchor is not None:
            raise _Refused(mark, "anchors (&) and aliases (*) are not allowed in a configuration. "
                           "Write the value out, or quote the text if it begins with such a sign.")
        if tag not in (None, "!"):
            raise _Refused(mark, f"the tag '{tag}' is not allowed in a configuration. Delete it, "
                           "or quote the text.")
        if self.depth > DEEPEST:
            raise _Refused(mark, f"values are nested deeper than {DEEPEST} levels. Check the "
                           "brackets and the indentation.")
        self.depth += 1
        node = super().compose_node(parent, index)
        self.depth -= 1
        return node


def _root(text: str) -> yaml.MappingNode:
    """The one mapping of the text."""
    loader = _Loader(text)
    try:
        if not loader.check_node():
            raise _Refused(loader.get_mark(), "the file is empty. `pipeline init` writes a "
                           "template.")
        root: Any = loader.get_node()
        if not isinstance(root, yaml.MappingNode):
            kind = ("a list" if isinstance(root, yaml.SequenceNode) else
                    f"the text '{cut(root.value)}'")
            raise _Refused(root.start_mark, f"found {kind} at the top level; keys with values "
                           "are expected, such as `sensor: xsens-mti`. `pipeline init` writes a "
                           "template, and `pipeline import LOG` a configuration for logs.")
        if loader.check_node():
            event: Any = loader.peek_event()  # type: ignore[no-untyped-call]
            raise _Refused(event.start_mark, "a second document begins here "
                           "('---'); one configuration per file is expected. Delete it or move it "
                           "to a file of its own.")
    finally:
        loader.dispose()
    return root


class _NodeReader:
    """Builds plain values from nodes and notes their spans."""

    def __init__(self) -> None:
        self.duplicates: list[tuple[PathTo, int, int]] = []
        self.spans: dict[PathTo, Span] = {}
        self.key_spans: dict[PathTo, Span] = {}

    def value(self, node: yaml.Node, path: PathTo) -> Any:
        """The value of a node."""
        if isinstance(node, yaml.MappingNode):
            return self.mapping(node, path)
        if isinstance(node, yaml.SequenceNode):
            values = [self.value(child, (*path, i)) for i, child in enumerate(node.value)]
            self.note_block(node, path, (*path, len(values) - 1))
            return values
        assert isinstance(node, yaml.ScalarNode)
        self.spans[path] = _span(node)
        return _scalar(node)

    def mapping(self, node: yaml.MappingNode, path: PathTo) -> dict[str, Any]:
        """A mapping; a key given twice is noted, and its first value kept."""
        values: dict[str, Any] = {}
        at = path
        for key, child in node.value:
            if not isinstance(key, yaml.ScalarNode):
                raise _Refused(key.start_mark, "a list or mapping stands where a key is expected. "
                               "A key is plain text, such as `sensor:`.")
            at, span = (*path, key.value), _span(key)
            if key.value in values:
                self.duplicates.append((at, self.key_spans[at].line, span.line))
                at = (*path, f"{key.value} (line {span.line})")
            self.key_spans[at] = span
            values.setdefault(key.value, self.value(child, at))
        self.note_block(node, path, at)
        return values

    def note_block(self, node: yaml.CollectionNode, path: PathTo, last: PathTo) -> None:
        """Record a collection's span; without brackets it ends where its last item ends."""
        span = _span(node)
        ends_with_item = node.value and not node.flow_style  # the mark is that of the next text
        self.spans[path] = replace(span, end=self.spans[last].end) if ends_with_item else span


def _scalar(node: yaml.ScalarNode) -> str | int | float | bool | None:
    """The value of a scalar by YAML 1.2's core rules; quoted and block text is always text."""
    text = str(node.value)
    if HALF_CHARACTER.search(text):
        raise _Refused(node.start_mark, "half a character (\\ud800 to \\udfff) cannot be written.")
    if node.style is not None:
        return text
    if text in _WORDS:
        return _WORDS[text]
    if _INTEGER.fullmatch(text) and len(text) < LONGEST_INTEGER:
        return int(text)
    return float(text) if _FLOAT.fullmatch(text) else text


def _span(node: yaml.Node) -> Span:
    mark, flow = node.start_mark, bool(getattr(node, "flow_style", False))
    return Span(mark.index, node.end_mark.index, mark.line + 1, flow)
