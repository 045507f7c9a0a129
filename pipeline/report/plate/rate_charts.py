"""The vision stage in the report: for every plate setting the rate, a frame, and its charts."""

import base64
import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from calib.consistency.clock_ratio import ClockRatio
from calib.numbers import NO_LENGTH, RPM
from calib.poses.imu_log import FloatArray
from pipeline.console.rate_text import RateVerdict, rate_verdict, two_sigma, worst_clip
from pipeline.drawings.charts import Chart, Figure, across, nice_limit, upward
from pipeline.report.plate.rate_terms import ANGLE_BINS, angle_means, rate_terms_json, shown_frames
from pipeline.report.plate.speed_charts import polar_figure, spectrogram_figure
from pipeline.report.triad.partial_residuals import PPM
from pipeline.results.json_values import Json
from pipeline.stages.rate import SettingRate
from pipeline.text.formatting import count, relative, with_minus_signs, with_sd
from vision.errors import RateRefused
from vision.phase_track import LUMA
from vision.rate.aes6_flutter import course_of_clip, platter_flutter
from vision.rate.terms import TERMS

if TYPE_CHECKING:
    from vision.rate.measure import RateMeasurement



@dataclass(frozen=True)
class RateView:
    """View of one plate setting; ``facts`` are names and values."""

    name: str
    headline: str
    facts: tuple[tuple[str, str], ...]
    verdict: RateVerdict
    frame: str = ""
    frame_caption: str = ""
    figures: tuple[Figure, ...] = ()
    terms: Json | None = None


def rate_view(rate: SettingRate, clock: ClockRatio | None = None) -> RateView:
    """Contents of the page on one plate setting."""
    sd = relative(rate.sd_rad_s / rate.rate_rad_s)
    headline = f"{rate.rate_rad_s / RPM:.4f} rpm ± {sd}"
    verdict = rate_verdict(rate)
    if not rate.clips:
        return RateView(rate.name, headline, tuple(_facts(rate, clock)), verdict)
    # One clip per pose: the page shows the clip with the largest residual.
    worst = worst_clip(rate)
    frame = base64.b64encode(rate.annotated[worst].tobytes()).decode() if rate.annotated else ""
    of = (f" of {rate.sources[worst]}, which has the largest residual of {len(rate.clips)} clips"
          if len(rate.clips) > 1 else "")
    return RateView(
        name=rate.name,
        headline=f"{headline}, {rate.plate.direction} as filmed",
        facts=tuple(_facts(rate, clock)),
        verdict=verdict,
        frame=f"data:image/png;base64,{frame}" if frame else "",
        frame_caption=(
            f"One frame{of}. The overlay shows the rim of the plate, the spindle (cross) and a "
            f"hand at the measured angle, through the mark (circle) where there is one."
        ),
        figures=tuple(_figures(rate, worst)),
        terms=rate_terms_json(rate, worst),
    )


def _facts(rate: SettingRate, clock: ClockRatio | None) -> Iterator[tuple[str, str]]:
    """Names and values; the rate by the clock of the sensor's log where gravity shows it."""
    whole = rate.rate_rad_s
    yield "rate", f"{with_sd(whole, rate.sd_rad_s)} rad/s"
    if clock is not None:
        yield "difference by gravity in the sensor's log", with_minus_signs(
            f"{with_sd(clock.difference * PPM, clock.sd * PPM)} ppm")
    if not rate.clips:
        return
    yield "uncertainty from the frames", relative(rate.image_sd_rad_s / whole)
    yield "uncertainty from the clock", relative(rate.timebase_sd_rad_s / whole)
    base = rate.timebase
    if base is not None and base.camera:
        yield "clock of the camera", f"{base.camera}, {base.fast_ppm:+.1f} ± {base.ppm:.1f} ppm"
    yield "turns", f"{sum(clip.revolutions for clip in rate.clips):.1f}"
    yield "frames", str(sum(clip.frames.used for clip in rate.clips))
    counted = [
        (count.rate_rad_s / clip.rate_rad_s, count.sd_rad_s / clip.rate_rad_s)
        for clip in rate.clips
        if (count := clip.cross_checks.frame_count)
    ]
    if counted:
        difference = float(np.mean([ratio for ratio, _ in counted])) - 1
        sd = float(np.mean([sd for _, sd in counted]))
        yield "difference by counting frames", with_minus_signs(
            f"{difference * PPM:+.0f} ppm ± {relative(sd)}")
    lagged = [
        lag.rate_rad_s / clip.rate_rad_s for clip in rate.clips if (lag := clip.cross_checks.lag)
    ]
    if lagged:
        difference = float(np.mean(lagged)) - 1
        yield "difference by correlating frames", with_minus_signs(f"{difference * PPM:+.0f} ppm")
    dropped = sum(clip.frames.dropped for clip in rate.clips)
    if dropped:
        yield "dropped frames without a gap in the time stamps", str(dropped)
    coloured = sorted({clip.channel for clip in rate.clips} - {LUMA})
    if coloured:
        yield "tracked by colour", ", ".join(coloured)
    worst = worst_clip(rate)
    yield from term_sizes(rate.clips[worst])
    yield from _speed_facts(rate.clips[worst], rate.sources[worst])
    rms = math.sqrt(float(np.mean([clip.fit.rms_rad**2 for clip in rate.clips])))
    yield "phase residual (RMS)", f"{math.degrees(rms):.3g}°"


