"""How a calibrated accelerometer is mounted: Promrit et al., with uncertainties.

From still logs, corrected by the triad's calibration, roll and pitch by eq. (A)-(D) in the order
of eq. (6) (:mod:`calib.mounting.levelling`), and beyond the paper the sd of both angles.

What is measured is the mounting against the plumb line, in the orthogonal frame that the
accelerometer's calibration has chosen (its z is the sensitive axis z, its x-axis is the one that
Angrisano et al. eq. (2) leaves free). A log cannot separate a slope of the floor from the mounting:
that is why the paper finds 13.00° on a lamp of nominally 15°, and no reading of that log could
explain it.

The paper compensates by ``K a = R (I + S + M) a + b``, which turns first and scales afterwards.
The sensor's errors arise along its own axes, so here the calibration is applied first and ``Rᵀ``
afterwards; on its own lamps the two differ by 145 mm/s² for errors of one to two per cent.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from calib.errors import Undetermined
from calib.fit.triad.calibration import TriadCalibration
from calib.mounting.both_orders import LevelledReadings, OrderTrial, levelled_readings, try_orders
from calib.mounting.levelling import (
    Order,
    mounting_rotation,
    roll_pitch,
    roll_pitch_jacobian,
    rotation_order,
)
from calib.mounting.still_reading import (
    StillReading,
    noise_covariance,
    still_reading,
)
from calib.poses.data_sheet import LARGEST_DRIFT
from calib.poses.imu_log import FloatArray, ImuLog

EXPLAINED_SD = 3.0
"""A deviation up to this many sds is what the stated uncertainties explain. Derived: 1 in 370 of a
normal variable."""

LOCK_COSINE = 0.05
"""Derived: within 3° of the lock of an order the other angle's sd grows twentyfold and more."""

SHORTEST_LOG_S = 20.0
"""Noise of a low-cost sensor stays correlated over about half a second. In shorter logs the stated
95 % cover less than 93 % (92 % at 12 s, 83 % at 3 s; ``tests/bench/study_installation.py``).
Derived."""


@dataclass(frozen=True, eq=False)
class Mounting:
    """How one sensor sits in its vehicle.

    Parameters
    ----------
    order : str
        ``xyz`` or ``yxz``: the rotation order, eq. (6).
    roll_rad, pitch_rad : float
        φ and θ of eq. (A)-(D).
    cov : array, shape (2, 2)
        Covariance of roll and pitch, rad².
    rotation : array, shape (3, 3)
        R, from the vehicle's axes to the sensor's; a yaw is not measured and counts as zero.
    before, after : array, shape (3,)
        Calibrated mean reading in the sensor's axes, and turned into the vehicle's by ``Rᵀ``,
        m/s²; ``after`` is (0, 0, g) but for the floor's slope.
    magnitude_error_m_s2 : float
        By how much the corrected magnitude exceeds gravity.
    notes : tuple of str
        What the user should know of how far the sds can be trusted.
    samples : int
        Readings that were averaged.
    orders : tuple of OrderTrial
        Roll and pitch in both orders.
    readings : LevelledReadings
        Single readings, before and after.
    """

    order: Order
    roll_rad: float
    pitch_rad: float
    cov: FloatArray
    rotation: FloatArray
    before: FloatArray
    after: FloatArray
    magnitude_error_m_s2: float
    notes: tuple[str, ...]
    samples: int
    orders: tuple[OrderTrial, ...]
    readings: LevelledReadings

    @property
    def sd_rad(self) -> FloatArray:
        """Sds of roll and pitch, rad, shape (2,)."""
        return np.asarray(np.sqrt(np.diag(self.cov)))


