"""Rate of the plate in a sensor's log over the one that a clip measured or the user stated.

Gravity rotates once per turn in the axes of a sensor on a plate that leans
(:mod:`calib.consistency.clock`), in the clock of the log; a clip has the rate in its own clock. The
ratio of the two rates is that of the two clocks, unless the plate changed its speed between clip
and poses. Beside a stated rate it is the error of that, unless the clock of the log is wrong. For
each ratio the waves of all poses are fitted jointly,

    z_p(t) = a_p + b_p t + c_p exp(-i r Ω_p t) + d_p exp(i r Ω_p t) + noise,

and the ratio r explains them best. The noise is measured beside the line.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from calib.consistency.clock import across_gravity
from calib.poses.checks.frozen import CERTAIN_SD
from calib.poses.data_sheet import TriadSpec
from calib.poses.imu_log import FloatArray, ImuLog

PER_LOBE = 8.0
"""Number of ratios that are fitted within the width of the line of a pose. Numerical."""

BETWEEN = 17
"""Number of ratios about the best of them; a parabola through the best three of these has its
minimum within a hundredth of an sd. Numerical."""

BESIDE = (0.3, 0.7)
"""Distances from the line, in rates, between which its noise is measured. Derived: nearer is the
line's own skirt, farther are the waves of the next order."""

LARGEST_DIFFERENCE = 0.1
"""Largest relative difference of two rates that is searched. Fact: the pitch of a record player is
set within 8 %, and two of its speeds are 35 % apart."""

CLEAR = 0.025
"""Share of ``LARGEST_DIFFERENCE`` that an sd must stay below for a ratio to be known. Derived: the
best ratio of noise alone has a fifth of it."""

CONTRADICTS = 2e-3
"""Relative difference from which two rates contradict each other, if it is significant. Fact: belt
drives change their speed by up to 0.2 %."""


OF_CLIP = (
    "Either the clock of the sensor or of the camera is off by that, or the plate changed its "
    "speed. A clip for each pose decides it, and `pipeline clock` measures the clock of the camera."
)
OF_STATED = (
    "Either the rate is off by that, or the clock of the sensor is. The sds of the gyroscope's "
    "scales contain the difference. A clip of the plate decides it."
)


@dataclass(frozen=True)
class ClockRatio:
    """Rate by the log's clock over the rate of the run, less one, and its sd.

    ``rate_sd`` is the relative sd of the rate of the run, ``filmed`` whether a clip measured it.
    """

    difference: float
    sd: float
    rate_sd: float
    filmed: bool

    @property
    def contradicts(self) -> bool:
        """Whether the two clocks, or the two speeds, differ."""
        sd = math.hypot(self.sd, self.rate_sd)
        return abs(self.difference) > max(CERTAIN_SD * sd, CONTRADICTS)

    @property
    def doubt(self) -> float:
        """Relative sd of a rate beside the stated one: their difference where they contradict each
        other, since either may be right. The clock of a camera errs less than a sensor's."""
        return abs(self.difference) if self.contradicts and not self.filmed else 0.0

    def warning(self, run: str) -> str:
        """Description of the contradiction, for the user."""
        return (
            f"{run}: by the time stamps of the logs the plate turned "
            f"{100 * abs(self.difference):.2f} ± {100 * self.sd:.2f} % "
            f"{'faster' if self.difference > 0 else 'slower'} than "
            f"{'by those of the clip' if self.filmed else 'stated'}: gravity goes round in the "
            f"accelerometer. {OF_CLIP if self.filmed else OF_STATED}"
        )


