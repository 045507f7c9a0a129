"""Poses on a plate that leans and turns, recorded or planned."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from calib.earth import EARTH_RATE_RAD_S
from calib.errors import Undetermined
from calib.poses.attitudes import two_across
from calib.poses.averaging.pose_mean import PoseMean
from calib.poses.imu_log import FloatArray
from calib.poses.reference import Reference, tilt_name
from calib.poses.runs.pose_run import PoseRun
from calib.poses.runs.reference_runs import GRAVITY, gravity_run
from calib.poses.runs.ring import (
    ANGLES,
    DIRECTION_SD_RAD,
    ROUND,
    TO_WAVES,
    Ring,
    ring_of_run,
    tilt_of_run,
)
from calib.poses.samples.in_step import FEWEST_TURNS

ADVISED_TILT_RAD = float(np.radians(9.0))
"""Fact: 5 cm under one side of a record player that is 32 cm deep."""
ADVISED_TILT = "5 cm under one side of the record player, which makes 9° of tilt"
"""Way to lean the plate by that. Words only."""


def up_round_axis(axis: FloatArray, tilt_rad: float) -> FloatArray:
    """Unit vectors up at the angles ``ROUND`` of poses that turn about ``axis`` (n, 3), (n, k, 3).

    Parameters
    ----------
    axis : array, shape (n, 3)
        Unit vectors.
    tilt_rad : float
        Of the axis against gravity.
    """
    turn = np.column_stack([np.cos(ROUND), np.sin(ROUND)])
    return np.asarray(np.cos(tilt_rad) * axis[:, None] + np.sin(tilt_rad) * turn @ two_across(axis))


def ideal_ring(
    axis: FloatArray, tilt_rad: float, gravity_m_s2: float, reading: FloatArray, sd: FloatArray,
    of_gravity: bool = False,
) -> Ring:
    """Readings over one turn of poses that turn about ``axis``.

    Parameters
    ----------
    axis : array, shape (n, 3)
        Unit vectors up the axis of the plate.
    tilt_rad, gravity_m_s2 : float
    reading : array, shape (n, 3) or (n, k, 3)
        Nominal, SI: the same all round, or at the angles ``ROUND``.
    sd : array, shape (n, 3)
        Of the mean of a pose, SI; an amplitude has √2 times that.
    of_gravity : bool
        Whether what goes round in the readings is gravity.
    """
    n = len(axis)
    if reading.ndim == 2:
        reading = np.repeat(reading[:, None], ANGLES, axis=1)
    wave_sd = np.sqrt(2) * sd
    return Ring(
        place=np.arange(n), reading=reading, force=gravity_m_s2 * up_round_axis(axis, tilt_rad),
        sd=np.stack([wave_sd, wave_sd if of_gravity else np.full_like(sd, np.nan)], axis=1),
        tilt_rad=np.full(n, tilt_rad),
        gravity_m_s2=np.full(n, gravity_m_s2 if of_gravity else np.nan),
        room_rad_s=np.full(n, EARTH_RATE_RAD_S / np.sqrt(2)),  # of each horizontal component
        vertical_rad_s=np.zeros(n), force_sd=np.full(n, np.nan),
        axis=np.full((n, 3), np.nan), axis_moved=np.zeros((n, 3, 0)),
        wow=np.zeros((n, len(TO_WAVES))),
    )


@dataclass(frozen=True)
class Leaning:
    """Tilt of plates and position of the poses on them, by a fit.

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

    The mean of a pose is gravity along the axis, g cos(tilt), and across it the force due to the
    distance from the spindle; the wave of its ring is g sin(tilt).

    Parameters
    ----------
    name : str
        Name of the run.
    means : sequence of PoseMean, length n
    gravity_m_s2, sd_m_s2 : float
        Local gravity and its sd, m/s².
    leaning : Leaning
        By an earlier fit; else by the nominal accelerometer.

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
        -gravity_m_s2 * np.sin(tilt) * DIRECTION_SD_RAD * along / size,
    ])
    return replace(
        still,
        reference=Reference(size, np.zeros(n), common, (GRAVITY, tilt_name(name))),
        ring=ring,
    )
