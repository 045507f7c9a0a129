"""Where the model fails, axis by axis: partial residuals of the effects worth showing."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from calib.effects.catalogue import UnknownEffect, find_effect
from calib.effects.effect import Effect
from pipeline.formatting import count, with_sd
from pipeline.report.partial_residuals import Panel, panels
from pipeline.report.refit_data import best_shape
from pipeline.report.svg import Chart, Figure, across, nice_limit, upward
from pipeline.stages.triads import TriadResult

MOST_COLUMNS = 6  #: logged columns with panels
ATTITUDE = "g_sensitivity"  #: what shows an error of a gyroscope that follows its attitude
TIME = "bias_drift"  #: what shows a bias that follows time


@dataclass(frozen=True)
class AxisCharts:
    """The panels of one effect; ``leads`` for those that the verdict names or the model holds.

    ``against`` names what drives the effect.
    """

    effect: str
    against: str
    physics: str
    leads: bool
    caption: str
    figures: tuple[Figure, ...]


def axis_charts(result: TriadResult) -> tuple[AxisCharts, ...]:
    """The panels of every effect worth showing: the verdict's first, then the covariates'."""
    fit = result.calibration.fit
    leading = list(_leading(result))
    charts: list[AxisCharts] = []
    known: set[tuple[str, ...]] = set()  # a column and an effect of it have the same panels
    for name in dict.fromkeys([*leading, *_covariates(result)]):
        try:
            effect = find_effect(name)
        except UnknownEffect:  # a user's own effect is no entry of the catalogue
            continue
        shown = panels(fit, effect, _shape(result, effect))
        drawn = tuple(f"{p.axis} {p.driver.label} {p.unit} {p.slope:.4g}" for p in shown)
        if shown and drawn not in known:
            known.add(drawn)
            charts.append(_charts(effect, shown, name in leading))
    return tuple(charts)


def _leading(result: TriadResult) -> Iterator[str]:
    """The effects that the verdict names, or else those that were added to the model."""
    diagnosis = result.diagnosis
    if diagnosis.verdict in ("effect", "ambiguous"):
        listed = {c.name for c in diagnosis.ranking if c.kind == "listed"}
        yield from (name for name in (*diagnosis.group, diagnosis.partner) if name in listed)
    if diagnosis.verdict == "unknown" and diagnosis.name in result.calibration.fit.poses.columns:
        yield f"column:{diagnosis.name}"
    yield from (e.name for e in result.calibration.fit.model.effects if e.acts_on == "sensor")


def _covariates(result: TriadResult) -> Iterator[str]:
    """A bias against every covariate that varies: time, the logged columns, the attitude."""
    poses = result.calibration.fit.poses
    shown = [TIME, *(f"column:{name}" for name in list(poses.columns)[:MOST_COLUMNS])]
    if result.triad == "gyroscope":
        shown.append(ATTITUDE)
    unseen = {*result.diagnosis.blind, *result.diagnosis.unavailable}
    yield from (name for name in shown if name not in unseen)


def _shape(result: TriadResult, effect: Effect) -> float | None:
    fit = result.calibration.fit
    if effect.shape is None or effect.name in fit.model.names:
        return None
    return best_shape(fit, fit.model + effect, effect)


def _charts(effect: Effect, shown: tuple[Panel, ...], leads: bool) -> AxisCharts:
    reach = max(float(np.abs(np.concatenate([p.before, p.after])).max() + p.sd.max())
                for p in shown)
    limit = nice_limit(reach)
    before, after = (np.concatenate([values / p.sd for p, values in zip(shown, each, strict=True)])
                     for each in ([p.before for p in shown], [p.after for p in shown]))
    caption = (
        f"RMS in sds: {np.sqrt(np.mean(before**2)):.3g} without {effect.name} (dots), "
        f"{np.sqrt(np.mean(after**2)):.3g} with it (squares)."
    )
    figures = tuple(_figure(effect.name, panel, limit) for panel in shown)
    against = ", ".join(dict.fromkeys(p.driver.label for p in shown))
    return AxisCharts(effect.name, against, effect.physics, leads, caption, figures)


def _figure(name: str, panel: Panel, limit: float) -> Figure:
    driver = panel.driver
    x_title = f"{driver.label} [{driver.unit}]" if driver.unit else driver.label
    what = "scale error" if panel.unit == "ppm" else "error"
    chart = Chart(across(panel.x), upward(-limit, limit), x_title,
                  f"{what} of axis {panel.axis} [{panel.unit}]")
    chart.axes()
    chart.level(0.0)
    for x, y, sd in zip(panel.x, panel.before, panel.sd, strict=True):
        chart.bar(x, max(y - sd, -limit), min(y + sd, limit), "error-bar")
    chart.line(panel.curve[0], np.clip(panel.curve[1], -limit, limit), "effect")
    for x, y, other in zip(panel.x, panel.before, panel.after, strict=True):
        chart.mark(x, y, 0, "mark before")
        chart.mark(x, other, 1, "mark after")
    if np.isfinite(panel.slope):
        per = driver.unit or f"unit of {driver.label}"
        text = f"{with_sd(panel.slope, panel.slope_sd)} {panel.unit} per {per}"
    else:
        text = f"a curve over {count(len(panel.x), 'pose')}"
    axis = panel.axis if panel.parameter == panel.axis else f"{panel.axis} ({panel.parameter})"
    title = f"Axis {axis}: {text}".replace("-", "−")
    alternative = f"{what.capitalize()} of axis {panel.axis} against {driver.label}: {text}."
    return Figure(title, chart.svg(f"{name}. {alternative}"), "", "")
