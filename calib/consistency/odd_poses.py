"""Poses that contradict all others, found together: one of several hides behind the next.

Without any one of three wrong poses the other two still spoil the fit, so every set of up to three
is left out, and what any parameters leave of the rest at least says which set it is: by the log
likelihood ratio ``d/2 ln(chi2_with / chi2_without)``, the noise's scale free, against the logarithm
of the number of sets over the probability of a false alarm.
"""

from collections.abc import Iterator
from itertools import combinations
from math import comb

import numpy as np

from calib.consistency.quadric import left_over, quadric
from calib.poses.checks.frozen import FALSE_ALARM
from calib.poses.imu_log import BoolArray
from calib.poses.pose_set import PoseSet

MOST_ODD = 3  #: poses; derived: what a set of 18 can lose before a direction is missing
MOST_SETS = 1000  #: sets of poses left out; a limit of time


def odd_poses(poses: PoseSet) -> BoolArray | None:
    """The poses that contradict all others, (n,); None where no few of them do."""
    columns, target = quadric(poses)
    turning = np.flatnonzero(~poses.reference.is_null)
    sets = [*_few_of(len(turning), len(turning) - columns.shape[1] - 1)]
    if not sets:
        return None
    whole, _ = left_over(columns, target)
    without = np.array([left_over(np.delete(columns, out, axis=0), np.delete(target, out))
                        for out in sets])
    dof = np.maximum(without[:, 1], 1)
    gained = dof / 2 * np.log(np.maximum(whole, dof) / np.maximum(without[:, 0], dof))
    best = int(np.argmax(gained))
    if gained[best] < np.log(len(sets) / FALSE_ALARM):
        return None
    odd = np.zeros(len(poses), dtype=bool)
    odd[turning[list(sets[best])]] = True
    return odd


def _few_of(count: int, most: int) -> Iterator[tuple[int, ...]]:
    """Sets of one place of ``count`` and more, of as many as time and what is left allow."""
    sets = 0
    for size in range(1, min(MOST_ODD, most) + 1):
        sets += comb(count, size)
        if sets > MOST_SETS:
            return
        yield from combinations(range(count), size)
