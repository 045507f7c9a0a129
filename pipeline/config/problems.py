"""Mistakes in a configuration: where each stands and what it is; many of one kind are counted."""

from collections import defaultdict
from collections.abc import Iterable
from dataclasses import dataclass

from pipeline.config.types import MISSING_FILE
from pipeline.config.yaml_text import PathTo, YamlSource
from pipeline.errors import ConfigError, MissingFiles

SHOWN_ALIKE = 10
"""Mistakes of one kind that are written out, of more the number; chosen: they fill half a terminal,
and show how the names were meant."""

#: Kinds of mistakes in keys themselves: pydantic's name of one that it does not know, and ours of
#: one that stands twice.
UNKNOWN_KEY, DUPLICATE_KEY = "extra_forbidden", "duplicate_key"

#: Sections whose keys are names of the user's: a mistake in one entry is alike one in the next.
NAMED_BY_USER = ("rate", "effects")


@dataclass(frozen=True)
class ConfigProblem:
    """One mistake in a configuration.

    Parameters
    ----------
    path : tuple of str and int
        Keys to the value that is wrong.
    text : object
        What is wrong and what to do, as ``str`` has it. A :class:`NoSuchFile` writes its text only
        when it is shown: it looks for the name that may be meant.
    kind : str
        What sort of mistake: pydantic's name for it, or ours; empty where the keys tell it.
    line : int or None
        Where it stands, from 1; None for the line of the key at ``path``.
    """

    path: PathTo
    text: object
    kind: str = ""
    line: int | None = None


def config_error(source: YamlSource, problems: Iterable[ConfigProblem]) -> ConfigError:
    """The error for these problems, one paragraph each, in the order of the lines.

    Of mistakes of one kind at like keys the first ``SHOWN_ALIKE`` are written out, the others are
    counted. Where nothing but files is missing the error is :class:`MissingFiles`.
    """
    groups: dict[tuple[object, ...], list[tuple[int, ConfigProblem]]] = defaultdict(list)
    for problem in problems:
        line = source.line(problem.path) if problem.line is None else problem.line
        is_key = problem.kind in (UNKNOWN_KEY, DUPLICATE_KEY)
        place = _place(problem.path[:-1] if is_key else problem.path)
        groups[(problem.kind, *place)].append((line, problem))
    paragraphs = []
    for group in groups.values():
        group.sort(key=lambda entry: entry[0])
        shown, more = group[:SHOWN_ALIKE], group[SHOWN_ALIKE:]
        for line, problem in shown:
            text = f"{str(problem.text).removesuffix('.')}."
            paragraphs.append((line, source.problem(problem.path, text, line)))
        if more:
            line, first = more[0]
            paragraphs.append(
                (line, source.problem(first.path, f"and {len(more):,} more of this kind.", line)))
    only_files = {kind for kind, *_ in groups} == {MISSING_FILE}
    error = MissingFiles if only_files else ConfigError
    paragraphs.sort(key=lambda paragraph: paragraph[0])
    return error(*(text for _, text in paragraphs))


def _place(path: PathTo) -> tuple[object, ...]:
    """Keys of a mistake without positions in lists and without names of the user's."""
    is_named = path[:1] and path[0] in NAMED_BY_USER
    return tuple("*" if isinstance(key, int) or (is_named and i == 1) else key
                 for i, key in enumerate(path))
