"""Poses recorded under one reference, and those of a case whose attitude is known."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from calib.errors import Undetermined
from calib.poses.attitudes import direction_name, nearest_faces
from calib.poses.averaging.pose_mean import PoseMean
from calib.poses.imu_log import AXES, FloatArray, Triad
from calib.poses.reference import FRAME_NAMES, Reference
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
    """Refuse a run in which an axis is constant throughout."""
    spread = np.max([mean.of(triad).scatter for mean in means], axis=0)
    values = np.array([mean.of(triad).mean for mean in means])
    stuck = (spread == 0) & (np.ptp(values, axis=0) == 0)
    if len(means) > 1 and stuck.any():
        axis = AXES[int(np.argmax(stuck))]
        raise Undetermined(
            f"{run}: {triad} {axis} is stuck, or its noise is less than a count: it gives the same "
            f"value in every sample of all {len(means)} poses. Check the wiring, the register "
            f"settings, or whether the column was logged twice; if it answers when it is turned, "
            f"add poses in which it turns."
        )


FARTHEST_RAD = float(np.radians(12.0))
"""Angle between a pose by the data sheet alone and its face or edge. Derived: gains and biases of a
few per cent turn a vector by as many degrees, and the chip may sit askew by as many in its case;
edges are 45° from faces."""


def laid_down(run: PoseRun, sd_rad: float | None) -> PoseRun:
    """``run`` with the attitudes of a case that stood on a face or an edge of 45° in every pose.

    Parameters
    ----------
    run : PoseRun
    sd_rad : float or None
        How well face and plate are square and level, the sd of each of two angles; None where
        nothing is known of the attitudes.

    Raises
    ------
    Undetermined
        A pose is nowhere near a face or an edge, or the plate leans.
    """
    if sd_rad is None:
        return run
    if run.ring is not None:
        raise Undetermined(
            f"{run.name}: the plate leans by {np.degrees(run.ring.tilt_rad[0]):.1f}°, and the "
            f"attitudes that attitude_sd_deg states are those on a level one. Take that key out, "
            f"or level the plate.")
    force = np.array([mean.accelerometer.mean for mean in run.means])
    if not np.isfinite(force).all():
        raise Undetermined(
            f"{run.name}: attitude_sd_deg says that every pose stood on a face or an edge, and "
            f"only an accelerometer shows on which; log it too, or take that key out.")
    up, off = nearest_faces(force)
    if off.max() > FARTHEST_RAD:
        worst = int(off.argmax())
        raise Undetermined(
            f"{run.name}: {run.means[worst].label} is {np.degrees(off[worst]):.0f}° from the "
            f"nearest face or edge ({direction_name(up[worst])}), and attitude_sd_deg says that "
            f"every pose stood on one. Take that key out, or exclude the pose.")
    reference = run.reference
    free = np.zeros((len(run.means), len(FRAME_NAMES)))
    return replace(run, up=up, up_sd_rad=sd_rad, reference=replace(
        reference, common=np.hstack([reference.common, free]),
        common_names=(*reference.common_names, *FRAME_NAMES)))


def known_attitudes(
    runs: Sequence[tuple[int, FloatArray | None, float]]
) -> tuple[FloatArray, FloatArray] | tuple[None, None]:
    """Attitude of the case in every pose of ``runs``, and its uncertainty.

    Parameters
    ----------
    runs : sequence of (int, array or None, float)
        Number of poses, the vertical in the axes of the case (n, 3), and the sd of each angle, rad.

    Returns
    -------
    up : array, shape (n, 3)
        NaN in the poses of runs of which it is not known; None where it is of none.
    sd_rad : array, shape (n,)
    """
    if all(up is None for _, up, _ in runs):
        return None, None
    ups = [np.full((n, 3), np.nan) if up is None else up for n, up, _ in runs]
    sds = [np.full(n, np.nan if up is None else sd) for n, up, sd in runs]
    return np.concatenate(ups), np.concatenate(sds)
