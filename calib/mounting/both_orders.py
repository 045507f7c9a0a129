"""Comparison of the two rotation orders of a mounting, and levelled readings: Promrit, figure 5.

The paper chooses the order by eq. (6), and notes that one may also try both and take the better
one. Both orders level the mean reading exactly, so the remainder is the same; they differ in the
angles, in how well these are determined, and in the heading that they leave to the yaw.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from calib.fit.triad.calibration import TriadCalibration
from calib.mounting.levelling import (
    ORDERS,
    Order,
    mounting_rotation,
    order_margins,
    roll_pitch,
    roll_pitch_jacobian,
)
from calib.mounting.still_reading import log_conditions
from calib.poses.imu_log import FloatArray, ImuLog

MOST_READINGS = 300  #: readings in a figure: as many as the paper's figure 5 has; of a picture


@dataclass(frozen=True, eq=False)
class OrderTrial:
    """Roll and pitch in one rotation order.

    Parameters
    ----------
    order : str
    roll_rad, pitch_rad : float
    sd_rad : array, shape (2,)
        Their sds; infinite where the order is locked.
    margin : float
        This order's side of eq. (6), of gravity; the smaller side names the order.
    residual_m_s2 : float
        Distance of the levelled mean reading from (0, 0, g).
    """

    order: Order
    roll_rad: float
    pitch_rad: float
    sd_rad: FloatArray
    margin: float
    residual_m_s2: float


@dataclass(frozen=True, eq=False)
class LevelledReadings:
    """Single calibrated readings of the still logs.

    Parameters
    ----------
    time_s : array, shape (n,)
        From the first reading, the logs one after the other.
    before, after : array, shape (n, 3)
        In the sensor's axes, and in the vehicle's, m/s².
    """

    time_s: FloatArray
    before: FloatArray
    after: FloatArray


def try_orders(
    force: FloatArray, up: FloatArray, cov: FloatArray, gravity_m_s2: float
) -> tuple[OrderTrial, ...]:
    """Roll, pitch and the remainder, in each order.

    Parameters
    ----------
    force : array, shape (3,)
        Calibrated mean reading at the first heading, m/s².
    up : array, shape (3,)
        The reading that is levelled: mean of the headings, m/s².
    cov : array, shape (3, 3)
        Its covariance.
    gravity_m_s2 : float
    """
    margins = order_margins(up / gravity_m_s2)
    trials = []
    for order in ORDERS:
        roll, pitch = roll_pitch(up, order)
        with np.errstate(divide="ignore", invalid="ignore"):  # gimbal lock
            to_angles = roll_pitch_jacobian(up, order)
            sd = np.sqrt(np.diag(to_angles @ cov @ to_angles.T))
        rest = force @ mounting_rotation(order, roll, pitch) - np.array([0, 0, gravity_m_s2])
        trials.append(OrderTrial(order, roll, pitch, np.where(np.isfinite(sd), sd, np.inf),
                                 margins[order], float(np.linalg.norm(rest))))
    return tuple(trials)


def levelled_readings(
    logs: Sequence[ImuLog], accelerometer: TriadCalibration, rotation: FloatArray
) -> LevelledReadings:
    """At most ``MOST_READINGS`` single readings, evenly spread over the logs.

    Parameters
    ----------
    logs : sequence of ImuLog
        At rest, of one heading.
    accelerometer : TriadCalibration
    rotation : array, shape (3, 3)
        From the vehicle's axes to the sensor's.
    """
    forces, times, begin_s = [], [], 0.0
    for log in logs:
        nominal = accelerometer.spec.nominal(log.accelerometer)
        forces.append(accelerometer.correct(log_conditions(log, nominal, accelerometer.end_s)))
        since = log.time_s - log.time_s[0]
        times.append(begin_s + since)
        begin_s += float(since[-1]) + float(np.median(np.diff(since)))
    before, time_s = np.concatenate(forces), np.concatenate(times)
    shown = np.unique(np.linspace(0, len(time_s) - 1, min(len(time_s), MOST_READINGS)).astype(int))
    return LevelledReadings(time_s[shown], before[shown], before[shown] @ rotation)
