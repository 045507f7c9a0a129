"""YAML text in, plain values out, with the place in the text of every key and value.

Read event by event rather than through PyYAML's loaders, because a configuration needs

- the line of every key for messages, and the exact span of every value so that ``pipeline add``
  can edit the text with its comments kept;
- duplicate keys, anchors, aliases, tags and several documents refused rather than followed, so
  that a file of a few lines cannot expand into gigabytes or call Python;
- YAML 1.2's plain values: ``1e-3`` is a number (YAML 1.1 reads a string), ``no``, ``off`` and
  ``12:30`` are text (YAML 1.1 reads False and 750), and keys are always text (``33:`` is "33").
"""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import yaml

from pipeline.config.yaml_reader import PathTo, Span, YamlReader, path_text, syntax_error
from pipeline.errors import ConfigError

#: A session of a thousand poses listed by hand is 40 kB; this much parses in about two seconds.
LARGEST_BYTES = 200_000


@dataclass(frozen=True, eq=False)
class YamlSource:
    """A YAML file's text, its values, and where each of them stands.

    Parameters
    ----------
    path : Path
        What messages call the file.
    text : str
        The whole text; one mapping at the top level.
    values : dict
        That mapping, as plain dicts, lists, str, int, float, bool and None.
    duplicates : tuple of (int, str)
        Line and one paragraph for every key that is given twice.
    spans, key_spans : dict of path to Span
        Where each value and each mapping's key stands.
    """

    path: Path
    text: str
    values: dict[str, Any]
    duplicates: tuple[tuple[int, str], ...]
    spans: dict[PathTo, Span]
    key_spans: dict[PathTo, Span]

    def span(self, path: PathTo) -> Span:
        """Where the value at ``path`` stands; KeyError where there is none."""
        return self.spans[path]

    def value(self, path: PathTo) -> Any:
        """The value at ``path``; KeyError where there is none."""
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

    def problem(self, path: PathTo, says: str) -> str:
        """One paragraph about the value at ``path``: file, line, keys, what is wrong."""
        keys = f"{path_text(path)}: " if path else ""
        return f"{self.path}:{self.line(path)}: {keys}{says}"


def read_source(path: Path) -> YamlSource:
    """Read a YAML file.

    Raises
    ------
    ConfigError
        The file is missing, not text, too large, or not one YAML mapping.
    """
    try:
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
    reader = YamlReader(path, text)
    try:
        values = reader.document()
    except yaml.YAMLError as error:
        raise syntax_error(path, text, error) from error
    return YamlSource(path, text, values, tuple(reader.duplicates), reader.spans, reader.key_spans)
