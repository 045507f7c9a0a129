"""A camera's clock from the film of a rotating hand on a computer's screen.

A screen holds each picture until its next refresh, and the hand lags behind the present angle, in a
saw-tooth with the period of the refresh that the camera samples once a frame:

    θ_i / Ω = a + u_i - r L(u_i / r + φ, e) + waves + noise,     u_i = t_i / (1 + ε)

with t the stamps, ε the error of the camera's clock, r the time between refreshes, L the mean of
the saw-tooth over an exposure of e refreshes, φ the phase of the first refresh. All of it is by the
clock of the page that draws. With nearly a whole number of refreshes per frame the tooth passes
slowly, which looks like another rate: a straight line errs by up to 100 ppm in a minute. So ε, φ
and e are searched jointly, and ε is the mean over all values that explain the film. A read-out line
by line and a view from the side are waves once and twice per turn; they are fitted, and over many
turns they change no rate.
"""

from dataclasses import dataclass

import numpy as np

from vision.errors import RateRefused
from vision.geometry import FloatArray
from vision.numbers import median
from vision.rate.least_squares import correlation_time
from vision.rate.measure import RateMeasurement

PHASES = 48
"""Number of resolved phases of the refresh. Numerical: steps of 0.35 ms at 60 Hz, below the
noise."""

EXPOSURES = (0.05, 0.2, 0.4, 0.6, 0.8, 1.0, 1.25, 1.5, 1.8, 2.2)
"""Refreshes per exposure, and read-out: 1/1000 to 1/30 s at 60 Hz. Numerical."""

MOST_FOLD = 6
"""Frames over which the saw-tooth may repeat itself: 10 to 60 frames per second at 60 Hz.
Numerical."""


# Range of the search, and limits of the result.
LEAK = 1.5
"""Largest error of a straight line, refreshes over the length of the film. Derived: that of a step
in its middle."""
UNLIKE = 0.1
"""Share of the saw-tooth by which its form may differ from the model: a read-out line by line, a
screen that is written line by line, slow liquid crystals. A judgement."""
LEAST_TURNS = 8.0
"""Least number of turns of the hand. Derived: waves of the view leak 12 / (2π 8)² of themselves
into the rate."""


@dataclass(frozen=True)
class FilmedScreen:
    """The camera's clock by a film of the rotating hand.

    Attributes
    ----------
    fast : float
        The clock's seconds per second of the page's clock, less one.
    frames_sd, refresh_sd : float
        Its sd by the frames and the modelled saw-tooth, and by a saw-tooth of another form.
    noise_s : float
        Residual of an angle, as the time in which the hand turns by it.
    beats : float
        Number of saw-teeth that pass in the film.
    seconds, turns : float
        Length of the film.
    """

    fast: float
    frames_sd: float
    refresh_sd: float
    noise_s: float
    beats: float
    seconds: float
    turns: float


def clock_by_screen(
    rate: RateMeasurement, source: str, drawn_rad_s: float, refresh_hz: float
) -> FilmedScreen:
    """Compare the camera's stamps with the page's clock.

    Parameters
    ----------
    rate : RateMeasurement
        Rate of the film, by its own stamps.
    source : str
        The film's name, for messages.
    drawn_rad_s : float
        Rate of the hand by the page's clock, positive.
    refresh_hz : float
        Refreshes per second by the page's clock.

    Raises
    ------
    RateRefused
        Too few turns, or frames that were lost behind the stamps.
    """
    angle = rate.history.angle
    if rate.revolutions < LEAST_TURNS:
        raise RateRefused(
            f"{source}: the hand makes {rate.revolutions:.1f} turns, at least "
            f"{LEAST_TURNS:g} are needed. Film it for some minutes."
        )
    if rate.frames.dropped:
        raise RateRefused(
            f"{source}: {rate.frames.dropped} frames are missing without a gap in the time stamps, "
            f"so that the stamps are no clock. Film with fewer pixels or frames per second."
        )
    time_s = angle.time_s - angle.time_s.mean()
    turned = angle.angle_rad * np.sign(angle.angle_rad[-1] - angle.angle_rad[0])
    late_s, line = _without_waves(time_s, turned, drawn_rad_s)
    hold = _Hold(time_s, late_s, 1 / refresh_hz)
    slope, sd, noise_s = hold.slope(line)
    beats, leak = _leak(float(median(np.diff(time_s))) * slope * refresh_hz, len(time_s))
    return FilmedScreen(
        fast=1 / slope - 1,
        frames_sd=sd,
        refresh_sd=UNLIKE * leak / refresh_hz / hold.length_s,
        noise_s=noise_s,
        beats=beats,
        seconds=hold.length_s,
        turns=rate.revolutions,
    )