def _speed_facts(clip: "RateMeasurement", source: str) -> Iterator[tuple[str, str]]:
    """Wow, flutter and drift of the plate; nothing for a clip too short or too slow for them."""
    try:
        figures = platter_flutter(course_of_clip(clip), source)
    except RateRefused:
        return
    yield "wow and flutter, AES6-weighted", two_sigma(figures.weighted, figures.weighted_noise)
    yield "wow and flutter, unweighted", two_sigma(figures.unweighted, figures.unweighted_noise)
    yield "drift of the rate", with_minus_signs(
        f"{60 * PPM * figures.drift_per_s:+.0f} ppm per minute")


def _figures(rate: SettingRate, worst: int) -> Iterator[Figure]:
    clip = rate.clips[worst]
    fit = clip.fit
    residual = np.degrees(fit.residual_rad)
    shown, limit = shown_frames(fit)
    rms = f"RMS residual {math.degrees(fit.rms_rad):.3g}°"
    thin = f"; the chart shows {len(shown)} of {int(fit.used.sum())} frames." if len(shown) < len(
        fit.time_s) else "."
    yield _phase_figure(
        fit.time_s[shown], residual[shown], limit, "Angle residual against time",
        "time in the clip [s]", f"{rms}{thin}",
        "a horizontal band without bend, step or wave: the rate of the plate was constant.",
    )
    angle = np.degrees(fit.angle_rad)
    yield _phase_figure(
        angle[shown], residual[shown], limit, "Angle residual against plate angle",
        "plate angle [°]", f"The line shows means over {360 // ANGLE_BINS}° of angle.",
        "a horizontal line without a wave. A wave that repeats with every revolution shows an "
        "off-centre mark or a tilted view; over whole revolutions it does not change the rate.",
        angle_means(angle[fit.used], residual[fit.used]),
    )
    course = course_of_clip(clip)
    for figure in (polar_figure(course), spectrogram_figure(course)):
        if figure is not None:
            yield figure
    history = clip.history
    if len(history.time_s) > 2:
        mean = float(np.abs(history.rate_rad_s).mean())
        yield _deviation_figure(
            history.time_s, (np.abs(history.rate_rad_s) / mean - 1) * PPM, None,
            "Rate against time", "time in the clip [s]",
            "Each dot is the mean rate over one revolution, half of one after the dot before.",
            "no slope and no jump: the plate does not slow down or slip.",
        )
    if len(rate.clips) > 1:
        one = rate.plate.rate_rad_s
        yield _deviation_figure(
            np.arange(1.0, len(one) + 1), (one / one.mean() - 1) * PPM,
            rate.plate.sd_rad_s / one.mean() * PPM, "Rate of every clip", "clip",
            "The bars show ± one sd from the frames.",
            "no drift from clip to clip. Each pose uses the rate of its own clip.",
        )


def _phase_figure(
    xs: FloatArray, ys: FloatArray, limit: float, title: str, x_title: str, caption: str, good: str,
    means: tuple[FloatArray, FloatArray] | None = None,
) -> Figure:
    chart = Chart(across(xs), upward(-limit, limit), x_title, "angle residual [°]")
    chart.axes()
    chart.level(0.0)
    chart.dots(xs, ys, "phase")
    if means is not None:
        chart.line(*means, "mean")
    attribute = f' data-top="{chart.y.end:g}" data-bottom="{chart.y.start:g}"'
    return Figure(title, chart.svg(f"{title}. {caption}", attribute, "phases"), good, caption)


def _deviation_figure(
    xs: FloatArray, ppm: FloatArray, sd: FloatArray | None, title: str, x_title: str,
    caption: str, good: str,
) -> Figure:
    reach = np.abs(ppm) if sd is None else np.abs(ppm) + sd
    limit = nice_limit(max(float(reach.max()), 1e-3))
    chart = Chart(across(xs), upward(-limit, limit), x_title, "difference from the mean [ppm]")
    chart.axes()
    chart.level(0.0)
    if sd is not None:
        for x, y, half in zip(xs, ppm, sd, strict=True):
            chart.bar(x, y - half, y + half, "band")
    for x, y in zip(xs, ppm, strict=True):
        chart.mark(x, y, 0, "mark run0")
    caption += f" The sd of the {count(len(ppm), 'value')} is {float(np.std(ppm)):.3g} ppm."
    return Figure(title, chart.svg(f"{title}. {caption}"), good, caption)


def term_sizes(clip: "RateMeasurement") -> Iterator[tuple[str, str]]:
    """Name and size ± sd of every term that is in the model or that the verdict names."""
    diagnosis = clip.diagnosis
    named = (diagnosis.name,) if diagnosis.verdict == "effect" else diagnosis.group
    sizes = {c.name: (c.size, c.sd) for c in diagnosis.ranking if c.name in named}
    sizes |= {term.name: (term.value, term.sd) for term in clip.fit.terms}
    for name in TERMS:
        if name in sizes:
            words = " ".join(_worded(name, *sizes[name], clip.rate_rad_s))
            yield f"size of {name}", with_minus_signs(words)


def _worded(name: str, value: FloatArray, sd: FloatArray, rate: float) -> Iterator[str]:
    if name in ("once_per_rev", "twice_per_rev"):
        amplitude = math.hypot(*value)
        spread = math.sqrt(float(((value * sd) ** 2).sum())) / max(amplitude, NO_LENGTH)
        yield f"amplitude {with_sd(math.degrees(amplitude), math.degrees(spread))}°"
    elif name == "rate_drift":
        per_minute = 60e6 / rate
        yield f"{with_sd(float(value[0]) * per_minute, float(sd[0]) * per_minute)} ppm of the rate"
        yield "per minute"
    elif name == "frame_steps":
        yield f"{with_sd(float(value[0]), float(sd[0]))} times the frames counted as dropped"
    else:
        yield f"{with_sd(float(value[0]) * 1e6, float(sd[0]) * 1e6)} µs per row"
