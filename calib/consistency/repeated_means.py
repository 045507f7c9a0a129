"""Poses that occur twice in a table of means, where no samples show it."""

import numpy as np

from calib.errors import Contradiction
from calib.poses.pose_set import PoseSet

REPEATED = 0.2
"""Share of the poses. Derived: poses of one attitude laid by hand within a degree read alike to the
last digit of a ten-bit converter once in 25; rows that were put together twice are a half."""


def require_no_repeated_means(poses: PoseSet) -> None:
    """Refuse poses whose means occur twice: rows of a table that were put together twice.

    Raises
    ------
    Contradiction
        Naming a pair of them.
    """
    turning = np.flatnonzero(~poses.reference.is_null)
    _, first, counts = np.unique(poses.reading[turning], axis=0, return_index=True,
                                 return_counts=True)
    again = int((counts - 1).sum())
    if again < max(2.0, REPEATED * len(turning)):
        return
    one = turning[first[int(np.argmax(counts > 1))]]
    same = np.flatnonzero((poses.reading == poses.reading[one]).all(axis=1))
    raise Contradiction(
        f"{poses.label[same[0]]} and {poses.label[same[1]]}: their {poses.triad} means are the "
        f"same to the last digit, and so are those of {again - 1} other pairs. Counted twice they "
        f"would make every sd too small. Take the copies out."
    )