def _without_waves(
    time_s: FloatArray, turned: FloatArray, drawn_rad_s: float
) -> tuple[FloatArray, float]:
    """Drawn time, from the middle of the film, without waves, (n,); its slope."""
    drawn_s = turned / drawn_rad_s
    waves = [wave(k * turned) for k in (1, 2) for wave in (np.cos, np.sin)]
    columns = np.column_stack([np.ones_like(time_s), *waves, time_s])
    beta = np.linalg.lstsq(columns, drawn_s, rcond=None)[0]
    return np.asarray(drawn_s - columns[:, :-1] @ beta[:-1]), float(beta[-1])


@dataclass(frozen=True, eq=False)
class _Hold:
    """Drawn times, seconds (n,), against stamps (n,), on a screen that holds for ``hold_s``."""

    time_s: FloatArray
    drawn_s: FloatArray
    hold_s: float

    @property
    def length_s(self) -> float:
        """Length of the film."""
        return float(np.ptp(self.time_s))

    def slope(self, line: float) -> tuple[float, float, float]:
        """Seconds drawn per second stamped, its sd, and the noise in s, near a line's slope."""
        reach = LEAK * self.hold_s / self.length_s
        step = self.hold_s / self.length_s / (2 * PHASES)
        slopes = line + np.arange(-reach, reach + step, step)
        teeth = self._teeth()
        squares = np.array([self._squares(slope, teeth) for slope in slopes])  # (s, e, φ)
        best = np.unravel_index(int(squares.argmin()), squares.shape)
        residual = self._residual(float(slopes[best[0]]), EXPOSURES[best[1]], best[2] / PHASES)
        variance = float((residual**2).mean())
        # Errors of neighbouring frames are correlated if the form differs from the model.
        chance = squares / (variance * correlation_time(residual))
        weight = np.exp((chance.min() - chance) / 2).sum(axis=(1, 2))
        weight /= weight.sum()
        mean = float(weight @ slopes)
        spread = float(weight @ (slopes - mean) ** 2) + step**2 / 12
        return mean, float(np.sqrt(spread)), float(np.sqrt(variance))

    def _teeth(self) -> FloatArray:
        """Mean lag in s at each phase, (e, φ, phases), for each exposure and first refresh."""
        middles = (np.arange(PHASES) + 0.5) / PHASES
        shifted = middles + np.arange(PHASES)[:, None] / PHASES
        return self.hold_s * np.array([_mean_lag(shifted, e) for e in EXPOSURES])

    def _squares(self, slope: float, teeth: FloatArray) -> FloatArray:
        """Sum of squared residuals, (e, φ), the constant fitted."""
        phase = np.mod(self.time_s * slope / self.hold_s, 1.0)
        place = np.minimum((phase * PHASES).astype(np.intp), PHASES - 1)
        residual = self.drawn_s - slope * self.time_s
        frames = np.bincount(place, minlength=PHASES).astype(float)
        sums = np.bincount(place, residual, PHASES)
        mean = (teeth @ frames + sums.sum()) / len(residual)
        return np.asarray(residual @ residual + 2 * teeth @ sums + teeth**2 @ frames
                          - len(residual) * mean**2)

    def _residual(self, slope: float, exposure: float, first: float) -> FloatArray:
        phase = self.time_s * slope / self.hold_s + first
        residual = self.drawn_s - slope * self.time_s + self.hold_s * _mean_lag(phase, exposure)
        return np.asarray(residual - residual.mean())


def _mean_lag(phase: FloatArray, exposure: float) -> FloatArray:
    """Mean of the saw-tooth frac(x) over ``exposure`` about ``phase``, same shape, refreshes."""

    def integral(x: FloatArray) -> FloatArray:
        whole = np.floor(x)
        return np.asarray(whole / 2 + (x - whole) ** 2 / 2)

    return (integral(phase + exposure / 2) - integral(phase - exposure / 2)) / exposure


def _leak(per_frame: float, frames: int) -> tuple[float, float]:
    """Saw-teeth that pass in the film, and their leakage into the slope, refreshes per film.

    The mean of n frames has a tooth of an n-th of the height, which passes at the difference of n
    frames from a whole number of refreshes. A wave of M periods leaks 1 / M² of itself, up to one
    period all of it.
    """
    passing = [abs(n * per_frame - round(n * per_frame)) * frames for n in range(1, MOST_FOLD + 1)]
    leaks = [1 / n / max(1.0, beats) ** 2 for n, beats in enumerate(passing, start=1)]
    worst = int(np.argmax(leaks))
    return passing[worst] / (worst + 1), leaks[worst]
