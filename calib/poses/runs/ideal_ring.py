"""The ring of poses that nobody has recorded yet, on a plate that leans."""

import numpy as np

from calib.earth import EARTH_RATE_RAD_S
from calib.poses.imu_log import FloatArray
from calib.poses.runs.ring import ANGLES, ROUND, TO_WAVES, Ring

ADVISED_TILT_RAD = float(np.radians(9.0))
"""Fact: 5 cm under one side of a record player that is 32 cm deep."""
ADVISED_TILT = "5 cm under one side of the record player, which makes 9° of tilt"
"""What a person does for that. Words only."""


def up_round_axis(axis: FloatArray, tilt_rad: float) -> FloatArray:
    """Unit vectors up at the angles ``ROUND`` of poses that turn about ``axis`` (n, 3), (n, k, 3).

    Parameters
    ----------
    axis : array, shape (n, 3)
        Unit vectors.
    tilt_rad : float
        Of the axis against gravity.
    """
    lean = np.cross(axis, np.eye(3)[np.argmin(np.abs(axis), axis=1)])
    lean /= np.linalg.norm(lean, axis=1, keepdims=True)
    across = np.stack([lean, np.cross(axis, lean)], axis=1)
    turn = np.column_stack([np.cos(ROUND), np.sin(ROUND)])
    return np.asarray(np.cos(tilt_rad) * axis[:, None] + np.sin(tilt_rad) * turn @ across)


def ideal_ring(
    axis: FloatArray, tilt_rad: float, gravity_m_s2: float, reading: FloatArray, sd: FloatArray,
    room_rad_s: float = EARTH_RATE_RAD_S / np.sqrt(2), of_gravity: bool = False,
) -> Ring:
    """What poses that turn about ``axis`` would read all round one turn.

    Parameters
    ----------
    axis : array, shape (n, 3)
        Unit vectors up the axis of the plate.
    tilt_rad, gravity_m_s2 : float
    reading : array, shape (n, 3) or (n, k, 3)
        Nominal, SI: the same all round, or at the angles ``ROUND``.
    sd : array, shape (n, 3)
        Of the mean of a pose, SI; an amplitude has √2 times that.
    room_rad_s : float
        Sd of each horizontal component of what turns with the room.
    of_gravity : bool
        Whether what goes round in the readings is gravity.

    Returns
    -------
    Ring
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
        room_rad_s=np.full(n, room_rad_s), vertical_rad_s=np.zeros(n), force_sd=np.full(n, np.nan),
        axis=np.full((n, 3), np.nan), axis_moved=np.zeros((n, 3, 0)),
        wow=np.zeros((n, len(TO_WAVES))),
    )
