"""Messages on the values of a configuration: what is wrong, where, and what was expected."""

import re
from collections import defaultdict
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Any

from pydantic import ValidationError
from pydantic_core import ErrorDetails

from pipeline.config.rules import broken_rules, empty_keys
from pipeline.config.types import MISSING_FILE, REFUSED, ValidationContext
from pipeline.config.units import UNITS, converted, same_quantity, split_unit
from pipeline.config.yaml_syntax import cut
from pipeline.config.yaml_text import PathTo, YamlSource
from pipeline.errors import ConfigError, MissingFiles
from pipeline.text.names import nearest_names

SHOWN_ALIKE = 10
"""Number of mistakes of one kind that are written out, of more the count; chosen: they fill half a
terminal, and show how the names were meant."""

#: Kinds of mistakes in keys themselves: pydantic's name for an unknown key, and ours for a
#: duplicate.
UNKNOWN_KEY, DUPLICATE_KEY = "extra_forbidden", "duplicate_key"

#: Sections whose keys are the user's names: a mistake in one entry is like one in the next.
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

    Of mistakes of one kind at similar keys the first ``SHOWN_ALIKE`` are written out, the others
    are counted. If only files are missing, the error is :class:`MissingFiles`.
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
    """Keys of a mistake without positions in lists and without the user's names."""
    is_named = path[:1] and path[0] in NAMED_BY_USER
    return tuple("*" if isinstance(key, int) or (is_named and i == 1) else key
                 for i, key in enumerate(path))


#: pydantic's kinds of error -> what was expected, filled from the error's own figures.
EXPECTED = {
    "float_type": "a number",
    "int_type": "a whole number",
    "int_from_float": "a whole number",
    "string_type": "text",
    "tuple_type": "a list",
    "dict_type": "keys with values, one a line and indented",
    "model_type": "keys with values, one a line and indented",
    "model_attributes_type": "keys with values, one a line and indented",
    "finite_number": "a finite number",
    "greater_than": "a number greater than {gt}",
    "greater_than_equal": "a number of at least {ge}",
    "less_than_equal": "a number of at most {le}",
    "literal_error": "{expected}",
    "too_short": "at least {min_length} entries",
    "too_long": "at most {max_length} entries",
}


def problems_in(
    source: YamlSource, error: ValidationError | None, context: ValidationContext
) -> Iterator[ConfigProblem]:
    """Every mistake in the values of a file, once.

    Parameters
    ----------
    source : YamlSource
        The file.
    error : ValidationError or None
        What pydantic found.
    context : ValidationContext
        Of the validation, with the keys that each mapping may have.
    """
    details = error.errors(include_url=False) if error else []
    unknown = [_path_in_file(source, detail) for detail in details if detail["type"] == UNKNOWN_KEY]
    meant = {path: _meant_by(source, path, context) for path in unknown}
    # A key that is present under a wrong name is not missing as well.
    misnamed = {(*path[:-1], key) for path, keys in meant.items() for key in keys}

    told: set[PathTo] = set()
    for path, problem in (*empty_keys(source.values), *broken_rules(source.values)):
        if path not in misnamed and path not in told:
            told.add(path)
            yield ConfigProblem(path, problem)
    for detail in details:
        path = _path_in_file(source, detail)
        if _only_seems_short(detail) or path in misnamed or path in told:
            continue
        told.add(path)
        if path in meant:
            yield ConfigProblem(path, _unknown_key(source, path, meant[path], context), UNKNOWN_KEY)
        else:
            yield ConfigProblem(path, _wrong_value(detail), detail["type"])
    for path, first, other in source.duplicates:
        text = f"the key '{path[-1]}' is given twice, first in line {first}. Delete one of the two"
        yield ConfigProblem(path, text, DUPLICATE_KEY, other)


def _path_in_file(source: YamlSource, detail: ErrorDetails) -> PathTo:
    """The error's place as keys of the file.

    pydantic's own place also names members of unions and fields with a short form in the file;
    these are left out. A missing key stays, as the last one.
    """
    path: PathTo = ()
    for key in detail["loc"]:
        if (*path, key) in source.spans:
            path = (*path, key)
    return (*path, detail["loc"][-1]) if detail["type"] == "missing" else path


def _only_seems_short(detail: ErrorDetails) -> bool:
    """Whether a list is long enough as written: pydantic counts only its valid entries."""
    return (detail["type"] == "too_short" and isinstance(detail["input"], list)
            and len(detail["input"]) >= detail["ctx"]["min_length"])


def _keys_at(source: YamlSource, path: PathTo, context: ValidationContext) -> tuple[str, ...]:
    """The keys that the mapping around ``path`` may have."""
    return context.keys_of[id(source.value(path[:-1]))]


def _meant_by(source: YamlSource, path: PathTo, context: ValidationContext) -> list[str]:
    """The right keys that an unknown one may mean: another unit, or a typing error."""
    wrong, right = str(path[-1]), _keys_at(source, path, context)
    return same_quantity(wrong, right) or nearest_names(wrong, right)


def _unknown_key(
    source: YamlSource, path: PathTo, meant: list[str], context: ValidationContext
) -> str:
    """Message on an unknown key, and the key that is expected."""
    wrong, right = str(path[-1]), _keys_at(source, path, context)
    others = ", ".join(right)
    if not same_quantity(wrong, right):
        near = f" (did you mean '{meant[0]}'?)" if meant else ""
        return f"no key is named '{wrong}' here{near}; there are: {others}"
    if not split_unit(wrong)[1]:
        return f"the key '{wrong}' lacks its unit; write {' or '.join(meant)}"
    factor = converted(1.0, wrong, meant[0])
    value = source.value(path)
    now = (f", here `{meant[0]}: {converted(value, wrong, meant[0]):.7g}`"
           if isinstance(value, int | float) else "")
    return (f"the key '{wrong}' has a unit that is not accepted here; write {meant[0]} = "
            f"{factor:.7g} × {wrong}{now}")


def _wrong_value(detail: ErrorDetails) -> object:
    """The found and the expected value; :class:`ConfigProblem` converts it to text."""
    kind, limits = detail["type"], detail.get("ctx", {})
    if kind == "missing":
        key = detail["loc"][-1]
        return f"entry {key + 1} is missing" if isinstance(key, int) else "is missing; add it"
    if kind == MISSING_FILE:
        return detail["input"]
    if kind == REFUSED:
        return detail["msg"]
    shown = _shown(detail["input"])
    expected = EXPECTED[kind].format(**limits) if kind in EXPECTED else detail["msg"]
    if kind == "literal_error" and (meant := _meant_word(detail["input"], expected)):
        expected += f" (did you mean '{meant[0]}'?)"
    if kind == "string_type" and not isinstance(detail["input"], list | dict):
        expected += f"; put it in quotes, as in '{shown}'"
    return f"found {shown}, expected {expected}"


def _meant_word(wrong: object, expected: str) -> list[str]:
    """Words quoted in ``expected`` that mean the unit of ``wrong``, or else are spelt alike."""
    words = re.findall("'([^']+)'", expected)
    if not isinstance(wrong, str):
        return []
    unit = UNITS.get(wrong)
    return [each for each in words if unit and UNITS.get(each) == unit] or nearest_names(
        wrong, words)


def _shown(value: Any) -> str:
    """A wrong value as the message repeats it."""
    if isinstance(value, list | tuple):
        return f"a list of {len(value)}"
    if isinstance(value, dict):
        return "keys with values"
    return cut(str(value).lower() if isinstance(value, bool) else repr(value))
