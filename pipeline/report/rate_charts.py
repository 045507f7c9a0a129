"""The vision stage in the report: of every plate setting the rate, a picture, and its charts."""

import base64
import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from calib.poses.imu_log import FloatArray
from pipeline.formatting import RPM, count, relative
from pipeline.report.svg import Chart, Figure, across, nice_limit, thinned, upward
from pipeline.stages.rate import SettingRate
from vision.phase_track import LUMA

MOST_DOTS = 500  #: of a chart of the phase; a minute of a clip has twice to four times as many
ANGLE_BINS = 36
SHOWN_SHARE = 99.5  #: per cent of the residuals that a chart of the phase reaches to
PPM = 1e6


@dataclass(frozen=True)
class RateView:
    """One plate setting as the page shows it; ``facts`` are names and values."""

    name: str
    headline: str
    facts: tuple[tuple[str, str], ...]
    says: str
    next: str
    picture: str
    picture_says: str
    figures: tuple[Figure, ...]


def rate_view(rate: SettingRate) -> RateView:
    """Everything the page shows of one plate setting."""
    sd = relative(rate.sd_rad_s / rate.rate_rad_s)
    headline = f"{rate.rate_rad_s / RPM:.4f} rpm ± {sd}"
    if not rate.clips:
        return RateView(
            rate.name, headline, tuple(_facts(rate)), "Stated in the configuration, not filmed.",
            "", "", "", (),
        )
    # One clip per pose: the clip that its model fits worst is the one to look at.
    worst = max(range(len(rate.clips)), key=lambda i: rate.clips[i].fit.rms_rad)
    clip, source = rate.clips[worst], rate.sources[worst]
    frame = base64.b64encode(rate.annotated[worst].tobytes()).decode() if rate.annotated else ""
    of = f" of {source}, the least steady of {len(rate.clips)} clips" if len(rate.clips) > 1 else ""
    return RateView(
        name=rate.name,
        headline=f"{headline}, {rate.plate.direction} as filmed",
        facts=tuple(_facts(rate)),
        says=clip.diagnosis.explanation,
        next=clip.diagnosis.record_next or "",
        picture=f"data:image/png;base64,{frame}" if frame else "",
        picture_says=(
            f"One frame{of} with what was found: the rim of the plate, the ring in which its "
            f"angle is measured, the spindle as a cross, and the marks as circles."
        ),
        figures=tuple(_figures(rate, worst)),
    )


def _facts(rate: SettingRate) -> Iterator[tuple[str, str]]:
    whole = rate.rate_rad_s
    yield "rate", f"{whole:.7f} ± {rate.sd_rad_s:.2g} rad/s"
    if not rate.clips:
        return
    yield "uncertainty by the frames", relative(rate.image_sd_rad_s / whole)
    yield "uncertainty by the clock", relative(rate.timebase_sd_rad_s / whole)
    yield "turns", f"{sum(clip.revolutions for clip in rate.clips):.1f}"
    yield "frames", str(sum(clip.frames.used for clip in rate.clips))
    counted = [
        (count.rate_rad_s / clip.rate_rad_s, count.sd_rad_s / clip.rate_rad_s)
        for clip in rate.clips
        if (count := clip.cross_checks.frame_count)
    ]
    if counted:
        away = float(np.mean([ratio for ratio, _ in counted])) - 1
        sd = float(np.mean([sd for _, sd in counted]))
        yield "by counting frames", f"{away * PPM:+.0f} ppm away, ± {relative(sd)} by itself"
    lagged = [
        lag.rate_rad_s / clip.rate_rad_s for clip in rate.clips if (lag := clip.cross_checks.lag)
    ]
    if lagged:
        away = float(np.mean(lagged)) - 1
        yield "by comparing whole frames", f"{away * PPM:+.0f} ppm away"
    dropped = sum(clip.frames.dropped for clip in rate.clips)
    if dropped:
        yield "frames dropped without a gap in the stamps", str(dropped)
    coloured = sorted({clip.channel for clip in rate.clips} - {LUMA})
    if coloured:
        yield "followed by colour", ", ".join(coloured)
    rms = math.sqrt(float(np.mean([clip.fit.rms_rad**2 for clip in rate.clips])))
    yield "phase residual", f"{math.degrees(rms):.3g}°"


