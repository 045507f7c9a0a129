"""Wow, flutter and drift of the plate, as shares of its rate.

A wave A cos(kθ) of the angle is a wave kA of the relative rate. What is seen once and twice per
turn may also come from the view, so those two figures are upper limits.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from vision.rate.least_squares import LeastSquares, least_squares
from vision.rate.terms import Regressors, columns


@dataclass(frozen=True)
class FlutterThresholds:
    """What counts as flutter.

    Attributes
    ----------
    first_order : float
        Waves per turn. Derived: between the second order, which is wow, and the third.
    clear_line : float
        Times the mean power of the spectrum. Derived: white noise exceeds it once in 10⁶ spectra of
        500 lines.
    fastest : float
        Of the frame rate. Derived: the last bins hold waves that the frames sample less than 2.2
        times.
    """

    first_order: float = 2.5
    clear_line: float = 20.0
    fastest: float = 0.45


THRESHOLDS = FlutterThresholds()


@dataclass(frozen=True)
class SpeedFigures:
    """Relative to the rate, amplitudes of a wave.

    Attributes
    ----------
    once_per_rev, twice_per_rev : float
        Wow at one and two waves per turn (upper limits, see above); NaN where there are too few
        frames per turn to separate them.
    flutter : float
        Strongest faster wave; 0 where none stands out.
    flutter_hz : float
        Its frequency, NaN without.
    drift_per_s, drift_sd : float
        Relative change of the rate per second.
    """

    once_per_rev: float
    twice_per_rev: float
    flutter: float
    flutter_hz: float
    drift_per_s: float
    drift_sd: float


def speed_figures(
    fit: LeastSquares, base: Regressors, waves: Sequence[str], frame_s: float
) -> SpeedFigures:
    """Take the figures from the rate's fit: constant, rate, cosine and sine of each wave, …"""
    wave = []
    for name in ("once_per_rev", "twice_per_rev"):
        at = 2 + 2 * waves.index(name) if name in waves else None
        wave.append(np.nan if at is None else float(np.hypot(*fit.beta[at : at + 2])))
    drift = least_squares(
        np.concatenate(
            [np.ones((len(base.time_s), 1)), base.time_s[:, None], columns("rate_drift", base)],
            axis=1,
        ),
        fit.residual,
    )
    flutter, hz = _flutter(fit, base, frame_s)
    rate = abs(base.rate_rad_s)
    return SpeedFigures(
        once_per_rev=wave[0],
        twice_per_rev=2 * wave[1],
        flutter=flutter,
        flutter_hz=hz,
        drift_per_s=float(drift.beta[2]) * float(np.sign(base.rate_rad_s)) / rate,
        drift_sd=float(drift.sd[2]) / rate,
    )


def _flutter(fit: LeastSquares, base: Regressors, frame_s: float) -> tuple[float, float]:
    """Strongest wave faster than twice per turn: relative rate amplitude and frequency."""
    time = base.time_s - base.time_s[0]
    even = np.arange(0, time[-1], frame_s)
    residual = np.interp(even, time[fit.used], fit.residual[fit.used])
    taper = np.hanning(len(even))
    amplitude = 2 * np.abs(np.fft.rfft(residual * taper)) / taper.sum()
    hz = np.fft.rfftfreq(len(even), frame_s)
    slowest = THRESHOLDS.first_order * abs(base.rate_rad_s) / (2 * np.pi)
    band = (hz > slowest) & (hz < THRESHOLDS.fastest / frame_s)
    if band.sum() < 8:
        return 0.0, float("nan")
    power = amplitude[band] ** 2
    peak = int(power.argmax())
    if power[peak] < THRESHOLDS.clear_line * np.median(power) / np.log(2):
        return 0.0, float("nan")
    at = float(hz[band][peak])
    return float(amplitude[band][peak]) * 2 * np.pi * at / abs(base.rate_rad_s), at