def mounting_from_logs(
    logs: Sequence[ImuLog],
    accelerometer: TriadCalibration,
    gravity_m_s2: float,
    gravity_sd_m_s2: float = 0.0,
    order: Order | None = None,
) -> Mounting:
    """Roll and pitch.

    Parameters
    ----------
    logs : sequence of ImuLog
        Raw logs of the mounted sensor at rest, all at one place and heading.
    accelerometer : TriadCalibration
        Its calibration.
    gravity_m_s2, gravity_sd_m_s2 : float
        Gravity where the logs were made.
    order : str, optional
        Rotation order; by eq. (6) where None.

    Raises
    ------
    Undetermined
        The sensor moved, the corrected magnitude is not gravity, or the order is locked at this
        mounting.
    Contradiction, UnusableLog
        A log contradicts the calibration, or holds counts that the converter cannot give.
    """
    reading = still_reading(logs, accelerometer)
    force = accelerometer.correction.correct(reading.at)[0]
    cov, notes = _with_drift(reading, force, accelerometer, gravity_m_s2, gravity_sd_m_s2)
    chosen = order or rotation_order(force / gravity_m_s2)
    _refuse_lock(reading.label, force, chosen)
    roll, pitch = roll_pitch(force, chosen)
    to_angles = roll_pitch_jacobian(force, chosen)
    rotation = mounting_rotation(chosen, roll, pitch)
    return Mounting(
        order=chosen,
        roll_rad=roll,
        pitch_rad=pitch,
        cov=to_angles @ cov @ to_angles.T,
        rotation=rotation,
        before=force,
        after=force @ rotation,
        magnitude_error_m_s2=float(np.linalg.norm(force)) - gravity_m_s2,
        notes=notes,
        samples=reading.samples,
        orders=try_orders(force, cov, gravity_m_s2),
        readings=levelled_readings(logs, accelerometer, rotation),
    )


def _with_drift(
    reading: StillReading, force: FloatArray, accelerometer: TriadCalibration,
    gravity: float, gravity_sd: float,
) -> tuple[FloatArray, tuple[str, ...]]:
    """Covariance (3, 3) of ``force`` with what the stated sds do not explain, and notes on it."""
    cov = noise_covariance(reading, accelerometer.correction) + accelerometer.covariance_of(
        lambda by: np.asarray(by.correct(reading.at)[0]))
    notes = []
    if reading.longest_s < SHORTEST_LOG_S:
        notes.append(
            f"{reading.label} lasts {reading.longest_s:.1f} s: slow noise is not seen in less "
            f"than {SHORTEST_LOG_S:g} s, and the sds are lower bounds. Log half a minute."
        )
    unexplained = _unexplained(reading, force, cov, gravity, gravity_sd)
    if unexplained > 0:
        # The calibration no longer holds to this extent, in a direction that nobody knows.
        cov = cov + unexplained**2 * np.eye(3)
        notes.append(
            f"{reading.label}: the calibrated magnitude is {1e3 * unexplained:.1f} mm/s² off "
            f"gravity, more than the stated uncertainties explain: the calibration has "
            f"drifted. The sds of the angles contain it; calibrate again for smaller ones."
        )
    return cov, tuple(notes)


def _unexplained(
    reading: StillReading, force: FloatArray, cov: FloatArray, gravity: float, gravity_sd: float
) -> float:
    """Deviation of |force| from gravity where stated sds do not explain it, else 0; m/s²."""
    size = float(np.linalg.norm(force))
    deviation = size - gravity
    if abs(deviation) > LARGEST_DRIFT * gravity:  # more than a degree
        raise Undetermined(
            f"{reading.label}: the calibrated readings have a magnitude of {size:.4f} m/s² where "
            f"gravity is {gravity:.4f} m/s², {100 * deviation / gravity:+.1f} % off; within "
            f"{100 * LARGEST_DRIFT:g} % is accepted, since the angles are wrong by as much. The "
            f"vehicle was accelerating, or the calibration is another sensor's, another range's or "
            f"too old: record the log at rest, and calibrate the sensor again if it persists."
        )
    along = force / size
    sd = math.sqrt(float(along @ cov @ along) + gravity_sd**2)
    return abs(deviation) if abs(deviation) > EXPLAINED_SD * sd else 0.0


def _refuse_lock(label: str, up: FloatArray, order: Order) -> None:
    x, y, z = up / np.linalg.norm(up)
    denominator = math.hypot(y, z) if order == "xyz" else math.hypot(x, z)
    if denominator >= LOCK_COSINE:
        return
    locked, lost, other = ("pitch", "roll", "yxz") if order == "xyz" else ("roll", "pitch", "xyz")
    raise Undetermined(
        f"{label}: gimbal lock: with the rotation order {order} the {locked} is within "
        f"{math.degrees(math.asin(LOCK_COSINE)):.0f}° of 90° at this mounting, where the {lost} "
        f"has no meaning. Write `order: {other}` under `installation:`, or delete the key and "
        f"leave the choice to eq. (6)."
    )
