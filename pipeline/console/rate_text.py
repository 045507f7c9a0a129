"""A measured rate as text: a line for the setting, lines for each clip, the verdict, flutter."""

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from calib.numbers import RPM
from calib.rounding import with_sd
from pipeline.results.json_values import Json, number, numbers
from pipeline.stages.flutter import MeasuredFlutter
from pipeline.stages.rate import SettingRate
from pipeline.text.formatting import NAME_WIDTH, count, relative
from vision.phase_track import LUMA
from vision.rate.aes6_flutter import PlatterFlutter
from vision.rate.terms import ALWAYS

if TYPE_CHECKING:
    from vision.phase_track import RateHistory


MOST_ROWS = 20  #: lines of rate against time, less than a screen of 24
COMPLETE = "nothing_missing"  #: verdict on a clip whose rate model describes it


def rate_line(rate: SettingRate) -> str:
    """``rate slow       16.667 rpm ± 12 ppm, 16.6 turns, ccw``."""
    parts = [f"{rate.rate_rad_s / RPM:.4f} rpm ± {relative(rate.sd_rad_s / rate.rate_rad_s)}"]
    if rate.clips:
        parts.append(f"{sum(clip.revolutions for clip in rate.clips):.1f} turns")
        parts.append(str(rate.plate.direction))
        if len(rate.clips) > 1:
            parts.append(count(len(rate.clips), "clip"))
    else:
        parts += [*filter(None, (rate.plate.direction,)), "stated in the configuration"]
    return f"{f'rate {rate.name}':<{NAME_WIDTH}} {', '.join(parts)}"


@dataclass(frozen=True)
class RateVerdict:
    """Terms that the rate model of one plate setting lacks, in its clip with the largest residual.

    ``lacks`` are the missing terms, none where the clip determines none; ``one_of`` those among
    which it does not decide; ``targets`` are what to add, as `pipeline add` names it.
    ``in_the_rate`` is whether the rate is fitted with the term in any model; ``together`` is the
    reason why all clips of the session decide it, reported once.
    """

    setting: str
    complete: bool
    text: str
    lacks: tuple[str, ...] = ()
    targets: tuple[str, ...] = ()
    rms_deg: float = 0.0
    in_the_rate: bool = True
    together: str = ""
    one_of: tuple[str, ...] = ()


def rate_verdict(rate: SettingRate) -> RateVerdict:
    """The verdict on one plate setting, with all terms that its residual needs."""
    if not rate.clips:
        return RateVerdict(rate.name, True,
                           "The configuration states this rate; it was not measured from a clip.")
    clip = rate.clips[worst_clip(rate)]
    diagnosis = clip.diagnosis
    named = (diagnosis.name, *diagnosis.further) if diagnosis.name is not None else ()
    lacks = named if diagnosis.verdict == "effect" else ()
    in_the_rate = all(name in ALWAYS for name in named)
    # Among terms that the clip cannot separate, one that changes no rate may be added.
    addable = lacks or (named if diagnosis.verdict == "ambiguous" and in_the_rate else ())
    return RateVerdict(
        rate.name, diagnosis.verdict == COMPLETE,
        " ".join(filter(None, (diagnosis.explanation, diagnosis.record_next))), lacks,
        tuple(f"rate.{rate.name}.{term}" for term in addable),
        math.degrees(clip.fit.rms_rad), in_the_rate, diagnosis.together,
        diagnosis.group if diagnosis.verdict == "ambiguous" else ())


def worst_clip(rate: SettingRate) -> int:
    """Number of the clip with the largest residual."""
    return max(range(len(rate.clips)), key=lambda i: rate.clips[i].fit.rms_rad)


def verdict_lines(rates: Iterable[SettingRate]) -> Iterator[str]:
    """Terms that the rate models lack, and why all clips decide so; nothing without any."""
    lacking = [verdict for rate in rates
               if not (verdict := rate_verdict(rate)).complete]
    for verdict in lacking:
        yield f"rate.{verdict.setting}: {verdict.text}"
    yield from reasons_of(lacking)


