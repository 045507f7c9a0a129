"""Edits of a configuration: an effect more or less in a model, further files, entries of a section.

Only the characters of these change; comments, order and layout of the file stay. Each edit gives
the file as it would be.
"""

from collections.abc import Sequence

from pipeline.config.yaml_syntax import yaml_word
from pipeline.config.yaml_text import PathTo, YamlSource, parse_source

Splice = tuple[int, int, str]
"""Start and end of a replaced text, positions in characters, and its replacement."""


def add_item(
    source: YamlSource, section: PathTo, name: str, default: Sequence[str], remark: str = ""
) -> YamlSource:
    """The file with ``name`` at the end of the list ``model`` of ``section``.

    Where the section has no such list, one is written that starts from ``default``. A ``remark``
    becomes a comment at the end of the line, unless that ends on one already. A ConfigError says
    where the file would be no YAML, as in the other edits.
    """
    start, end, new = _new_item(source, section, yaml_word(name), [*map(yaml_word, default)])
    changed = _spliced(source, start, end, new)
    where = start + len(new.rstrip())
    end = _line_end(changed.text, where)
    has_comment = "#" in changed.text[changed.text.rfind("\n", 0, where) + 1 : end]
    return changed if has_comment or not remark else _spliced(changed, end, end, f"  # {remark}")


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


def extend_list(source: YamlSource, path: PathTo, words: Sequence[str]) -> YamlSource:
    """The file with more items, as YAML writes each, in the list at ``path``; one value alone
    becomes a list. A ConfigError says where that would be no YAML.
    """
    if isinstance(source.value(path), list):
        return _spliced(source, *_appended(source, path, words))
    span = source.span(path)
    items = [source.text[span.start : span.end], *words]
    return _spliced(source, span.start, span.end, f"[{', '.join(items)}]")


def add_entry(source: YamlSource, section: str, name: str, definition: str) -> YamlSource:
    """The file with one more entry, ``name: definition``, in a section of the file.

    A ConfigError says where that would be no YAML.
    """
    entry = f"{yaml_word(name)}: {definition}"
    if (section,) in source.spans and not source.value((section,)):
        span = source.span((section,))
        return _spliced(source, span.start, span.end, f"{{{entry}}}")
    if (section,) not in source.spans:
        end, line_end = len(source.text), "" if source.text.endswith("\n") else "\n"
        return _spliced(source, end, end, f"{line_end}{section}:\n  {entry}\n")
    return _spliced(source, *_new_key(source, (section,), entry))


def remove_item(source: YamlSource, section: PathTo, name: str) -> YamlSource:
    """The file with ``name`` removed from the list ``model`` of ``section``.

    A ConfigError says where that would be no YAML.
    """
    path = (*section, "model")
    items = source.value(path)
    i = items.index(name)
    item = source.span((*path, i))
    if not source.span(path).flow:
        start = source.text.rindex("\n", 0, item.start)
        return _spliced(source, start, _line_end(source.text, item.end), "")
    if i > 0:
        return _spliced(source, source.span((*path, i - 1)).end, item.end, "")
    after = source.span((*path, 1)).start if len(items) > 1 else item.end
    return _spliced(source, item.start, after, "")


def set_excluded(source: YamlSource, section: PathTo, names: Sequence[str]) -> YamlSource:
    """The file with ``exclude`` of ``section`` set to a list of ``names``, as YAML writes each.

    A ConfigError says where that would be no YAML.
    """
    listed = f"[{', '.join(names)}]"
    if (*section, "exclude") not in source.spans:
        return _spliced(source, *_new_key(source, section, f"exclude: {listed}"))
    span = source.span((*section, "exclude"))
    return _spliced(source, span.start, span.end, listed)


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


def _spliced(source: YamlSource, start: int, end: int, new: str) -> YamlSource:
    return parse_source(source.path, source.text[:start] + new + source.text[end:])
