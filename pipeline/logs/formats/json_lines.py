"""JSON: lines with one object per sample, lists of such objects (also in an object), and columns.

A dictionary printed by Python is read like a line of JSON.
"""

import ast
import json
import re
from collections.abc import Iterator, Sequence
from contextlib import suppress
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from calib.poses.imu_log import AXES
from pipeline.errors import UnreadableInput
from pipeline.logs.dialect import NUMPY, is_number, seconds_of
from pipeline.logs.formats.file_table import FileTable
from pipeline.logs.header_words import read_name
from pipeline.logs.row_kinds import LEAST_TURNS, MOST_KINDS

INTERVAL = re.compile(r"(?:interval|period)_(us|ms|s)$")  #: time from row to row
ALIKE = 0.5
"""Least share of the names of two objects that both have if they are samples of one table. A
judgement: a temperature that comes now and then is one of eight, a time and a state two of nine."""
FEWEST_ROWS = 3  #: least number of rows that show that each holds several samples


def tables(path: Path) -> list[FileTable]:
    """A table of the numbers that every object has, with nested lists and objects flattened.

    An object with several lists of objects gives a table for each list.
    """
    text = path.read_text(encoding="utf-8-sig")
    with suppress(json.JSONDecodeError):
        value = json.loads(text, object_hook=_without_numbers)
        if recordings := [*_recordings(value)]:
            return [table for name, rows in recordings for table in _table(name, rows)]
        lists = {name: inner for name, inner in value.items() if isinstance(inner, list)
                 and inner and isinstance(inner[0], dict)} if isinstance(value, dict) else {}
        if len(lists) > 1:
            return [table for name, inner in lists.items() for table in _table(name, inner)]
        return _table(path.stem, [*_rows(value)])
    return _table(path.stem, [*_samples(path, text)])


def _without_numbers(value: dict[str, Any]) -> Any:
    """The values of an object whose names only number them, as pandas writes a column."""
    are_numbered = len(value) >= FEWEST_ROWS and all(map(str.isdecimal, value))
    return [*value.values()] if are_numbered else value


def _recordings(value: Any) -> Iterator[tuple[str, list[Any]]]:
    """The name and the samples of each object in a list of recordings, as poses are.

    Each has a text of its own and one list of samples, whose columns may be named beside it.
    """
    inside = _flat(value) if isinstance(value, dict) else {"": value}
    for objects in inside.values():
        if not (isinstance(objects, list) and len(objects) > 1
                and all(isinstance(one, dict) for one in objects)):
            continue
        lists = [[rows for rows in one.values() if isinstance(rows, list) and rows
                  and isinstance(rows[0], dict | list)] for one in objects]
        key = next((key for key in objects[0] if len(objects) == len({
            text for one in objects if isinstance(text := one.get(key), str)
            and seconds_of(text) is None})), None)
        for one, samples in zip(objects, lists, strict=True):
            if key is None or any(len(each) != 1 for each in lists):
                break
            names = next((named for each in inside.values() if isinstance(each, list)
                          and each is not objects
                          and len(named := _names(each)) == len(samples[0][0])), ())
            yield one[key].replace("/", "-"), [
                dict(zip(names, row, strict=True)) if isinstance(row, list) and len(row) == len(
                    names) else row for row in samples[0]]


def _table(name: str, rows: list[Any]) -> list[FileTable]:
    """The tables of rows: one, or one for each kind that a text in the rows names, or none."""
    rows = [_flat(row) if isinstance(row, dict) else row for row in rows]
    words = [key for key in (rows[0] if rows and isinstance(rows[0], dict) else ())
             if all(isinstance(row, dict) and isinstance(row.get(key), str) for row in rows)]
    for key in words:
        kinds = list(dict.fromkeys(row[key] for row in rows))
        turns = sum(one[key] != other[key] for one, other in pairwise(rows))
        keys = {(row[key], *row) for row in rows}  # each kind has keys of its own
        if 1 < len(kinds) <= MOST_KINDS and (turns > LEAST_TURNS * len(rows) or (
                len(keys) == len(kinds) == len({names[1:] for names in keys}))):
            return [table for kind in kinds for table in _table(
                kind, [{**row, key: None} for row in rows if row[key] == kind])]
    samples = [dict(_numbers("", sample)) for sample in _unrolled(rows)]
    shapes = _shapes(samples)
    tables = [FileTable(f"{name}{f' {i}' if shapes[1:] else ''}", {
        key: np.array([sample[key] for sample in shape]) for key in shape[0]
        if all(key in sample for sample in shape)}) for i, shape in enumerate(shapes, 1)]
    return [table for table in tables if table.columns]


def _shapes(samples: Sequence[dict[str, float]]) -> list[list[dict[str, float]]]:
    """Samples by their shape: a message of a battery between them has hardly a number in common.

    The most frequent shape comes first; one that shares most of its numbers joins it.
    """
    rows: dict[tuple[str, ...], list[int]] = {}
    for i, sample in enumerate(samples):
        rows.setdefault(tuple(sample), []).append(i)
    kinds: dict[tuple[str, ...], list[int]] = {}
    for keys in sorted(rows, key=lambda keys: -len(rows[keys])):
        like = next((kind for kind in kinds if len({*kind} & {*keys}) >= ALIKE * len(
            {*kind, *keys})), keys)
        kinds.setdefault(like, []).extend(rows[keys])
    return [[samples[i] for i in sorted(those)] for those in kinds.values()]