def reasons_of(verdicts: Iterable[RateVerdict]) -> tuple[str, ...]:
    """Reasons of decisions that all clips of the session make, each once."""
    return tuple(dict.fromkeys(verdict.together for verdict in verdicts if verdict.together))


def clip_lines(rate: SettingRate) -> Iterator[str]:
    """For each clip: the rate by counting frames, its difference, and the diagnosis."""
    for clip in rate.clips:
        if clip.channel != LUMA:
            yield f"  tracked by colour, {clip.channel}: the brightness shows no rotation"
        counted = clip.cross_checks.frame_count
        if counted is not None:
            difference = counted.rate_rad_s / clip.rate_rad_s - 1
            yield (
                f"  by counting frames {counted.rate_rad_s / RPM:.4f} rpm "
                f"± {relative(counted.sd_rad_s / counted.rate_rad_s)}, "
                f"difference {difference * 1e6:+.0f} ppm"
            )
        if len(clip.aliases.rates_rad_s) > 1:
            others = ", ".join(
                f"{abs(other) / RPM:.4g} {'ccw' if other > 0 else 'cw'}"
                for other in clip.aliases.rates_rad_s[1:]
            )
            yield f"  these rates give the same frames: {others} rpm; {clip.aliases.reason}"
        yield f"  {clip.diagnosis.explanation}"


def rate_history_lines(name: str, history: "RateHistory") -> Iterator[str]:
    """Rate against time of a plate whose rate is not constant, at most ``MOST_ROWS`` rows."""
    head = f"{f'rate {name}':<{NAME_WIDTH}}"
    yield f"{head} not constant; time [s], mean rate over one revolution [rpm]:"
    count = len(history.time_s)
    for i in np.linspace(0, count - 1, min(count, MOST_ROWS)).round().astype(int):
        yield f"  {history.time_s[i]:8.2f}  {history.rate_rad_s[i] / RPM:+9.3f}"


STRONGEST = 3  #: waves that are listed
APART = 3  #: bins of the spectrum between two waves listed separately: of the taper's width
PPM = 1e6  #: definition
SHOWN = 1.4
"""Ratio of a figure to its noise up to which it is mostly noise. Derived: as much again as the
noise, added in squares."""
CHANCE = 0.01
"""Probability that a spectrum of noise alone has a wave that is listed. A choice."""


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
    waves = [*strongest_waves(flutter.figures)]
    for at, amplitude, sd in waves:
        yield (f"  {'wave':<24} {with_sd(100 * amplitude, 100 * sd or None)} % at {at:.3g} Hz, "
               f"{at / turns_hz:.2f} per revolution")
    if not waves:
        yield "  no wave stands out of the noise"
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
        return f"at most ± {percent(value)} (two sigma): mostly noise, which is ± {percent(noise)}"
    return f"± {percent(value)} (two sigma); the noise alone gives ± {percent(noise)}"


def strongest_waves(figures: PlatterFlutter) -> Iterator[tuple[float, float, float]]:
    """Frequency in Hz, relative amplitude and its sd of the strongest waves that are not noise.

    The square of an amplitude of Gaussian noise is distributed exponentially.
    """
    noise = figures.noise_amplitude
    limit = noise * math.sqrt(math.log(len(noise) / CHANCE))
    amplitude = np.where(figures.amplitude > limit, figures.amplitude, 0.0)
    for _ in range(STRONGEST):
        at = int(np.argmax(amplitude))
        if amplitude[at] <= 0:
            return
        yield float(figures.hz[at]), float(amplitude[at]), float(noise[at]) / math.sqrt(2)
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
        "spectrum": {"hz": numbers(figures.hz), "amplitude": numbers(figures.amplitude),
                     "noise_amplitude": numbers(figures.noise_amplitude)},
    }
