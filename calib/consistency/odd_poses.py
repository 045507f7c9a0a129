"""Poses that contradict all others, found together: one of several hides behind the next.

Without any one of three wrong poses the other two still spoil the fit, so every set of up to three
is left out, and what any parameters leave of the rest at least says which set it is: by the log
likelihood ratio ``d/2 ln(chi2_with / chi2_without)``, the noise's scale free, against the logarithm
of the number of sets over the probability of a false alarm.
"""

from itertools import combinations

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
    n, unknowns = columns.shape
    kept = np.ones((1, n), dtype=bool)
    for size in range(1, min(MOST_ODD, n - unknowns - 1) + 1):
        out = np.array([*combinations(range(n), size)])
        if len(kept) - 1 + len(out) > MOST_SETS:
            break
        kept = np.concatenate([kept, ~(out[..., None] == np.arange(n)).any(axis=1)])
    if len(kept) == 1:
        return None
    chi2, dof = left_over(columns, target, kept)
    dof = np.maximum(dof[1:], 1)
    gained = dof / 2 * np.log(np.maximum(chi2[0], dof) / np.maximum(chi2[1:], dof))
    best = int(np.argmax(gained))
    if gained[best] < np.log(len(gained) / FALSE_ALARM):
        return None
    odd = np.zeros(len(poses), dtype=bool)
    odd[~poses.reference.is_null] = ~kept[1 + best]
    return odd
