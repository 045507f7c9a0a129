"""JSON lines, one object per sample, a list of such objects, in an object or not, and columns."""

import json
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np

from calib.poses.imu_log import AXES
from pipeline.errors import UnreadableInput
from pipeline.logs.dialect import is_number, seconds_of
from pipeline.logs.formats.file_table import FileTable


def tables(path: Path) -> list[FileTable]:
    """One table: the numbers that every object has, lists and objects inside unrolled."""
    text = path.read_text(encoding="utf-8-sig")
    samples = [dict(_numbers("", sample)) for sample in _samples(path, text)]
    if not samples:
        return []
    names = [name for name in samples[0] if all(name in sample for sample in samples)]
    columns = {name: np.array([sample[name] for sample in samples]) for name in names}
    return [FileTable(path.stem, columns)] if columns else []


def _samples(path: Path, text: str) -> Iterator[Any]:
    with suppress(json.JSONDecodeError):
        yield from _rows(json.loads(text))
        return
    for number, line in enumerate(text.splitlines(), 1):
        try:
            if line.strip():
                yield json.loads(line)
        except json.JSONDecodeError as error:
            if _is_whole(text):
                raise UnreadableInput(
                    f"{path}: is one JSON object over several lines, as results and settings are, "
                    f"and no log. Expected one object per line, or a list of them."
                ) from error
            raise UnreadableInput(f"{path}:{number}: is no JSON ({error.msg}). One object per "
                                  "line is expected; delete the damaged line.") from error


def _is_whole(text: str) -> bool:
    try:
        json.loads(text)
    except ValueError:
        return False
    return True


def _rows(value: Any) -> Iterator[Any]:
    """The samples in a value: of a list, of the longest list in an object, or of its columns."""
    lists = [inner for inner in value.values() if isinstance(inner, list)] if isinstance(
        value, dict) else []
    columns = [inner for inner in lists if inner and not isinstance(inner[0], dict | list)]
    if len(columns) >= len(AXES) and len({*map(len, columns)}) == 1:
        names = [name for name, inner in value.items() if any(inner is one for one in columns)]
        yield from (dict(zip(names, row, strict=True)) for row in zip(*columns, strict=True))
    elif isinstance(value, dict):
        longest = max(lists, key=len, default=[])
        yield from longest if longest and isinstance(longest[0], dict | list) else [value]
    else:
        yield from value


def _numbers(name: str, value: object) -> Iterator[tuple[str, float]]:
    """Every number in a value, under a name like ``acc.x`` or ``acc[0]``; dates in seconds.

    A number may be quoted."""
    if isinstance(value, str) and is_number(value):
        value = float(value)
    if isinstance(value, int | float) and not isinstance(value, bool):
        yield name, float(value)
    elif isinstance(value, str) and (seconds := seconds_of(value)) is not None:
        yield name, seconds
    elif isinstance(value, dict):
        for key, inner in value.items():
            yield from _numbers(f"{name}.{key}" if name else str(key), inner)
    elif isinstance(value, list):
        for i, inner in enumerate(value):
            yield from _numbers(f"{name}[{i}]", inner)
