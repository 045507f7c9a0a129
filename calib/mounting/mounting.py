"""Mounting of a calibrated accelerometer in a vehicle: Promrit et al., with uncertainties.

Roll and pitch follow from a still log, corrected by the triad's calibration, by eq. (A)-(D) in the
order of eq. (6) (:mod:`calib.mounting.levelling`). Beyond the paper: the sd of both angles; the
floor's slope separated from the mounting by a second log at the reverse heading; the yaw from a
drive (:mod:`calib.mounting.heading`).

The result is the mounting relative to the plumb line, in the orthogonal frame that the
accelerometer's calibration has chosen (its z is the sensitive axis z, its x-axis is the one that
Angrisano et al. eq. (2) leaves free). One log alone cannot separate a slope of the floor from the
mounting: that is why the paper finds 13.00° on a lamp of nominally 15°, and no reading of that log
could explain it.

The paper compensates by ``K a = R (I + S + M) a + b``, which rotates first and scales afterwards.
The sensor's errors arise along its own axes, so here the calibration is applied first and ``Rᵀ``
afterwards; on its own lamps the two differ by 145 mm/s² for errors of one to two per cent.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from calib.errors import Undetermined
from calib.fit.triad.calibration import TriadCalibration
from calib.fit.triad.correction import Correction
from calib.fit.validation.untold import untold, untold_covariance
from calib.mounting.both_orders import LevelledReadings, OrderTrial, levelled_readings, try_orders
from calib.mounting.heading import FirstPush, Yaw, measure_yaw
from calib.mounting.levelling import (
    HeadingForces,
    Order,
    Slope,
    floor_slope,
    mounting_rotation,
    roll_pitch,
    roll_pitch_jacobian,
    rotation_order,
    turned_short_covariance,
)
from calib.mounting.still_reading import (
    StillReading,
    noise_covariance,
    still_reading,
)
from calib.poses.data_sheet import LARGEST_DRIFT
from calib.poses.imu_log import FloatArray, ImuLog

EXPLAINED_SD = 3.0
"""Largest deviation, in sds, that the stated uncertainties explain. Derived: 1 in 370 of a normal
variable."""

LOCK_COSINE = 0.05
"""Cosine at the gimbal lock. Derived: within 3° the other angle's sd grows twentyfold and more."""

SHORTEST_LOG_S = 20.0
"""Length of a log, s: noise of a low-cost sensor stays correlated over about half a second. In
shorter logs the stated 95 % cover less than 93 % (92 % at 12 s, 83 % at 3 s;
``tests/bench/study_installation.py``). Derived."""


@dataclass(frozen=True, eq=False)
class MountingLogs:
    """The raw logs of a mounted sensor.

    Parameters
    ----------
    still : sequence of ImuLog
        At rest, all at one place and heading.
    reverse : sequence of ImuLog
        The same at the same place with the vehicle turned round by 180°.
    drive : sequence of ImuLog
        Straight driving with marked acceleration or braking.
    first_push : str
        ``forward`` where the drive begins by speeding up ahead, ``backward`` where it begins by
        braking.
    """

    still: Sequence[ImuLog]
    reverse: Sequence[ImuLog] = ()
    drive: Sequence[ImuLog] = ()
    first_push: FirstPush = "forward"


