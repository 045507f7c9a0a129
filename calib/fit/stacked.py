"""Records of many pose sets side by side: every array has a leading axis S.

The same lines compute one set or S: formulas are written for the last axes of an array, and leave
the axes before them alone. A session is a stack of one; its results have no leading axis for the
user (``stack.take(0)``).
"""

from collections.abc import Mapping
from dataclasses import dataclass, fields, replace
from typing import Any, TypeVar

import numpy as np

from calib.poses.imu_log import IntArray
from calib.poses.rows import Rows

Index = int | IntArray | None
"""Selected sets: one without its axis, some of them, or one that becomes a stack of one (None)."""

Record = TypeVar("Record", bound="Stacked")


@dataclass(frozen=True, eq=False)
class Stacked(Rows):
    """A record whose rows are sets."""

    def with_sets(self: Record, sets: IntArray, part: Record) -> Record:
        """This record of S sets with those of ``sets``, in their order, replaced by ``part``."""
        if not len(sets):
            return self
        return replace(self, **{f.name: _put(getattr(self, f.name), sets, getattr(part, f.name))
                                for f in fields(self)})


def _put(value: Any, sets: IntArray, part: Any) -> Any:
    if isinstance(value, np.ndarray):
        if len(sets) == len(value):
            return part
        changed = value.copy()
        changed[sets] = part
        return changed
    if isinstance(value, Stacked):
        return value.with_sets(sets, part)
    if isinstance(value, Mapping):
        return {name: _put(one, sets, part[name]) for name, one in value.items()}
    return value
