"""Records whose arrays have a row for each pose, each sample or each set of poses."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields, replace
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

RowIndex = NDArray[np.int64] | NDArray[np.bool_] | slice | Sequence[int]
"""Selected rows: their indices, a mask (n,), or a slice."""

Record = TypeVar("Record", bound="Rows")


@dataclass(frozen=True, eq=False)
class Rows:
    """A record whose arrays, mappings of arrays and records of this kind have the same rows.

    Anything else in it holds for all rows.
    """

    def take(self: Record, rows: Any) -> Record:
        """The record of some rows, in this order; a row may be taken more than once."""
        return replace(self, **{f.name: taken(getattr(self, f.name), rows) for f in fields(self)})


def taken(value: Any, rows: Any) -> Any:
    """An array (n, ...) of any unit, a mapping or a record at some rows; anything else as it is."""
    if isinstance(value, np.ndarray):
        return value[rows]
    if isinstance(value, Rows):
        return value.take(rows)
    if isinstance(value, Mapping):
        return {name: taken(one, rows) for name, one in value.items()}
    return value


def joined(parts: Sequence[Record]) -> Record:
    """The rows of ``parts`` one after another: arrays that all have, columns that all have."""
    if len(parts) == 1:
        return parts[0]
    every = {f.name: [getattr(part, f.name) for part in parts] for f in fields(parts[0])}
    whole: dict[str, Any] = {}
    for name, values in every.items():
        if isinstance(values[0], Mapping):
            whole[name] = {key: np.concatenate([each[key] for each in values])
                           for key in values[0] if all(key in each for each in values)}
        elif any(isinstance(each, np.ndarray) for each in values):
            lacking = any(each is None for each in values)
            whole[name] = None if lacking else np.concatenate(values)
    return replace(parts[0], **whole)
