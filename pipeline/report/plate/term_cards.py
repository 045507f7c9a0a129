"""A card for every term of the plate's phase: drawing, formula, fingerprint in the clip, size.

The fingerprint shows the angle residual of the clip without the term, and the term at its best size
beside everything else in the model, as means over parts of a turn or of the clip.
"""

import math
from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from calib.diagnosis.verdict.wording import enumeration
from calib.numbers import NO_LENGTH
from calib.poses.imu_log import FloatArray
from pipeline.drawings.charts import PLAIN, Chart, nice_limit, rightward, upward
from pipeline.report.plate.rate_terms import ANGLE_BINS, LEAST_LIMIT_DEG, angle_bins
from pipeline.report.triad.effect_cards import STANDINGS, Card, Standing, formula_html
from pipeline.stages.rate import SettingRate
from pipeline.text.formatting import with_minus_signs, with_sd
from vision.rate.term_pages import TERM_PAGES
from vision.rate.terms import CONSTANT_RATE, MEANING, TERMS, StatedFit

if TYPE_CHECKING:  # a session without clips measures none
    from vision.rate.measure import RateMeasurement

NO_FRAME_DROPPED = "no frame was dropped"


def term_cards(rate: SettingRate, number: int) -> tuple[Card, ...]:
    """A card for every term in clip ``number``, those of the verdict first."""
    clip = rate.clips[number]
    cards = (_card(clip, name) for name in TERMS)
    return tuple(sorted(cards, key=lambda card: not card.expanded))


def _card(clip: "RateMeasurement", name: str) -> Card:
    page, standing = TERM_PAGES[name], _standing(clip, name)
    seen = name in clip.fit.columns and standing != "unseen"
    measured, pattern = _signature(clip.fit, name) if seen else (np.zeros(1), np.zeros(1))
    share = float(pattern @ pattern) / max(float(measured @ measured), NO_LENGTH)
    group = clip.diagnosis.group if name in clip.diagnosis.group else ()
    others = [other for other in group if other != name]
    over = (f"{360 // ANGLE_BINS}° of plate angle" if page.over_turn
            else f"a {ANGLE_BINS}th of the clip")
    return Card(
        name=name,
        drawing=name,
        physics=MEANING[name],
        formula=formula_html(page.formula),
        standing=standing,
        status=NO_FRAME_DROPPED if standing == "unavailable" else STANDINGS[standing],
        typical=(("", f"{page.typical}."),),
        source=page.source,
        size_title="Size in this clip",
        size=_size(clip, name),
        fingerprint=_drawn(clip.fit, name, measured, pattern) if seen else "",
        caption=f"Dots are means of the angle residual without {name} over {over}; the line is "
                f"{name} at its best size. It explains {100 * share:.2g} % of the residual's "
                f"variance." if seen else "",
        confused=page.confounded,
        confused_here=f"This clip cannot separate it from {enumeration(others, 'or')}." if others
        else "",
        separates=page.separates,
        expanded=standing in ("missing", "offered"),
    )


def _standing(clip: "RateMeasurement", name: str) -> Standing:
    diagnosis = clip.diagnosis
    if name not in clip.fit.columns:
        return "unavailable"
    if name in clip.fit.model:
        return "model"
    if name == diagnosis.name and diagnosis.verdict == "effect":
        return "missing"
    if name in diagnosis.group and diagnosis.verdict == "ambiguous":
        return "offered"
    return "unseen" if any(c.blind for c in diagnosis.ranking if c.name == name) else "idle"


def _signature(fit: StatedFit, name: str) -> tuple[FloatArray, FloatArray]:
    """Residual of the used frames without the term, and what the term explains of it, degrees."""
    used = fit.used
    others = [fit.columns[CONSTANT_RATE]]
    measured = fit.residual_rad[used]
    for term in fit.terms:
        if term.name == name:
            measured = measured + fit.columns[name][used] @ term.value
        else:
            others.append(fit.columns[term.name])
    q, _ = np.linalg.qr(np.hstack(others)[used])
    columns = fit.columns[name][used]
    columns = columns - q @ (q.T @ columns)
    measured = measured - q @ (q.T @ measured)
    size = np.linalg.lstsq(columns, measured, rcond=None)[0]
    return np.degrees(measured), np.degrees(columns @ size)


def _drawn(fit: StatedFit, name: str, measured: FloatArray, pattern: FloatArray) -> str:
    """Means of the residual as dots and of the term as a line, over a turn or the clip."""
    time_s = fit.time_s[fit.used]
    over_turn = TERM_PAGES[name].over_turn
    if over_turn:
        x, low, high, title = np.degrees(fit.angle_rad[fit.used]), -180.0, 180.0, "plate angle [°]"
    else:
        x, low, high, title = time_s, time_s.min(), time_s.max(), "time in the clip [s]"
    bins = angle_bins(360 * (x - low) / max(high - low, NO_LENGTH) - 180)
    middle = low + (bins.middle + 180) * (high - low) / 360
    dots, line = bins.means(measured), bins.means(pattern)
    limit = nice_limit(max(float(np.abs([dots, line]).max()), LEAST_LIMIT_DEG))
    chart = Chart(rightward(low, high), upward(-limit, limit), title, "angle [°]", PLAIN)
    chart.axes()
    chart.level(0.0)
    chart.dots(middle, dots, "phase means")
    chart.line(middle, line, "mean")
    return chart.svg(f"Mean angle residual without {name}, and {name} at its best size.")


def _size(clip: "RateMeasurement", name: str) -> str:
    """The fitted size, or that of the diagnosis, with its sd; empty without any."""
    sizes = {c.name: (c.size, c.sd) for c in clip.diagnosis.ranking if not c.blind}
    sizes |= {term.name: (term.value, term.sd) for term in clip.fit.terms}
    if name not in sizes:
        return ""
    value, sd = sizes[name]
    return with_minus_signs(" ".join(_worded(name, value, sd, clip.rate_rad_s)))


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
