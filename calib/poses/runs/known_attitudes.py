"""Poses of a case whose attitude is known: a cube on a level plate, face by face."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from calib.errors import Undetermined
from calib.poses.attitudes import direction_name, nearest_faces
from calib.poses.imu_log import FloatArray
from calib.poses.runs.pose_run import PoseRun
from calib.poses.runs.ring_errors import FRAME_NAMES

FARTHEST_RAD = float(np.radians(12.0))
"""Between a pose by the data sheet alone and its face or edge. Derived: gains and biases of a few
per cent turn a vector by as many degrees, and the chip may sit askew by as many in its case; edges
are 45° from faces."""


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
    """How the case lay in every pose of ``runs``, and how well that is known.

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