@dataclass(frozen=True, eq=False)
class Mounting:
    """Mounting of one sensor in its vehicle.

    Parameters
    ----------
    order : str
        ``xyz`` or ``yxz``: the rotation order, eq. (6).
    roll_rad, pitch_rad : float
        φ and θ of eq. (A)-(D).
    cov : array, shape (2, 2)
        Covariance of roll and pitch, rad².
    rotation : array, shape (3, 3)
        R, from the vehicle's axes to the sensor's, with the yaw where it was measured.
    before, after : array, shape (3,)
        Calibrated mean reading in the sensor's axes, and turned into the vehicle's by ``Rᵀ``,
        m/s²; ``after`` is (0, 0, g) but for the floor's slope.
    magnitude_error_m_s2 : float
        Excess of the corrected magnitude over gravity.
    notes : tuple of str
        Notes for the user on the limits of the sds.
    samples : int
        Readings that were averaged.
    slope : Slope or None
        The floor's, where a log at the reverse heading was given.
    yaw : Yaw or None
        Where a drive was given.
    orders : tuple of OrderTrial
        Roll and pitch in both orders.
    readings : LevelledReadings
        Single readings of the first heading, before and after.
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
    slope: Slope | None
    yaw: Yaw | None
    orders: tuple[OrderTrial, ...]
    readings: LevelledReadings

    @property
    def sd_rad(self) -> FloatArray:
        """Sds of roll and pitch, rad, shape (2,)."""
        return np.asarray(np.sqrt(np.diag(self.cov)))

    def turn(self, vectors: FloatArray) -> FloatArray:
        """Transform vectors from the sensor's axes to those of the vehicle, ``Rᵀ v``.

        Parameters
        ----------
        vectors : array, shape (n, 3)
            In any unit.

        Returns
        -------
        array, shape (n, 3)
            In the same unit.
        """
        return np.asarray(vectors @ self.rotation)


def mounting_from_logs(
    logs: MountingLogs,
    accelerometer: TriadCalibration,
    gravity_m_s2: float,
    gravity_sd_m_s2: float = 0.0,
    order: Order | None = None,
) -> Mounting:
    """Roll, pitch and, where the logs show them, the floor's slope and the yaw.

    Parameters
    ----------
    logs : MountingLogs
    accelerometer : TriadCalibration
        Its calibration.
    gravity_m_s2, gravity_sd_m_s2 : float
        Gravity where the logs were made.
    order : str, optional
        Rotation order; by eq. (6) where None.

    Raises
    ------
    Undetermined
        The sensor moved, the corrected magnitude is not gravity, the order is locked at this
        mounting, the second log is not the reverse heading, or the drive has no clear direction.
    Contradiction, UnusableLog
        A log contradicts the calibration, or holds counts that the converter cannot give.
    """
    upright = _upright(logs, accelerometer)
    cov, notes = _with_drift(upright, gravity_m_s2, gravity_sd_m_s2)
    notes += _of_untold(accelerometer)
    if logs.reverse:
        cov = cov + turned_short_covariance(upright)
    chosen = order or rotation_order(upright.up / gravity_m_s2)
    _refuse_lock(upright.readings[0].label, upright.up, chosen)
    roll, pitch = roll_pitch(upright.up, chosen)
    to_angles = roll_pitch_jacobian(upright.up, chosen)
    levelled = mounting_rotation(chosen, roll, pitch)
    yaw = measure_yaw(logs.drive, accelerometer, levelled, logs.first_push) if logs.drive else None
    rotation = mounting_rotation(chosen, roll, pitch, yaw.yaw_rad) if yaw else levelled
    first = upright.forces[0]
    return Mounting(
        order=chosen,
        roll_rad=roll,
        pitch_rad=pitch,
        cov=to_angles @ cov @ to_angles.T,
        rotation=rotation,
        before=first,
        after=first @ rotation,
        magnitude_error_m_s2=float(np.linalg.norm(first)) - gravity_m_s2,
        notes=notes,
        samples=sum(reading.samples for reading in upright.readings),
        slope=floor_slope(upright, rotation, yaw) if logs.reverse else None,
        yaw=yaw,
        orders=try_orders(first, upright.up, cov, gravity_m_s2),
        readings=levelled_readings(logs.still, accelerometer, rotation),
    )


def _upright(logs: MountingLogs, accelerometer: TriadCalibration) -> HeadingForces:
    """Average and calibrate the still logs of each heading."""
    headings = (logs.still, logs.reverse) if logs.reverse else (logs.still,)
    readings = [still_reading(heading, accelerometer) for heading in headings]

    correction = accelerometer.correction

    def forces(by: Correction) -> FloatArray:
        return np.array([by.correct(reading.at)[0] for reading in readings])

    noise = np.array([noise_covariance(reading, correction) for reading in readings])
    of_calibration = accelerometer.covariance_of(lambda by: np.asarray(forces(by).mean(axis=0)))
    force = forces(correction)
    up = force.mean(axis=0)
    cov = noise.sum(axis=0) / len(noise) ** 2 + of_calibration + untold_covariance(
        accelerometer, up)
    return HeadingForces(readings, force, noise, up, cov)


def _of_untold(accelerometer: TriadCalibration) -> tuple[str, ...]:
    """A note on effects of the model that no still log tells; none where it tells all."""
    names = [effect.name for effect in untold(accelerometer)]
    return (f"no still log tells {' and '.join(names)} of the accelerometer's model: what whole "
            f"poses have is left out, and what moves with the session's clock counts as at its "
            f"end. The sds of the angles contain what the poses of the session differ by.",
            ) if names else ()


def _with_drift(
    upright: HeadingForces, gravity: float, gravity_sd: float
) -> tuple[FloatArray, tuple[str, ...]]:
    """Covariance (3, 3) of ``up`` with what the stated sds do not explain, and notes on it."""
    cov, notes = upright.cov, []
    for reading, force in zip(upright.readings, upright.forces, strict=True):
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
