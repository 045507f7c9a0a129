"""Edits of a configuration: an effect more or less in a model, further files, entries of a section.

Only the characters of these change; comments, order and layout of the file stay.
"""

from collections.abc import Sequence

from pipeline.config.yaml_syntax import yaml_word
from pipeline.config.yaml_text import PathTo, YamlSource

Splice = tuple[int, int, str]
"""Start and end of a replaced text, positions in characters, and its replacement."""


def add_item(
    source: YamlSource, section: PathTo, name: str, default: Sequence[str], remark: str = ""
) -> str:
    """The text with ``name`` at the end of the list ``model`` of ``section``.

    Where the section has no such list, one is written that starts from ``default``. A ``remark``
    becomes a comment at the end of the line, unless that ends on one already.
    """
    start, end, new = _new_item(source, section, yaml_word(name), [*map(yaml_word, default)])
    text = _spliced(source.text, start, end, new)
    where = start + len(new.rstrip())
    end = _line_end(text, where)
    has_comment = "#" in text[text.rfind("\n", 0, where) + 1 : end]
    return text if has_comment or not remark else _spliced(text, end, end, f"  # {remark}")


def _new_item(
    source: YamlSource, section: PathTo, name: str, default: Sequence[str]
) -> Splice:
    path = (*section, "model")
    whole = f"[{', '.join([*default, name])}]"
    if path not in source.spans:
        return _new_key(source, section, f"model: {whole}")
    items, span = source.value(path), source.span(path)
    if not isinstance(items, list) or not items:
        return span.start, span.end, whole
    return _appended(source, path, [name])


def _appended(source: YamlSource, path: PathTo, words: Sequence[str]) -> Splice:
    """The list at ``path`` with more items at its end, in its own layout."""
    last = source.span((*path, len(source.value(path)) - 1))
    if source.span(path).flow:
        return last.end, last.end, "".join(f", {word}" for word in words)
    bullet = source.text[source.text.rindex("\n", 0, last.start) + 1 : last.start]
    end = _line_end(source.text, last.end)
    return end, end, "".join(f"\n{bullet}{word}" for word in words)


def extend_list(source: YamlSource, path: PathTo, words: Sequence[str]) -> str:
    """The text with more items, as YAML writes each, in the list at ``path``; one value alone
    becomes a list."""
    if isinstance(source.value(path), list):
        return _spliced(source.text, *_appended(source, path, words))
    span = source.span(path)
    items = [source.text[span.start : span.end], *words]
    return _spliced(source.text, span.start, span.end, f"[{', '.join(items)}]")


def add_entry(source: YamlSource, section: str, name: str, definition: str) -> str:
    """The text with one more entry, ``name: definition``, in a section of the file."""
    entry = f"{yaml_word(name)}: {definition}"
    if (section,) in source.spans and not source.value((section,)):
        span = source.span((section,))
        return _spliced(source.text, span.start, span.end, f"{{{entry}}}")
    if (section,) not in source.spans:
        body = source.text if source.text.endswith("\n") else f"{source.text}\n"
        return f"{body}{section}:\n  {entry}\n"
    return _spliced(source.text, *_new_key(source, (section,), entry))


def remove_item(source: YamlSource, section: PathTo, name: str) -> str:
    """The text with ``name`` removed from the list ``model`` of ``section``."""
    path = (*section, "model")
    items = source.value(path)
    i = items.index(name)
    item = source.span((*path, i))
    if not source.span(path).flow:
        start = source.text.rindex("\n", 0, item.start)
        return _spliced(source.text, start, _line_end(source.text, item.end), "")
    if i > 0:
        return _spliced(source.text, source.span((*path, i - 1)).end, item.end, "")
    after = source.span((*path, 1)).start if len(items) > 1 else item.end
    return _spliced(source.text, item.start, after, "")


def set_list(source: YamlSource, section: PathTo, key: str, items: Sequence[str]) -> str:
    """The text with ``key`` of ``section`` set to a list of ``items``, as YAML writes each."""
    listed = f"[{', '.join(items)}]"
    if (*section, key) not in source.spans:
        return _spliced(source.text, *_new_key(source, section, f"{key}: {listed}"))
    span = source.span((*section, key))
    return _spliced(source.text, span.start, span.end, listed)


def _new_key(source: YamlSource, section: PathTo, listed: str) -> Splice:
    span = source.span(section)
    if span.flow:  # {poses: a_*.csv} -> {poses: a_*.csv, model: [...]}
        end = source.text.rindex("}", span.start, span.end)
        return len(source.text[:end].rstrip()), end, f", {listed}"
    first = min(
        (s for path, s in source.key_spans.items() if path[:-1] == section), key=lambda s: s.start
    )
    column = first.start - source.text.rfind("\n", 0, first.start) - 1  # after "- " too
    return first.start, first.start, f"{listed}\n{' ' * column}"


def _line_end(text: str, position: int) -> int:
    end = text.find("\n", position)
    return len(text) if end < 0 else end


def _spliced(text: str, start: int, end: int, new: str) -> str:
    return text[:start] + new + text[end:]
