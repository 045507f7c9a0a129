"""Poses of the accelerometer on a plate that leans and turns."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from calib.errors import Undetermined
from calib.poses.averaging import PoseMean
from calib.poses.imu_log import FloatArray
from calib.poses.in_step import FEWEST_TURNS
from calib.poses.pose_run import PoseRun
from calib.poses.reference import Reference
from calib.poses.ring import TILT_SD_RAD, ring_of_run, tilt_name, tilt_of_run
from calib.poses.runs import GRAVITY, gravity_run, spin_sign


def tilted_run(
    name: str, means: Sequence[PoseMean], gravity_m_s2: float, sd_m_s2: float,
    rate_rad_s: FloatArray, tilt_rad: float | None = None, across_m_s2: FloatArray | None = None,
) -> PoseRun:
    """Poses of the accelerometer on a plate that leans and turns.

    The mean of a pose is gravity along the axis, g cos(tilt), and across it what the distance from
    the spindle makes; the wave of its ring is g sin(tilt).

    Parameters
    ----------
    name : str
        Name of the run.
    means : sequence of PoseMean, length n
    gravity_m_s2, sd_m_s2 : float
        Local gravity and its sd, m/s².
    rate_rad_s : array, shape (1,) or (n,)
        Of the plate, positive.
    tilt_rad : float, optional
        By an earlier fit; else by the nominal accelerometer.
    across_m_s2 : array, shape (n,), optional
        Part of the mean force across the axis, by an earlier fit.

    Returns
    -------
    PoseRun

    Raises
    ------
    Undetermined
        The plate is level, or gravity was not seen to go round in every pose.
    """
    still = gravity_run(name, means, gravity_m_s2, sd_m_s2)
    seen = tilt_of_run(means)
    tilt = seen if tilt_rad is None else tilt_rad
    ring = ring_of_run(means, "accelerometer", tilt, gravity_m_s2)
    if tilt is None or ring is None or len(ring.place) < len(means):
        seen_as = "no wave" if seen is None else f"a tilt of {np.degrees(seen):.1f}°"
        raise Undetermined(
            f"{name}: gravity must go round once per turn in the accelerometer of every pose, and "
            f"{seen_as} was found. Put 5 cm under one side of the record player, which makes 9° of "
            f"tilt, and log each pose for at least {FEWEST_TURNS} whole turns; or take the poses "
            f"of the accelerometer at rest (`accelerometer.poses`)."
        )
    n = len(means)
    along = gravity_m_s2 * np.cos(tilt)
    size = np.full(n, along) if across_m_s2 is None else np.hypot(along, across_m_s2)
    common = np.column_stack([
        sd_m_s2 * np.cos(tilt) * along / size,
        -gravity_m_s2 * np.sin(tilt) * TILT_SD_RAD * along / size,
    ])
    return replace(
        still,
        reference=Reference(size, np.zeros(n), common, (GRAVITY, tilt_name(name))),
        spin_rad_s=np.broadcast_to(rate_rad_s, n) * spin_sign(means, None),
        ring=ring,
    )
