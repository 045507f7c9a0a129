"""Poses of the accelerometer on a plate that leans and turns."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from calib.errors import Undetermined
from calib.poses.averaging.pose_mean import PoseMean
from calib.poses.reference import Reference
from calib.poses.runs.ideal_ring import ADVISED_TILT
from calib.poses.runs.pose_run import PoseRun
from calib.poses.runs.reference_runs import GRAVITY, gravity_run
from calib.poses.runs.ring import TILT_SD_RAD, ring_of_run, tilt_of_run
from calib.poses.runs.ring_errors import tilt_name
from calib.poses.samples.in_step import FEWEST_TURNS


@dataclass(frozen=True)
class Leaning:
    """How plates lean and where the poses lay on them, by a fit.

    Attributes
    ----------
    tilt_rad : mapping of str to float
        By run.
    across_m_s2 : mapping of str to float
        Part of the mean force across the axis of the plate, by pose.
    """

    tilt_rad: Mapping[str, float] = field(default_factory=dict)
    across_m_s2: Mapping[str, float] = field(default_factory=dict)


NOT_FITTED = Leaning()
"""The nominal accelerometer decides."""


def tilted_run(
    name: str, means: Sequence[PoseMean], gravity_m_s2: float, sd_m_s2: float,
    leaning: Leaning = NOT_FITTED,
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
    leaning : Leaning
        By an earlier fit; else by the nominal accelerometer.

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
    tilt = leaning.tilt_rad.get(name, seen)
    ring = ring_of_run(means, "accelerometer", tilt, gravity_m_s2)
    if tilt is None or ring is None or len(ring.place) < len(means):
        seen_as = "no wave" if seen is None else f"a tilt of {np.degrees(seen):.1f}°"
        raise Undetermined(
            f"{name}: gravity must go round once per turn in the accelerometer of every pose, and "
            f"{seen_as} was found. Put {ADVISED_TILT}, and log each pose for at least "
            f"{FEWEST_TURNS} whole turns; or take the poses of the accelerometer at rest "
            f"(`accelerometer.poses`)."
        )
    n = len(means)
    along = gravity_m_s2 * np.cos(tilt)
    size = np.hypot(along, [leaning.across_m_s2.get(mean.label, 0.0) for mean in means])
    common = np.column_stack([
        sd_m_s2 * np.cos(tilt) * along / size,
        -gravity_m_s2 * np.sin(tilt) * TILT_SD_RAD * along / size,
    ])
    return replace(
        still,
        reference=Reference(size, np.zeros(n), common, (GRAVITY, tilt_name(name))),
        ring=ring,
    )
