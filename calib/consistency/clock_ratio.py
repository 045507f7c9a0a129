"""Ratio of the clock of a sensor's log to that of the clip of the same run.

Gravity rotates once per turn in the axes of a sensor on a plate that leans
(:mod:`calib.consistency.clock`), in the clock of the log; the clip states the rate in its own
clock. The ratio of the two rates is that of the two clocks, unless the plate changed its speed
between clip and poses. For each ratio the waves of all poses are fitted jointly,

    z_p(t) = a_p + b_p t + c_p exp(-i r Ω_p t) + d_p exp(i r Ω_p t) + noise,

and the ratio r is the mean over all that explain them. The noise is measured beside the line.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from calib.consistency.clock import LARGEST_CLOCK_ERROR, across_gravity
from calib.poses.checks.frozen import CERTAIN_SD
from calib.poses.data_sheet import TriadSpec
from calib.poses.imu_log import FloatArray, ImuLog

PER_LOBE = 8.0
"""Number of ratios that are fitted within the width of the line of a pose. Numerical."""

BETWEEN = 4000
"""Number of ratios between them, on a smooth curve through their misfits. Numerical."""

BESIDE = (0.3, 0.7)
"""Distances from the line, in rates, between which its noise is measured. Derived: nearer is the
line's own skirt, farther are the waves of the next order."""

CLEAR = 0.05
"""Share of ``LARGEST_CLOCK_ERROR`` that an sd must stay below for a ratio to be known. Derived: the
best ratio of noise alone has a fifth of it."""

CONTRADICTS = 2e-3
"""Relative difference from which two clocks contradict each other, if it is significant. Fact: belt
drives change their speed by up to 0.2 %."""


@dataclass(frozen=True)
class ClockRatio:
    """Rate by the log's clock over the rate by the clip's, less one, and its sd."""

    difference: float
    sd: float

    @property
    def contradicts(self) -> bool:
        """Whether the two clocks, or the two speeds, differ."""
        return abs(self.difference) > max(CERTAIN_SD * self.sd, CONTRADICTS)

    def warning(self, run: str) -> str:
        """Description of the contradiction, for the user."""
        return (
            f"{run}: by the time stamps of the logs the plate turned "
            f"{100 * abs(self.difference):.2f} ± {100 * self.sd:.2f} % "
            f"{'faster' if self.difference > 0 else 'slower'} than by those of the clip: gravity "
            f"goes round in the accelerometer. Either the clock of the sensor or of the camera is "
            f"off by that, or the plate changed its speed. A clip for each pose decides it, and "
            f"`pipeline clock` measures the clock of the camera."
        )


def clock_ratio(
    logs: Sequence[ImuLog], clip_rad_s: FloatArray, spec: TriadSpec
) -> ClockRatio | None:
    """Compare the clocks of the logs and of the clips of one run.

    Parameters
    ----------
    logs : sequence of ImuLog, length n
        Poses on the turning plate.
    clip_rad_s : array, shape (n,)
        The plate's rate in each by the clip, positive.
    spec : TriadSpec
        Of the accelerometer.

    Returns
    -------
    ClockRatio or None
        None where the plate is too level, or the poses too short, to tell.
    """
    from scipy.interpolate import CubicSpline  # few sessions have a clip for each log

    waves = [(float(rate), *across_gravity(log, float(rate), spec))
             for log, rate in zip(logs, clip_rad_s, strict=True)]
    turned = max(rate * step * len(z) for rate, step, z in waves)
    reach = LARGEST_CLOCK_ERROR
    few = np.linspace(1 - reach, 1 + reach, int(PER_LOBE * 2 * reach * turned / np.pi) + 5)
    misfits = np.zeros(len(few))
    for rate, step, z in waves:
        squares, noise = _misfit(z, step, rate, few)
        misfits += squares / noise
    ratios = np.linspace(few[0], few[-1], BETWEEN)
    chance = -CubicSpline(few, misfits)(ratios)
    weight = np.exp(chance - chance.max())
    weight /= weight.sum()
    mean = float(weight @ ratios)
    sd = float(np.sqrt(weight @ (ratios - mean) ** 2))
    return ClockRatio(mean - 1, sd) if sd < CLEAR * reach else None


def _misfit(
    z: np.ndarray, step_s: float, rate_rad_s: float, ratios: FloatArray
) -> tuple[FloatArray, float]:
    """Sum of squared residuals for each ratio, (r,), and the variance of one by the noise."""
    time_s = (np.arange(len(z)) - (len(z) - 1) / 2) * step_s
    line = np.column_stack([np.ones(len(z)), time_s])
    squares = np.empty(len(ratios))
    least, rest = np.inf, z
    for i, ratio in enumerate(ratios):
        wave = np.exp(-1j * rate_rad_s * ratio * time_s)
        columns = np.column_stack([line, wave, wave.conj()])
        residual = z - columns @ np.linalg.lstsq(columns, z, rcond=None)[0]
        squares[i] = float((np.abs(residual) ** 2).sum())
        if squares[i] < least:
            least, rest = squares[i], residual
    taper = np.hanning(len(z))
    power = np.abs(np.fft.fft(rest * taper)) ** 2 / (taper**2).sum()
    off = np.abs(np.abs(np.fft.fftfreq(len(z), step_s / (2 * np.pi))) / rate_rad_s - 1)
    beside = (off > BESIDE[0]) & (off < BESIDE[1])
    return squares, max(float(power[beside].mean()) if beside.any() else 0.0, least / len(z))
