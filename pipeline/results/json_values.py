"""Numbers as JSON has them: finite, or null."""

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from calib.poses.imu_log import FloatArray

Json = dict[str, Any]


def number(value: float) -> float | None:
    """A JSON number, null for what is not finite."""
    return float(value) if math.isfinite(value) else None


def numbers(values: Sequence[float] | FloatArray) -> list[float | None]:
    """A JSON array of an array of any shape, row by row; null for what is not finite."""
    return [number(value) for value in np.asarray(values, float).ravel()]
