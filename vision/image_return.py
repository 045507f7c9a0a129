"""The period after which a film repeats: no plate, no mark, no view.

Small frames, without slow changes and flicker, are cut into blocks, and every block is correlated
with itself a lag later,

    r_b(l) = Σ_t V_b(t)·V_b(t + l) / √(Σ_t V_b(t)² Σ_t V_b(t + l)²).

A turning object returns after every multiple of its period and not half way between two, so the
period is the lag P with the largest mean of r_b(mP) - r_b((m - 1/2)P) in the blocks that return
best. The peaks near its multiples, located to a fraction of a frame, then give the period.

Without the slow changes, an even shift through the picture seems to return a few times. If returns
are few, the unfiltered frames must return too: at each return, at most half remains of their mean
square difference half way between two returns, less noise.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from vision.geometry import FloatArray
from vision.numbers import SD_PER_MAD, median

BLOCK = 8  #: pixels, each way
FINER_BLOCK = 3  # pixels: the label of a distant plate fills one, and is noise in a larger one
SLOW_S = 2.2  #: seconds: slower changes are light or a camera that drifts; numerical
MOST_BLOCKS = 40  # one block in so many is examined
STRONGEST = 72  #: blocks, those that vary most; a limit of time
NOISE_FROM = 100  # frames, for the noise of a pixel: known to a tenth
ENOUGH = 20.0  # times the noise: larger variation counts no more
FEWEST_BLOCKS = 6  # that are examined
ABOUT = 0.08  #: share of a period, on both sides of an expected return
READ_OFF = 0.2  # frames: the parabola through a narrow peak leans to the whole frame
FEWEST_RETURNS = 2  # a single one may be chance
SEVERAL_RETURNS = 4  # an even motion, without slow changes, shows fewer
LEAST_FRAMES = 3  # of a period
FIRST_TURNS = 3  # returns that refine the period for the later ones
MOSTLY = 0.8  # share of the clip in which a trial period is tested
MOST_FRAMES = 600  #: frames in which another period is searched; a limit of time
LATEST = 0.85  # share of the clip up to the latest return; beyond, too little overlaps
PARTS = (5, 4, 3, 2)  # parts of the found period after which the picture may return already
SAME_RETURN = 0.01  #: relative difference of periods; derived: five sds of one
BIAS = 2e-3  #: fact: of the period, by which the peak leans where the picture changes in the clip


# Conditions for a return of the picture.
CLEAR = 0.6
"""Mean correlation of the best blocks with themselves a period later. Tuned on the real clips of
tests.vision.test_real_clips and on ``tests.bench.clip_study``."""
BEYOND_NOISE = 1.3
"""Least mean square of an examined block over that of its noise. Derived: with less, a correlation
of ``CLEAR`` is impossible."""
SHORTER = 1.05
"""Factor by which a longer period must score better to be the period: every multiple of the period
returns too."""
GONE = 0.5
"""Largest share of the difference half way between two returns that remains at a return. Derived:
half."""
SAME = 0.75
"""Least share of the correlation after the period, and of the number of returns, that makes a part
of it the period. Tuned on ``tests.bench.clip_study``: a narrow mark returns best after the three
turns that take a whole number of frames."""


@dataclass(frozen=True, eq=False)
class ImageReturn:
    """A picture that repeats after some time.

    Attributes
    ----------
    period_s, sd_s : float
        Seconds.
    turns : int
        Number of periods to the latest clear return.
    """

    period_s: float
    sd_s: float
    turns: int

    @property
    def rate_rad_s(self) -> float:
        """Rate of a plate that looks the same once per turn, rad/s."""
        return 2 * np.pi / self.period_s


def image_return(
    small: NDArray[np.uint8], frame_s: float, blocks: Sequence[int] = (BLOCK, FINER_BLOCK)
) -> ImageReturn | None:
    """Find the time after which the picture repeats.

    Parameters
    ----------
    small : array of uint8, shape (f, h, w)
        Frames of a hundred pixels or so, evenly spaced.
    frame_s : float
        Time from one to the next, s.
    blocks : sequence of int
        Sizes of the blocks that are tried in turn, pixels each way.

    Returns
    -------
    ImageReturn or None
        None if nothing returns twice.
    """
    if len(small) < 2 * FEWEST_RETURNS * LEAST_FRAMES:
        return None
    varying = _varying(small)
    quick = _without_slow(varying, round(SLOW_S / frame_s) // 2)
    return next((returned for block in blocks if min(small.shape[1:]) >= block
                 and (returned := _return_in_blocks(varying, quick, frame_s, block))), None)


def _return_in_blocks(
    varying: NDArray[np.float32], quick: NDArray[np.float32], frame_s: float, block: int
) -> ImageReturn | None:
    f, rows, columns = len(quick), quick.shape[1] // block, quick.shape[2] // block
    blocks = _in_blocks(quick, block)
    seen = np.flatnonzero((blocks**2).mean(axis=(1, 2)) > BEYOND_NOISE)
    if not seen.size:
        return None
    strength = (blocks[seen] ** 2).mean(axis=(1, 2))
    strongest = np.sort(np.argsort(strength)[-STRONGEST:])
    seen, strength = seen[strongest], np.minimum(strength[strongest], ENOUGH)
    correlation = autocorrelation(blocks[seen])
    period, score = _period(correlation, max(FEWEST_BLOCKS, rows * columns // MOST_BLOCKS))
    best = np.argsort(score)[-max(FEWEST_BLOCKS, rows * columns // MOST_BLOCKS * 2) :]
    weight = strength[best] * np.maximum(score[best], 0.01)
    together = weight @ correlation[best] / weight.sum()
    lags, count, shown = returns_near(together, period)
    for parts in PARTS:  # the found period may be a multiple of a fractional one
        in_parts = returns_near(together, period / parts)
        often = SAME * int(LATEST * f * parts / period)
        if len(in_parts[0]) > often and (  # of no returns there is no mean
                in_parts[2].mean() * len(shown) > SAME * shown.sum()):
            lags, count, shown = in_parts
            break
    mean = float(shown.mean()) if shown.size else 0.0
    if len(lags) < FEWEST_RETURNS or mean < CLEAR:
        return None
    if len(lags) < SEVERAL_RETURNS and not _returns_whole(
            _in_blocks(varying, block)[seen], lags, float(lags[0] / count[0])):
        return None
    period, sd = fitted_period(lags, count)
    sd = float(np.hypot(sd, BIAS * period))
    return ImageReturn(period * frame_s, sd * frame_s, int(count.max()))


def _varying(small: NDArray[np.uint8]) -> NDArray[np.float32]:
    """Values without the common flicker of all pixels, in sds of each pixel's noise."""
    values = small.astype(np.float32)
    light = values.mean(axis=(1, 2), keepdims=True)
    values *= light.mean() / np.maximum(light, 1.0)
    values -= values.mean(axis=0)
    thin = max(1, len(values) // NOISE_FROM)
    second = values[2::thin] - 2 * values[1:-1:thin] + values[:-2:thin]
    noise = SD_PER_MAD * median(np.abs(second), axis=0) / np.sqrt(6)
    return np.asarray(values / np.maximum(noise, median(noise) + 0.3), np.float32)


def _in_blocks(values: NDArray[np.float32], block: int) -> NDArray[np.float32]:
    """Frames (f, h, w) as blocks of pixels, (b, f, block²)."""
    f, h, w = values.shape
    rows, columns = h // block, w // block
    blocks = values[:, : rows * block, : columns * block].reshape(f, rows, block, columns, block)
    return blocks.transpose(1, 3, 0, 2, 4).reshape(rows * columns, f, block * block)


def _returns_whole(blocks: NDArray[np.float32], lags: FloatArray, period: float) -> bool:
    """Whether blocks (b, f, p), in sds of noise, repeat after the lags, (m,)."""
    def difference(after: FloatArray) -> float:
        squares = [float(((blocks[:, lag:] - blocks[:, :-lag]) ** 2).mean())
                   for lag in np.round(after).astype(int)]
        return sum(squares) / len(squares) - 2
    return difference(lags) < GONE * difference(lags - period / 2)


def _without_slow(values: NDArray[np.float32], half: int) -> NDArray[np.float32]:
    """Each frame (f, h, w) less the mean of those up to ``half`` before and after it."""
    total, count = values[:half].sum(axis=0), min(half, len(values))
    quick = np.empty_like(values)
    for i, frame in enumerate(values):
        if i + half < len(values):
            total += values[i + half]
            count += 1
        if i > half:
            total -= values[i - half - 1]
            count -= 1
        quick[i] = frame - total / count
    return quick


def autocorrelation(blocks: NDArray[np.float32]) -> FloatArray:
    """Correlation of blocks (b, f, p) with themselves by lag, r of the module, (b, f)."""
    f = blocks.shape[1]
    blocks = blocks - blocks.mean(axis=1, keepdims=True)
    power = (np.abs(np.fft.rfft(blocks, 2 * f, axis=1)) ** 2).sum(axis=2)
    energy = np.cumsum((blocks.astype(float) ** 2).sum(axis=2), axis=1)
    lag = np.arange(f)
    earlier = np.pad(energy, ((0, 0), (1, 0)))
    overlap = earlier[:, f - lag] * (earlier[:, f:] - earlier[:, lag])
    lagged = np.fft.irfft(power, axis=1)[:, :f]
    return np.asarray(lagged / np.sqrt(np.maximum(overlap, 1e-9)))


def _period(correlation: FloatArray, best: int) -> tuple[float, FloatArray]:
    """The period in frames, and the gain of each block in correlation over half way, (b,)."""
    f = correlation.shape[1]
    trials = np.arange(LEAST_FRAMES, (f - 3) / 2.2, 0.5)
    count = (MOSTLY * f / trials).astype(np.intp)
    start = np.cumsum(count) - count
    turns = np.arange(count.sum()) - np.repeat(start, count) + 1
    at, between = (
        np.add.reduceat(correlation[:, np.round(after * np.repeat(trials, count)).astype(np.intp)],
                        start, axis=1) / count
        for after in (turns, turns - 0.5))
    score = at - np.maximum(between, 0)
    clear = np.sort(score, axis=0)[-best:].mean(axis=0)
    chosen = 0
    for i, shown in enumerate(clear):
        if shown > SHORTER * clear[chosen] or clear[chosen] < 0:
            chosen = i
    return float(trials[chosen]), score[:, chosen]


def returns_near(
    correlation: FloatArray, period: float
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """The peaks of a correlation near the multiples of a period.

    Parameters
    ----------
    correlation : array, shape (f,)
        By lag in frames.
    period : float
        In frames.

    Returns
    -------
    lags, turns, correlation : array, shape (m,)
        Lag of each peak in frames, the number of turns after which it is, and its height.
    """
    peaks = []
    for turns in range(1, int(LATEST * len(correlation) / period) + 1):
        reach = max(2, int(ABOUT * period))
        middle = round(turns * period)
        low, high = max(1, middle - reach), min(len(correlation) - 2, middle + reach)
        if high <= low + 1:
            continue
        peak = low + int(correlation[low : high + 1].argmax())
        if peak in (low, high):
            continue
        before, at, after = correlation[peak - 1 : peak + 2]
        lag = peak + 0.5 * float((before - after) / (before - 2 * at + after))
        peaks.append((lag, float(turns), float(at)))
        if turns <= FIRST_TURNS:
            period = lag / turns
    lags, count, shown = np.array(peaks, float).reshape(-1, 3).T
    return lags, count, shown


def fitted_period(lags: FloatArray, turns: FloatArray) -> tuple[float, float]:
    """The period and its sd, frames, from the lags (m,) after given turns (m,), two at least."""
    period = float((turns * lags).sum() / (turns**2).sum())
    scatter = float(np.sqrt(((lags - turns * period) ** 2).sum() / (len(lags) - 1)))
    return period, max(scatter, READ_OFF) / float(np.sqrt((turns**2).sum()))
