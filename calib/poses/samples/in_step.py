"""Waves of a sensor in step with the plate on which it turns, once and twice per turn.

On a plate that leans gravity turns in the sensor's axes, a wave of g sin(tilt) once per turn. The
readings of a pose are fitted, at the angles of the plate, by

    y = y_0 + Σ_h (a_h cos hθ + b_h sin hθ) + d t,   h = 1, 2

The angle is the integral of the gyroscope's reading along the axis of the plate, so that wow does
not spread a wave over its neighbours, and the known rate where there is no gyroscope. The sd of an
amplitude follows from the power of the residual beside the wave in the spectrum: correlated noise
has a different power there than in the mean. The fit removes a share of that power, and the line
makes an amplitude less certain: white noise shows by how much.
"""

import math
from dataclasses import dataclass

import numpy as np

from calib.numbers import NO_LENGTH
from calib.poses.imu_log import FloatArray

HARMONICS = (1, 2)  #: per turn; fact: tilt once, ellipticity twice
NEIGHBOURS = (-2, -1, 1, 2)
"""Waves beyond the number of turns whose power is the noise. Derived: symmetric, so that a spectrum
that falls in between is not mistaken."""

FEWEST_TURNS = 3
"""Number of turns of a pose that shows a wave. Derived: the lowest neighbour then is one wave per
pose."""

RATE_STEPS = 4  #: numerical limit: each squares the remaining error
RIGHT_RATE = 2e-3
"""Relative. Derived: over five turns the wave is then out of step by less than a sixteenth of a
radian at the ends, and its remainder looks like noise of a hundredth."""
LARGEST_RATE_ERROR = 0.1
"""Relative. Fact: the pitch of a record player is set within 8 %, gains of gyroscopes are nearer,
and another speed of the plate is farther."""
LEAST_WAVE_M_S2 = 0.2  #: m/s²; derived: a plate that leans by a degree

LARGEST_WOW = 0.2
"""Share of the rate: a plate that varies by more, or a gyroscope that is far off, does not give the
angle. A judgement."""


@dataclass(frozen=True, eq=False)
class Waves:
    """The waves of k axes in one pose, each in its unit; k is 3 for those of one triad.

    Attributes
    ----------
    amplitude : array, shape (2, 2, k)
        Once and twice per turn, of the cosine and of the sine, of every axis.
    variance : array, shape (2, k)
        Of the amplitudes once and twice per turn.
    """

    amplitude: FloatArray
    variance: FloatArray

    def of(self, axes: slice) -> "Waves":
        """Waves of the axes in a slice of the k."""
        return Waves(self.amplitude[..., axes], self.variance[:, axes])


def plate_angle(time_s: FloatArray, gyroscope: FloatArray | None, rate_rad_s: float) -> FloatArray:
    """The angle by which the plate has turned.

    Parameters
    ----------
    time_s : array, shape (t,)
        Over whole turns.
    gyroscope : array, shape (t, 3), or None
        Nominal readings, rad/s.
    rate_rad_s : float
        Of the plate, positive.

    Returns
    -------
    array, shape (t,)
        rad, from 0, increasing.
    """
    steady = rate_rad_s * (time_s - time_s[0])
    if gyroscope is None:
        return np.asarray(steady)
    mean = gyroscope.mean(axis=0)
    size = float(np.linalg.norm(mean))
    varies = gyroscope @ mean / max(size**2, NO_LENGTH) - 1
    step = np.diff(time_s)
    beside = np.concatenate([[0.0], np.cumsum((varies[1:] + varies[:-1]) / 2 * step)])
    if np.abs(beside).max() * rate_rad_s > LARGEST_WOW:
        return np.asarray(steady)
    return np.asarray(steady + rate_rad_s * beside)


def rate_in_step(force: FloatArray, time_s: FloatArray, rate_rad_s: float) -> float:
    """The rate of the plate by the phase of gravity's wave, where a stated one is off.

    Parameters
    ----------
    force : array, shape (t, 3)
        Nominal, m/s².
    time_s : array, shape (t,)
    rate_rad_s : float
        Approximate, positive.

    Returns
    -------
    float
        rad/s; the stated rate on a plate that is nearly level, or where it is right to
        ``RIGHT_RATE``.
    """
    across = force - force.mean(axis=0)
    step_s = (time_s[-1] - time_s[0]) / (len(time_s) - 1)
    rate = rate_rad_s
    for _ in range(RATE_STEPS):
        turn = 2 * math.pi / (rate * step_s)  # samples
        # Over whole turns the waves that rotate the other way, and twice, average out.
        part = round(len(time_s) / turn // 2 * turn)
        if not part:
            return rate_rad_s
        turned = across * np.exp(-1j * rate * (time_s - time_s[0]))[:, None]
        first, second = turned[:part].mean(axis=0), turned[-part:].mean(axis=0)
        if 2 * np.linalg.norm(first + second) / 2 < LEAST_WAVE_M_S2:
            return rate_rad_s
        between = float(time_s[-part:].mean() - time_s[:part].mean())
        rate += float(np.angle(np.vdot(first, second))) / between
    off = abs(rate / rate_rad_s - 1)
    return rate if RIGHT_RATE < off < LARGEST_RATE_ERROR else rate_rad_s


def waves_of(values: FloatArray, time_s: FloatArray, angle: FloatArray) -> Waves | None:
    """The waves of readings in step with the plate.

    Parameters
    ----------
    values : array, shape (t, k)
        Of all axes, each in its unit.
    time_s, angle : array, shape (t,)
        Time stamps and the angle of the plate, rad.

    Returns
    -------
    Waves or None
        None where fewer than ``FEWEST_TURNS`` whole turns show them.
    """
    turns = round(float(angle[-1]) / (2 * math.pi))
    if turns < FEWEST_TURNS:
        return None
    line = (time_s - time_s.mean()) / max(float(np.ptp(time_s)), NO_LENGTH)
    waves = [f(h * angle) for h in HARMONICS for f in (np.cos, np.sin)]
    design = np.column_stack([*waves, np.ones(len(angle)), line])
    shapes, size = np.linalg.qr(design)
    inverse = np.linalg.inv(size)
    solution = inverse @ (shapes.T @ values)
    rest = values - design @ solution
    amplitude = solution[: 2 * len(HARMONICS)].reshape(len(HARMONICS), 2, -1)
    unit = (inverse[: 2 * len(HARMONICS)] ** 2).sum(axis=1)  # variance in white noise of one
    variance = []
    for harmonic, of_one in zip(HARMONICS, unit.reshape(-1, 2).mean(axis=1), strict=True):
        beside = np.exp(-1j * np.outer(harmonic + np.array(NEIGHBOURS) / turns, angle))
        power = (np.abs(beside @ rest) ** 2).mean(axis=0)
        white = len(angle) - (np.abs(beside @ shapes) ** 2).sum(axis=1).mean()
        variance.append(of_one * power / white)
    return Waves(amplitude, np.array(variance))
