"""The third opinion: after how many frames does the picture look the same again?

No plate, no centre, no mark: the surroundings of the plate at a few hundred pixels are correlated
with themselves over time. The highest peak near each multiple of a turn gives that many turns.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from vision.geometry import FloatArray
from vision.phase_track import PhaseTrack
from vision.rate.unwrap import frame_time

CLEAR_PEAK = 0.25  # correlation a return must reach
AROUND = 0.06  # of a turn, to both sides of where the return is expected
FEWEST_RETURNS = 2  # one alone may be chance
LONGEST = 4000  # pictures looked at
READ_OFF = 0.2  # frames: the parabola through a narrow peak leans to the whole frame


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