def clock_ratio(
    logs: Sequence[ImuLog], rate_rad_s: FloatArray, spec: TriadSpec, rate_sd: float, filmed: bool
) -> ClockRatio | None:
    """Compare the rate in the logs of one run with that of its clips, or the stated one.

    Parameters
    ----------
    logs : sequence of ImuLog, length n
        Poses on the turning plate.
    rate_rad_s : array, shape (n,)
        The plate's rate in each, positive.
    spec : TriadSpec
        Of the accelerometer.
    rate_sd : float
        Of the rate, relative.
    filmed : bool
        Whether a clip measured it.

    Returns
    -------
    ClockRatio or None
        None where the plate is too level, or the poses too short, to tell.
    """
    waves = [_Wave.of(log, float(rate), spec) for log, rate in zip(logs, rate_rad_s, strict=True)]
    turned = max(wave.turned_rad for wave in waves)
    reach = LARGEST_DIFFERENCE
    few = np.linspace(1 - reach, 1 + reach, int(PER_LOBE * 2 * reach * turned / np.pi) + 5)
    squares = [wave.squares(few) for wave in waves]
    noise = [wave.noise(few[np.argmin(each)]) for wave, each in zip(waves, squares, strict=True)]
    misfit = np.sum([each / of_one for each, of_one in zip(squares, noise, strict=True)], axis=0)
    best = int(np.argmin(misfit))
    if best in (0, len(few) - 1):
        return None
    near = np.linspace(few[best - 1], few[best + 1], BETWEEN)
    close = np.sum([wave.squares(near) / of_one
                    for wave, of_one in zip(waves, noise, strict=True)], axis=0)
    top = int(np.clip(np.argmin(close), 1, BETWEEN - 2))
    three = slice(top - 1, top + 2)
    bend, slope, _ = np.polyfit(near[three] - near[top], close[three], 2)
    if bend < 1 / (2 * (CLEAR * reach) ** 2):
        return None
    mean = near[top] - slope / (2 * bend)
    return ClockRatio(float(mean - 1), 1 / math.sqrt(2 * bend), rate_sd, filmed)


@dataclass(frozen=True, eq=False)
class _Wave:
    """Specific force ``z`` (m,) across gravity in one pose, at ``time_s`` about its middle."""

    rate_rad_s: float
    time_s: FloatArray
    z: np.ndarray
    line: np.ndarray

    @classmethod
    def of(cls, log: ImuLog, rate_rad_s: float, spec: TriadSpec) -> "_Wave":
        step_s, z = across_gravity(log, rate_rad_s, spec)
        time_s = np.asarray((np.arange(len(z)) - (len(z) - 1) / 2) * step_s)
        line = np.linalg.qr(np.column_stack([np.ones(len(z)), time_s]))[0]
        return cls(rate_rad_s, time_s, z - line @ (line.T @ z), line)

    @property
    def turned_rad(self) -> float:
        return float(2 * self.rate_rad_s * self.time_s[-1])

    def _without(self, ratios: FloatArray) -> np.ndarray:
        """What both rotations of each ratio leave of the wave, (r, m)."""
        wave = np.exp(-1j * self.rate_rad_s * np.outer(ratios, self.time_s))
        wave = wave - (wave @ self.line) @ self.line.T
        both = np.stack([wave, wave.conj()], axis=1)
        gram, along = both.conj() @ both.swapaxes(1, 2), both.conj() @ self.z
        size = np.linalg.solve(gram, along[..., None])
        return np.asarray(self.z - (both * size).sum(axis=1))

    def squares(self, ratios: FloatArray) -> FloatArray:
        """Sum of squared residuals for each ratio, (r,)."""
        return np.asarray((np.abs(self._without(ratios)) ** 2).sum(axis=1))

    def noise(self, ratio: float) -> float:
        """Variance of one value by the noise beside the line at ``ratio``."""
        rest = self._without(np.array([ratio]))[0]
        taper = np.hanning(len(rest))
        power = np.abs(np.fft.fft(rest * taper)) ** 2 / (taper**2).sum()
        step_s = self.time_s[1] - self.time_s[0]
        at = np.abs(np.fft.fftfreq(len(rest), step_s / (2 * np.pi))) / self.rate_rad_s
        beside = (np.abs(at - 1) > BESIDE[0]) & (np.abs(at - 1) < BESIDE[1])
        whole = float(np.mean(np.abs(rest) ** 2))
        return max(float(power[beside].mean()) if beside.any() else 0.0, whole)
