"""Numbers in JSON, finite or null, and the units of the nine parameters."""

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from calib.poses.data_sheet import TriadSpec
from calib.poses.imu_log import SI_UNIT, FloatArray, Triad
from calib.poses.triad_kind import TRIAD_KINDS
from pipeline.config.units import UNIT_WORDS, UNITS


def logged_unit(triad: Triad, spec: TriadSpec | None) -> str:
    """Unit of the numbers in a log: counts, or the physical unit that its sheet ``spec`` states.

    >>> logged_unit("gyroscope", TriadSpec(math.inf, 0, "si", math.pi / 180))
    '°/s'
    """
    quantity, _ = UNITS[TRIAD_KINDS[triad].sheet_units[0]]
    physical = (UNIT_WORDS.get(unit, unit) for unit, (of, size) in UNITS.items()
                if spec and spec.encoding == "si" and of == quantity
                and math.isclose(size, spec.si_per_unit))
    return next(physical, "counts")


def unit_of(key: str, triad: str, spec: TriadSpec | None = None) -> str:
    """Unit of the parameters under ``key``, by the unit of the log.

    >>> unit_of("scale_counts_per_unit", "accelerometer")
    'counts/(m/s²)'
    """
    logged, si = logged_unit(triad, spec), SI_UNIT[triad]
    if key != "scale_counts_per_unit":
        return logged if key == "bias_counts" else "rad"
    return "no unit" if logged == si else f"{f'({logged})' if '/' in logged else logged}/({si})"


Json = dict[str, Any]


def number(value: float) -> float | None:
    """A JSON number, null if not finite."""
    return float(value) if math.isfinite(value) else None


def numbers(values: Sequence[float] | FloatArray) -> list[float | None]:
    """A JSON array of an array of any shape, row by row; null for values that are not finite."""
    return [number(value) for value in np.asarray(values, float).ravel()]


def json_value(value: Any) -> Any:
    """A value for JSON: arrays as lists, null if not finite; objects as they are."""
    match value:
        case np.ndarray():
            return json_value(value.tolist())
        case float():
            return number(value)
        case str():
            return str(value)
        case np.generic():
            return json_value(value.item())
        case Mapping():
            return {str(key): json_value(one) for key, one in value.items()}
        case tuple() | list():
            return [json_value(one) for one in value]
    return value
