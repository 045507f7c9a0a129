"""Three more ways to the rate, none as good, that would notice if the first went wrong.

The centroid of the mark, the count of frames between alignments, and the return of the picture
after whole turns. They are compared with the rate, not averaged with it.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from vision.geometry import FloatArray
from vision.phase_track import PhaseTrack, PlateAngle
from vision.rate.aliases import RPM
from vision.rate.least_squares import least_squares
from vision.rate.unwrap import frame_time

CLEAR_PEAK = 0.25  # correlation a return must reach
AROUND = 0.06  # of a turn, to both sides of where the return is expected
FEWEST_RETURNS = 2  # one alone may be chance
LONGEST = 4000  # pictures looked at
READ_OFF = 0.2  # frames: the parabola through a narrow peak leans to the whole frame

END_SD = 1 / np.sqrt(6.0)  # frames: the difference of two ends rounded to whole frames
GAP = 1.5  # frames between the pictures before and after an alignment; more is a gap

APART = 5.0  # standard deviations
CENTROID_MATTERS = 50e-6  # relative
LAG_MATTERS = 2e-3  # relative
COUNT_APART = 1.05  # frames; rounding both ends gives up to one
SLIPPED = 0.02  # of the pictures with the centroid elsewhere than the refined angle


@dataclass(frozen=True, eq=False)
class FrameCount:
    """Rate from counted frames.

    Attributes
    ----------
    rate_rad_s, sd_rad_s : float
    alignments : array of int
        Pictures in which the marks are aligned.
    """

    rate_rad_s: float
    sd_rad_s: float
    alignments: NDArray[np.intp]


def count_frames(angle: PlateAngle, mark_rad: float, deck_mark_rad: float) -> FrameCount | None:
    """Count; None with fewer than two alignments.

    Parameters
    ----------
    angle : PlateAngle
    mark_rad : float
        Azimuth of the plate's mark at plate angle zero; NaN takes the plate's own zero.
    deck_mark_rad : float
        Azimuth of the fixed mark; NaN takes the place where the plate's mark was first.
    """
    mark = angle.angle_rad + (0.0 if np.isnan(mark_rad) else mark_rad)
    fixed = mark[0] if np.isnan(deck_mark_rad) else deck_mark_rad
    turns = (mark - fixed) / (2 * np.pi)
    sign = 1.0 if turns[-1] >= turns[0] else -1.0
    progress = np.maximum.accumulate(sign * turns)
    whole = np.arange(np.ceil(progress[0]), np.floor(progress[-1]) + 1)
    after = np.searchsorted(progress, whole).clip(1, len(progress) - 1)
    # Nobody sees an alignment that falls where pictures are left out.
    frame_s = frame_time(angle.time_s)
    seen = np.diff(angle.time_s)[after - 1] < GAP * frame_s
    whole, after = whole[seen], after[seen]
    if len(whole) < 2:
        return None
    nearer = np.abs(progress[after - 1] - whole) < np.abs(progress[after] - whole)
    aligned = np.where(nearer, after - 1, after)
    time = angle.repaired_time_s[aligned[-1]] - angle.repaired_time_s[aligned[0]]
    rate = 2 * np.pi * (whole[-1] - whole[0]) / float(time)
    sd = rate * END_SD * frame_s / float(time)
    return FrameCount(rate, sd, angle.index[aligned])


@dataclass(frozen=True)
class LagRate:
    """Rate from the latest clear return of the picture."""

    rate_rad_s: float
    sd_rad_s: float
    turns: int


def lag_rate(track: PhaseTrack, time_s: FloatArray, rate_rad_s: float) -> LagRate | None:
    """Rate by autocorrelation near ``rate_rad_s``; None without clear returns.

    Needs evenly spaced pictures.
    """
    step = np.diff(time_s)
    frame_s = frame_time(time_s)
    if np.abs(step - frame_s).max() > 0.05 * frame_s:
        return None
    values = track.thumbnail[:LONGEST].astype(np.float32)
    values -= values.mean(axis=0)
    values -= values.mean(axis=1, keepdims=True)  # flicker
    correlation = _autocorrelation(values)
    per_turn = 2 * np.pi / (abs(rate_rad_s) * frame_s)
    found: list[tuple[int, float]] = []
    for turns in range(1, int(0.8 * len(values) / per_turn) + 1):
        expected = turns * per_turn
        reach = max(2.0, AROUND * per_turn)
        low, high = int(np.floor(expected - reach)), int(np.ceil(expected + reach)) + 1
        if low < 2 or high > len(correlation) - 1:
            continue
        peak = low + int(correlation[low:high].argmax())
        if peak in (low, high - 1) or correlation[peak] < CLEAR_PEAK:
            continue
        before, at, after = correlation[peak - 1 : peak + 2]
        found.append((turns, peak + 0.5 * float((before - after) / (before - 2 * at + after))))
    if len(found) < FEWEST_RETURNS:
        return None
    count, lags = (np.array(column, float) for column in zip(*found, strict=True))
    period = float((count * lags).sum() / (count**2).sum())
    scatter = float(np.sqrt(((lags - count * period) ** 2).sum() / max(len(lags) - 1, 1)))
    sd = max(scatter, READ_OFF) / float(np.sqrt((count**2).sum()))
    rate = 2 * np.pi / (period * frame_s)
    return LagRate(rate, rate * sd / period, int(count.max()))


def _autocorrelation(values: NDArray[np.float32]) -> FloatArray:
    """Σ over pixels, normalised by the energy of the overlap, shape (f,)."""
    n = len(values)
    size = 1 << (2 * n - 1).bit_length()
    power = np.zeros(size // 2 + 1)
    for pixel in values.T:
        power += np.abs(np.fft.rfft(pixel, size)) ** 2
    lagged = np.fft.irfft(power, size)[:n]
    energy = np.concatenate([[0.0], np.cumsum((values.astype(float) ** 2).sum(axis=1))])
    lag = np.arange(n)
    overlap = np.sqrt(energy[n - lag] * (energy[n] - energy[lag]))
    return np.asarray(lagged / np.maximum(overlap, 1e-9))


def second_opinions(
    track: PhaseTrack,
    angle: PlateAngle,
    rate_rad_s: float,
    sd_rad_s: float,
    count: FrameCount | None,
    lags: LagRate | None,
) -> tuple[str, ...]:
    """A paragraph for each way that disagrees."""
    says = []
    rate = abs(rate_rad_s)
    if (text := _centroid(track, angle, rate_rad_s, sd_rad_s)) is not None:
        says.append(text)
    if count is not None:
        frames = abs(count.rate_rad_s - rate) / count.sd_rad_s * END_SD
        if frames > COUNT_APART:
            says.append(
                f"{track.source}: counting frames between alignments gives "
                f"{count.rate_rad_s / RPM:.4f} ± {count.sd_rad_s / RPM:.4f} rpm, the regression "
                f"{rate / RPM:.4f} rpm: more apart than one frame. Look at the annotated picture: "
                f"is the mark the mark?"
            )
    if lags is not None:
        apart = abs(lags.rate_rad_s - rate)
        if apart > APART * np.hypot(lags.sd_rad_s, sd_rad_s) and apart > LAG_MATTERS * rate:
            says.append(
                f"{track.source}: the picture returns after whole turns at "
                f"{lags.rate_rad_s / RPM:.4f} ± {lags.sd_rad_s / RPM:.4f} rpm, the regression "
                f"gives {rate / RPM:.4f} rpm. Something else in the picture may be turning, or "
                f"turns were miscounted."
            )
    return tuple(says)


def _centroid(
    track: PhaseTrack, angle: PlateAngle, rate_rad_s: float, sd_rad_s: float
) -> str | None:
    difference = np.angle(np.exp(1j * (track.seed_rad - track.phase_rad)))[angle.index]
    seen = np.isfinite(difference)
    if seen.sum() < 12:
        return None
    middle = float(np.angle(np.mean(np.exp(1j * difference[seen]))))
    difference = np.angle(np.exp(1j * (difference - middle)))
    off = float((np.abs(difference[seen]) > 0.5).mean())
    if off > SLIPPED:
        return (
            f"{track.source}: in {off:.0%} of the pictures the mark's centroid is elsewhere than "
            f"the angle from the whole plate says; the mark may be hidden at times, or is not "
            f"one. The rate is from the whole plate."
        )
    time, line = angle.repaired_time_s[seen], angle.angle_rad[seen]
    x = _waves(time - time.mean(), line)
    slope = least_squares(x, difference[seen])
    apart = abs(float(slope.beta[1]))
    if apart < APART * np.hypot(slope.sd[1], sd_rad_s) or apart < CENTROID_MATTERS * abs(
        rate_rad_s
    ):
        return None
    return (
        f"{track.source}: the mark's centroid turns {apart / abs(rate_rad_s) * 1e6:.0f} ppm "
        f"otherwise than the whole plate; the light may change during the clip."
    )


def _waves(time_s: FloatArray, angle_rad: FloatArray) -> FloatArray:
    parts = [np.ones_like(time_s), time_s]
    parts += [f(k * angle_rad) for k in (1, 2) for f in (np.cos, np.sin)]
    return np.stack(parts, axis=1)