def _samples(path: Path, text: str) -> Iterator[Any]:
    for number, line in enumerate(text.splitlines(), 1):
        try:
            if line.strip():
                yield _object(line)
        except json.JSONDecodeError as error:
            raise UnreadableInput(f"{path}:{number}: is no JSON ({error.msg}). One object per "
                                  "line is expected; delete the damaged line.") from error


def _object(line: str) -> Any:
    """The value of a line, in JSON or in the format in which Python prints a dictionary."""
    try:
        return json.loads(line)
    except json.JSONDecodeError:
        with suppress(ValueError, SyntaxError, MemoryError, RecursionError):
            return ast.literal_eval(NUMPY.sub(r"\1", line.strip()))
        raise


def _rows(value: Any) -> Iterator[Any]:
    """The samples in a list, in the longest list of an object, or in an object's columns."""
    if not isinstance(value, dict):
        yield from value
        return
    inside = {name: inner for name, inner in _flat(value).items()
              if isinstance(inner, list) and inner}
    samples = [inner for inner in inside.values() if isinstance(inner[0], dict | list)]
    columns = {name: inner for name, inner in inside.items()
               if not isinstance(inner[0], dict | list)}
    rows = max(map(len, columns.values()), default=0)
    long = {name: column for name, column in columns.items() if len(column) == rows}
    if len(long) >= len(AXES):
        yield from (dict(zip(long, row, strict=True)) for row in zip(*long.values(), strict=True))
        return
    longest = max(samples, key=len, default=[])
    if not longest:
        yield value
        return
    names = next((named for inner in inside.values()
                  if len(named := _names(inner)) == len(longest[0])), None)
    if names is None and isinstance(longest[0], list) and not any(
            is_number(str(cell)) for cell in longest[0]):
        names, *longest = longest  # a table of a spreadsheet
    steps = {f"time_{match[1]}": step for key, step in _flat(value).items()
             if (match := INTERVAL.search(key)) and isinstance(step, int | float)}
    for i, row in enumerate(longest):
        cells = dict(zip(names, row, strict=True)) if names and isinstance(row, list) else row
        yield ({name: i * step for name, step in steps.items()} | cells
               if isinstance(cells, dict) else cells)


def _flat(value: dict[str, Any]) -> dict[str, Any]:
    """An object with the items of nested objects under names like ``acc.x``."""
    flat: dict[str, Any] = {}
    for key, inner in value.items():
        if isinstance(inner, str) and inner.startswith("{"):
            with suppress(json.JSONDecodeError):
                inner = json.loads(inner)
        below = _flat(inner) if isinstance(inner, dict) else {"": inner}
        flat |= {f"{key}.{name}" if name else key: one for name, one in below.items()}
    return flat


def _names(value: list[Any]) -> list[str]:
    """The names in a list, or those of its objects with their units; empty if there are none."""
    objects = [one for one in value if isinstance(one, dict) and isinstance(one.get("name"), str)]
    named = [f"{one['name']} ({one['units']})" if "units" in one else one["name"]
             for one in objects]
    return named or [one for one in value if isinstance(one, str)]


def _unrolled(rows: list[Any]) -> list[Any]:
    """One row for each sample, from rows that hold several samples in lists of equal length.

    The lists contain vectors, or numbers if their name states an axis. Each sample keeps the other
    items of its row; numbers that increase from row to row, as clocks do, are interpolated in equal
    steps to those of the next row.
    """
    inside = [_lists_of_samples(row) if isinstance(row, dict) else [] for row in rows]
    if len(rows) < FEWEST_ROWS or not all(inside) or any(
            len({len(row[name]) for name in names}) > 1
            for row, names in zip(rows, inside, strict=True)):
        return rows
    clocks = [name for name, value in rows[0].items()
              if isinstance(value, int | float) and not isinstance(value, bool) and all(
                  isinstance(row.get(name), int | float) for row in rows)
              and all(one[name] < other[name] for one, other in pairwise(rows))]
    samples = []
    steps = [{name: other[name] - one[name] for name in clocks} for one, other in pairwise(rows)]
    for row, names, step in zip(rows, inside, [*steps, steps[-1]], strict=True):
        count = len(row[names[0]])
        samples += [row | {name: row[name][i] for name in names} | {
            name: row[name] + step[name] * i / count for name in clocks} for i in range(count)]
    return samples


def _lists_of_samples(row: dict[str, Any]) -> list[str]:
    """The names of the lists in a row that hold several samples."""
    return [name for name, value in row.items() if isinstance(value, list) and len(value) > 1
            and (isinstance(value[0], dict | list) or read_name(name).axis is not None)]


def _numbers(name: str, value: object) -> Iterator[tuple[str, float]]:
    """Every number in a value, under a name like ``acc.x`` or ``acc[0]``; dates in seconds.

    Quoted numbers count, also several separated by commas."""
    if isinstance(value, str) and is_number(value):
        value = float(value)
    elif isinstance(value, str) and all(map(is_number, cells := value.split(","))):
        value = cells
    if isinstance(value, int | float) and not isinstance(value, bool):
        yield name, float(value)
    elif isinstance(value, str) and (seconds := seconds_of(value)) is not None:
        yield name, seconds
    elif isinstance(value, dict):
        for key, inner in value.items():
            yield from _numbers(f"{name}.{key}" if name else str(key), inner)
    elif isinstance(value, list | tuple):
        for i, inner in enumerate(value):
            yield from _numbers(f"{name}[{i}]", inner)
