"""The steps of a converter, as the values of a log show them."""

import numpy as np

from calib.poses.data_sheet import TriadSpec
from calib.poses.imu_log import FloatArray

MOST_DECIMALS = 9  #: of a logged value in SI units; beyond them it counts as not rounded
PRINTED_TOLERANCE = 1e-6
"""Of the last decimal: far above the rounding of a double, far below one."""


def value_steps(values: FloatArray) -> FloatArray:
    """The step between neighbouring values of each axis of a log (t, 3), in its units, (3,).

    A converter steps by one count, or by more where the log was shifted or rounded; of a log in
    physical units the values themselves show it. Infinite where all are the same.
    """
    steps = []
    for axis in values.T:
        whole = np.rint(axis)
        if np.array_equal(axis, whole):
            step = float(np.gcd.reduce((whole - whole[0]).astype(np.int64)))
        else:
            gaps = np.diff(np.unique(axis))
            step = float(gaps.min()) if gaps.size else 0.0
        steps.append(step or np.inf)
    return np.array(steps)


def least_steps(values: FloatArray, spec: TriadSpec) -> FloatArray:
    """One count, or one of the last decimal that the first of ``values`` (t, 3) has, (3,).

    In the same unit.
    """
    if spec.encoding != "si":
        return np.ones(3)
    decimals = np.arange(MOST_DECIMALS)
    scaled = values[0][:, None] * 10.0**decimals
    is_whole = np.abs(scaled - np.rint(scaled)) < PRINTED_TOLERANCE
    return np.where(is_whole.any(axis=1), 10.0 ** -np.argmax(is_whole, axis=1).astype(float), 0.0)
