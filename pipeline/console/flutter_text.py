"""Wow and flutter as text and as JSON."""

import math
from collections.abc import Iterator

import numpy as np

from calib.numbers import RPM
from pipeline.results.json_values import Json, number, numbers
from pipeline.stages.flutter import MeasuredFlutter

STRONGEST = 3  #: waves that are listed
APART = 3  #: bins of the spectrum between two waves listed separately: of the taper's width
PPM = 1e6  #: definition
SHOWN = 1.4
"""Ratio of a figure to its noise from which it is significant. Derived: as much again as the noise,
added in squares."""


def flutter_lines(flutter: MeasuredFlutter) -> Iterator[str]:
    """The figures, their noise, and the strongest waves."""
    figures = flutter.figures
    by = "gyroscope" if flutter.by_gyroscope else "clip"
    band = f"{figures.lowest_hz:.2g} to {figures.highest_hz:.3g} Hz"
    yield f"flutter {flutter.source} ({by}, {flutter.course.seconds:.0f} s, {band})"
    for name, value, noise in (
        ("platter, AES6-weighted", figures.weighted, figures.weighted_noise),
        ("platter, unweighted", figures.unweighted, figures.unweighted_noise),
    ):
        yield f"  {name:<24} {two_sigma(value, noise)}"
    yield f"  {'drift':<24} {60 * PPM * figures.drift_per_s:+.0f} ppm per minute"
    turns_hz = flutter.course.rate_rad_s / (2 * math.pi)
    for at, amplitude in strongest_waves(flutter):
        yield (f"  {'wave':<24} {percent(amplitude)} at {at:.3g} Hz, "
               f"{at / turns_hz:.2f} per revolution")
    if math.isfinite(flutter.scale_error):
        yield (f"  the mean of the gyroscope is {100 * flutter.scale_error:+.2f} % off the clip's "
               f"rate; the figures err by as much of themselves")
    if not flutter.by_gyroscope:
        yield ("  what repeats with every revolution may also come from the view; a gyroscope on "
               "the platter (--gyro LOG) does not see that, and sees up to 200 Hz")


def two_sigma(value: float, noise: float) -> str:
    """A two-sigma figure and that of the noise alone."""
    if not noise:
        return f"± {percent(value)} (two sigma)"
    if value < SHOWN * noise:
        return f"at most ± {percent(value)} (two sigma): no more than the noise, ± {percent(noise)}"
    return f"± {percent(value)} (two sigma); the noise alone gives ± {percent(noise)}"


def strongest_waves(flutter: MeasuredFlutter) -> Iterator[tuple[float, float]]:
    """Frequencies in Hz and relative amplitudes of the strongest lines of the spectrum."""
    hz, amplitude = flutter.figures.hz, flutter.figures.amplitude.copy()
    for _ in range(STRONGEST):
        at = int(np.argmax(amplitude))
        if amplitude[at] <= 0:
            return
        yield float(hz[at]), float(amplitude[at])
        amplitude[max(at - APART, 0) : at + APART + 1] = 0.0


def percent(share: float) -> str:
    """A relative figure in per cent, to two or three digits.

    >>> percent(0.00123), percent(0.00004)
    ('0.123 %', '0.004 %')
    """
    return f"{100 * share:.3f} %" if share < 0.01 else f"{100 * share:.3g} %"


def flutter_json(flutter: MeasuredFlutter) -> Json:
    """The figures and the spectrum."""
    figures = flutter.figures
    return {
        "source": flutter.source,
        "by": "gyroscope" if flutter.by_gyroscope else "clip",
        "rate_rpm": flutter.course.rate_rad_s / RPM,
        "seconds": flutter.course.seconds,
        "platter_aes6_weighted": figures.weighted,
        "platter_unweighted": figures.unweighted,
        "noise_weighted": figures.weighted_noise,
        "noise_unweighted": figures.unweighted_noise,
        "lowest_hz": figures.lowest_hz,
        "highest_hz": figures.highest_hz,
        "drift_per_s": figures.drift_per_s,
        "scale_error": number(flutter.scale_error),
        "spectrum": {"hz": numbers(figures.hz), "amplitude": numbers(figures.amplitude)},
    }
