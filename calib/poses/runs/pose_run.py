"""Poses recorded under one reference."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from calib.errors import Undetermined
from calib.poses.averaging.pose_mean import PoseMean
from calib.poses.imu_log import AXES, FloatArray, Triad
from calib.poses.reference import Reference
from calib.poses.runs.ring import Ring


@dataclass(frozen=True, eq=False)
class PoseRun:
    """Poses recorded under one reference.

    Parameters
    ----------
    name : str
        What messages call the run.
    means : sequence of PoseMean, length n
    reference : Reference
        Magnitudes of the n poses.
    spin_rad_s : array, shape (n,)
        Plate rate, positive counter-clockwise seen from above; 0 when stopped.
    expected : array, shape (n, 3)
        What a null pose should read, SI.
    ring : Ring or None
        Of a plate that leans, by the nominal accelerometer.
    up : array, shape (n, 3), or None
        The vertical in the axes of the case, where it is known how that lay, unit vectors.
    up_sd_rad : float
        How well: sd of each of its two angles.
    """

    name: str
    means: Sequence[PoseMean]
    reference: Reference
    spin_rad_s: FloatArray
    expected: FloatArray
    ring: Ring | None = None
    up: FloatArray | None = None
    up_sd_rad: float = 0.0

    @property
    def is_stated(self) -> bool:
        """Whether its means and their sds come from a table."""
        return any(mean.stated for mean in self.means)


def check_alive(means: Sequence[PoseMean], triad: Triad, run: str) -> None:
    """Refuse a run in which an axis gave the very same value all the time."""
    spread = np.max([mean.of(triad).scatter for mean in means], axis=0)
    values = np.array([mean.of(triad).mean for mean in means])
    stuck = (spread == 0) & (np.ptp(values, axis=0) == 0)
    if len(means) > 1 and stuck.any():
        axis = AXES[int(np.argmax(stuck))]
        raise Undetermined(
            f"{run}: {triad} {axis} is stuck: it gives the same value in every sample of all "
            f"{len(means)} poses. Check the wiring, the register settings, or whether the column "
            f"was logged twice."
        )