def _figures(rate: SettingRate, worst: int) -> Iterator[Figure]:
    clip = rate.clips[worst]
    fit = clip.fit
    kept = np.flatnonzero(fit.used)[thinned(int(fit.used.sum()), MOST_DOTS)]
    residual = np.degrees(fit.residual_rad)
    limit = nice_limit(max(float(np.percentile(np.abs(residual[fit.used]), SHOWN_SHARE)), 1e-6))
    shown = kept[np.abs(residual[kept]) <= limit]
    rms = f"Root mean square {math.degrees(fit.rms_rad):.3g}°"
    thin = f", {len(shown)} of {int(fit.used.sum())} frames drawn." if len(shown) < len(
        fit.time_s) else "."
    yield _phase_figure(
        fit.time_s[shown], residual[shown], limit, "Angle residual against time",
        "time in the clip [s]", f"{rms}{thin}",
        "a level band without bend, step or wave: the plate turned at one rate.",
    )
    angle = np.degrees(fit.angle_rad)
    means = _means_over_angle(angle[fit.used], residual[fit.used])
    yield _phase_figure(
        angle[shown], residual[shown], limit, "Angle residual against plate angle",
        "plate angle [°]", f"The line is the mean over {360 // ANGLE_BINS}° of angle.",
        "a level line: no wobble that repeats with every turn. Waves show an off-centre mark or a "
        "tilted camera; over whole turns they do not harm the rate.",
        means,
    )
    history = clip.history
    if len(history.time_s) > 2:
        mean = float(np.abs(history.rate_rad_s).mean())
        yield _deviation_figure(
            history.time_s, (np.abs(history.rate_rad_s) / mean - 1) * PPM, None,
            "Rate against time", "time in the clip [s]",
            "Each dot is the mean rate over one turn.",
            "no slope and no jump: the plate neither slows down nor slips.",
        )
    if len(rate.clips) > 1:
        each = rate.plate.rate_rad_s
        yield _deviation_figure(
            np.arange(1.0, len(each) + 1), (each / each.mean() - 1) * PPM,
            rate.plate.sd_rad_s / each.mean() * PPM, "Rate of every clip", "clip",
            "Bars are ± one sd by the frames.",
            "no drift from clip to clip; each pose is measured against its own clip.",
        )


def _phase_figure(
    xs: FloatArray, ys: FloatArray, limit: float, title: str, x_title: str, says: str, good: str,
    means: tuple[FloatArray, FloatArray] | None = None,
) -> Figure:
    chart = Chart(across(xs), upward(-limit, limit), x_title, "angle residual [°]")
    chart.axes()
    chart.level(0.0)
    chart.dots(xs, ys, "phase")
    if means is not None:
        chart.line(*means, "mean")
    return Figure(title, chart.svg(f"{title}. {says}"), good, says)


def _means_over_angle(angle: FloatArray, residual: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Middle and mean of every bin of the plate angle that holds a frame."""
    edges = np.linspace(-180.0, 180.0, ANGLE_BINS + 1)
    place = np.clip(np.digitize(angle, edges) - 1, 0, ANGLE_BINS - 1)
    frames = np.bincount(place, minlength=ANGLE_BINS)
    sums = np.bincount(place, residual, ANGLE_BINS)
    held = frames > 0
    return ((edges[:-1] + edges[1:]) / 2)[held], sums[held] / frames[held]


def _deviation_figure(
    xs: FloatArray, ppm: FloatArray, sd: FloatArray | None, title: str, x_title: str,
    says: str, good: str,
) -> Figure:
    reach = np.abs(ppm) if sd is None else np.abs(ppm) + sd
    limit = nice_limit(max(float(reach.max()), 1e-3))
    chart = Chart(across(xs), upward(-limit, limit), x_title, "from the mean [ppm]")
    chart.axes()
    chart.level(0.0)
    if sd is not None:
        for x, y, half in zip(xs, ppm, sd, strict=True):
            chart.bar(x, y - half, y + half, "band")
    for x, y in zip(xs, ppm, strict=True):
        chart.mark(x, y, 0, "mark run0")
    spread = f"They scatter by {float(np.std(ppm)):.3g} ppm over {count(len(ppm), 'value')}."
    return Figure(title, chart.svg(f"{title}. {says} {spread}"), good, f"{says} {spread}")
