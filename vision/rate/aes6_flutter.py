"""Wow and flutter of a platter by AES6-2008: two-sigma figures, weighted and unweighted.

The standard (the same as IEC 60386, DIN 45507, CCIR 409) demodulates a tone of a test record,
weights the relative deviation δ(t) of its frequency by audibility, and states the value that |δ|
stays below for 95 % of the time. Here δ is that of the platter itself, δ = Ω(t)/Ω̄ - 1, without the
groove: the figures are called "platter", and a record with an eccentric hole adds to them. A sine
of amplitude A has the figure sin(0.95·90°) A = 0.997 A.
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from vision.errors import RateRefused
from vision.geometry import FloatArray
from vision.numbers import median
from vision.rate.unwrap import waves_per_turn

if TYPE_CHECKING:
    from vision.rate.measure import RateMeasurement

Gain = Callable[[FloatArray], FloatArray]

CURVE_HZ = (0.1, 0.2, 0.315, 0.4, 0.63, 0.8, 1.0, 1.6, 2.0, 4.0, 6.3, 10.0, 20.0, 40.0, 63.0, 100.0,
            200.0)  #: fact: frequencies of the standard's curve, with the gains below
CURVE_DB = (-48.0, -30.6, -19.7, -15.0, -8.4, -6.0, -4.2, -1.8, -0.9, 0.0, -0.9, -2.1, -5.9, -10.4,
            -14.2, -17.3, -23.0)  #: fact
LOWEST_HZ, HIGHEST_HZ = 0.2, 200.0  #: definition: the evaluated band
TWO_SIGMA = 0.95  #: definition: share of the time for which the figure holds
GAUSSIAN = 1.96  #: definition: limit of that share of a Gaussian, in sds

#: Terms of the rate's model that are motion of the platter; others belong to the camera.
OF_THE_PLATTER = ("once_per_rev", "twice_per_rev", "rate_drift")

WITHIN_FRAME_RATE = 0.45
"""Share of the sample rate up to which waves are included. Numerical: 2.2 samples per wave."""

FINER = 4  #: steps between two samples, to sample a fast wave at enough phases: numerical
SHORTEST_S = 5.0  #: definition: the standard's least length


@dataclass(frozen=True, eq=False)
class SpeedCourse:
    """The speed of a platter at even steps.

    Attributes
    ----------
    step_s : float
    angle_rad : array, shape (n,)
        Angle of the platter, growing.
    deviation : array, shape (n,)
        Relative deviation δ from the mean rate.
    rate_rad_s : float
        The mean rate, positive.
    noise_rad : float
        White noise of a single angle behind δ; 0 if δ was measured as a rate.
    across : array, shape (n, k)
        Readings across the axis of the platter, over its rate, of a sensor that turns with it.
    """

    step_s: float
    angle_rad: FloatArray
    deviation: FloatArray
    rate_rad_s: float
    noise_rad: float = 0.0
    across: FloatArray = field(default_factory=lambda: np.empty((0, 0)))

    @property
    def time_s(self) -> FloatArray:
        """Time since the first sample, (n,)."""
        return np.asarray(np.arange(len(self.deviation)) * self.step_s, float)

    @property
    def seconds(self) -> float:
        """Duration."""
        return len(self.deviation) * self.step_s

    @property
    def top_hz(self) -> float:
        """Highest frequency of the included waves."""
        return min(HIGHEST_HZ, WITHIN_FRAME_RATE / self.step_s)


@dataclass(frozen=True, eq=False)
class PlatterFlutter:
    """The figures; relative, of a two-sided deviation.

    Attributes
    ----------
    weighted, unweighted : float
        Two-sigma figures.
    weighted_noise, unweighted_noise : float
        Figures of the noise of the angles, or of the gyroscope, alone.
    lowest_hz, highest_hz : float
        The evaluated band.
    drift_per_s : float
        Relative change of the rate per second.
    hz, amplitude, noise_amplitude : array, shape (m,)
        Spectrum: amplitude of a wave of each frequency, and root mean square of that of the noise.
    """

    weighted: float
    unweighted: float
    weighted_noise: float
    unweighted_noise: float
    lowest_hz: float
    highest_hz: float
    drift_per_s: float
    hz: FloatArray
    amplitude: FloatArray
    noise_amplitude: FloatArray


def weighting(hz: FloatArray) -> FloatArray:
    """Gain of the standard's curve at frequencies (m,), shape (m,), without a unit.

    Linear in dB over the logarithm of the frequency.

    >>> weighting(np.array([4.0, 10.0])).round(3).tolist()
    [1.0, 0.785]
    """
    at, gain = np.log(CURVE_HZ), np.array(CURVE_DB)
    x = np.log(np.maximum(hz, 1e-6))
    db = np.interp(x, at, gain)
    for i, j, beyond in ((0, 1, x < at[0]), (-1, -2, x > at[-1])):
        slope = (gain[i] - gain[j]) / (at[i] - at[j])
        db = np.where(beyond, gain[i] + slope * (x - at[i]), db)
    return np.asarray(10 ** (db / 20))


def course_of_clip(rate: "RateMeasurement") -> SpeedCourse:
    """The speed from the angles of a clip, at the frame rate.

    Frames that were set aside are interpolated. Stated terms of the platter are included.
    """
    fit, angle = rate.fit, rate.history.angle
    step = float(median(np.diff(fit.time_s)))
    whole = fit.residual_rad + sum(
        (fit.columns[term.name] @ term.value for term in fit.terms if term.name in OF_THE_PLATTER),
        np.zeros(len(fit.time_s)))
    even = np.arange(fit.time_s[0], fit.time_s[-1], step)
    residual = np.interp(even, fit.time_s[fit.used], whole[fit.used])
    way = np.sign(angle.angle_rad[-1] - angle.angle_rad[0])
    deviation = way * _derivative(residual, step) / rate.rate_rad_s
    turned = way * np.interp(even, angle.time_s, angle.angle_rad)
    return SpeedCourse(step, turned, deviation, rate.rate_rad_s, rate.history.phase_noise_rad)


def course_of_rates(
    time_s: FloatArray, rate_rad_s: FloatArray, across_rad_s: FloatArray | None = None
) -> SpeedCourse:
    """The speed from rates (n,) about the axis of the platter, of a sensor that turns with it.

    The platter does not turn about the axes across, (n, k): their readings are noise.
    """
    step = float(median(np.diff(time_s)))
    even = np.arange(time_s[0], time_s[-1], step)
    rate = np.interp(even, time_s, rate_rad_s)
    mean = float(rate.mean())
    across = [np.interp(even, time_s, axis) for axis in
              (() if across_rad_s is None else across_rad_s.T)]
    return SpeedCourse(step, np.cumsum(np.abs(rate)) * step, rate / mean - 1, abs(mean),
                       across=np.array(across).T / mean)


def platter_flutter(course: SpeedCourse, source: str) -> PlatterFlutter:
    """The figures of a course.

    Parameters
    ----------
    course : SpeedCourse
    source : str
        Its name, for messages.

    Raises
    ------
    RateRefused
        It is shorter than the standard allows, or has fewer than ten samples in a second.
    """
    if course.seconds < SHORTEST_S or course.top_hz < 4.0:
        raise RateRefused(
            f"{source}: {course.seconds:.1f} s at {1 / course.step_s:.4g} samples per second; wow "
            f"and flutter need at least {SHORTEST_S:g} s and 9 per second, since the ear is most "
            f"sensitive at 4 Hz."
        )
    n = len(course.deviation)
    drift, flat = _without_drift(course)
    taper = np.hanning(n)
    hz = np.asarray(np.fft.rfftfreq(n, course.step_s), float)

    def spectrum(values: FloatArray) -> FloatArray:
        return np.asarray(2 * np.abs(np.fft.rfft(values * taper)) / taper.sum())

    # Of white noise every value of the spectrum has the same mean square.
    noise = np.sqrt(np.mean([spectrum(axis) ** 2 for axis in _noise_across(course).T])
                    if course.across.size else
                    _density_of_angles(course, hz) * 2 * (taper @ taper) / course.step_s
                    / taper.sum() ** 2) * np.ones(len(hz))
    shown = (hz >= 1 / course.seconds) & (hz <= course.top_hz)
    lowest = max(LOWEST_HZ, 1 / course.seconds)

    def counted(at: FloatArray) -> FloatArray:
        return np.asarray(((at >= lowest) & (at <= course.top_hz)).astype(float))

    def heard(at: FloatArray) -> FloatArray:
        return np.asarray(weighting(at) * (at <= WITHIN_FRAME_RATE / course.step_s))

    def two_sigma(gain: Gain) -> float:
        return float(np.quantile(np.abs(_filtered(flat, course.step_s, gain)), TWO_SIGMA))

    return PlatterFlutter(
        weighted=two_sigma(heard),
        unweighted=two_sigma(counted),
        weighted_noise=_noise_figure(course, heard),
        unweighted_noise=_noise_figure(course, counted),
        lowest_hz=lowest,
        highest_hz=course.top_hz,
        drift_per_s=drift,
        hz=hz[shown],
        amplitude=spectrum(flat)[shown],
        noise_amplitude=noise[shown],
    )


def _without_drift(course: SpeedCourse) -> tuple[float, FloatArray]:
    """The drift per second, and the deviation (n,) without it and without its mean.

    Fitted to the angle beyond the mean rate, where noise has least effect, together with the waves
    once and twice per turn, whose last period is incomplete.
    """
    time_s = course.time_s - course.seconds / 2
    beyond = np.cumsum(course.deviation) * course.step_s
    columns = np.column_stack([
        np.ones_like(time_s), time_s, 0.5 * time_s**2, waves_per_turn(course.angle_rad)])
    beta = np.linalg.lstsq(columns, beyond, rcond=None)[0]
    return float(beta[2]), np.asarray(course.deviation - beta[1] - beta[2] * time_s)


def _noise_figure(course: SpeedCourse, gain: Gain) -> float:
    """Two-sigma figure of white noise of the angles, or of the readings across the axis."""
    if course.across.size:
        return float(np.quantile(np.abs([
            _filtered(axis, course.step_s, gain) for axis in _noise_across(course).T]), TWO_SIGMA))
    hz = np.asarray(np.linspace(0, 0.5 / course.step_s, 4096), float)
    density = _density_of_angles(course, hz)
    return GAUSSIAN * float(np.sqrt(np.trapezoid(density * gain(hz) ** 2, hz)))


def _noise_across(course: SpeedCourse) -> FloatArray:
    """The readings across the axis, (n, k), without what is stationary.

    The Earth's rate or a tilted table appear there as a wave once per turn, which is not noise.
    """
    columns = np.column_stack([np.ones(len(course.across)), waves_per_turn(course.angle_rad)])
    return np.asarray(
        course.across - columns @ np.linalg.lstsq(columns, course.across, rcond=None)[0])


def _density_of_angles(course: SpeedCourse, hz: FloatArray) -> FloatArray:
    """One-sided density of the deviation by white noise of the angles, (m,), 1/Hz."""
    return 2 * course.noise_rad**2 * course.step_s * (2 * np.pi * hz / course.rate_rad_s) ** 2


def _derivative(values: FloatArray, step_s: float) -> FloatArray:
    """Derivative of values (n,) at even steps, up to ``WITHIN_FRAME_RATE``, per second."""
    n = len(values)
    # Reflected through its ends, the course continues without a jump or a kink.
    before, after = 2 * values[0] - values[:0:-1], 2 * values[-1] - values[-2::-1]
    line = np.concatenate([before, values, after])
    ends = np.linspace(line[0], line[-1], len(line))
    hz = np.asarray(np.fft.rfftfreq(len(line), step_s), float)
    gain = 2j * np.pi * hz * (hz <= WITHIN_FRAME_RATE / step_s)
    slope = np.fft.irfft(np.fft.rfft(line - ends) * gain, len(line))
    return np.asarray(slope[n - 1 : 2 * n - 1] + (line[-1] - line[0]) / (len(line) - 1) / step_s)


def _filtered(values: FloatArray, step_s: float, gain: Gain) -> FloatArray:
    """Values (n,) filtered by a gain over frequency, mirrored at both ends, (FINER n,)."""
    n = len(values)
    line = np.concatenate([values[:0:-1], values, values[-2::-1]])
    hz = np.asarray(np.fft.rfftfreq(len(line), step_s), float)
    spectrum = np.fft.rfft(line) * gain(hz)
    finer = np.fft.irfft(spectrum, FINER * len(line)) * FINER
    return np.asarray(finer[FINER * (n - 1) : FINER * (2 * n - 1)])
