"""JSON lines, one object per sample, and a list of such objects."""

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

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
    if text.lstrip().startswith("["):
        yield from json.loads(text)
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
