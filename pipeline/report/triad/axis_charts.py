"""Misfit of the model, axis by axis: partial residuals of the effects worth showing."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from calib.diagnosis.constants import CONSTANTS
from calib.diagnosis.verdict.decision import Code
from calib.effects.effect import OF_COLUMN
from calib.poses.imu_log import FloatArray
from pipeline.drawings.charts import (
    PLAIN,
    SMALL,
    Canvas,
    Chart,
    Figure,
    across,
    nice_limit,
    tick_text,
    upward,
)
from pipeline.report.triad.partial_residuals import REFERENCE, Panel, panels
from pipeline.report.triad.refitted import Refits
from pipeline.stages.triads import TriadResult
from pipeline.text.formatting import count, with_minus_signs, with_sd

MOST_COLUMNS = 6  #: logged columns with panels
TIME = "bias_drift"  #: the effect that shows a bias that follows time
PLATE = "direction_dependent_rate"  #: the effect that shows an error that follows the plate


@dataclass(frozen=True, eq=False)
class AxisCharts:
    """The panels of one effect; ``leads`` for those that the verdict names or the model contains.
    """

    effect: str
    physics: str
    leads: bool
    in_model: bool
    panels: tuple[Panel, ...]

    @property
    def caption(self) -> str:
        """RMS of the errors without the effect and with it, in words."""
        without, with_it = (
            float(np.sqrt(np.mean(np.concatenate(errors) ** 2)))
            for errors in zip(*((p.before / p.sd, p.after / p.sd) for p in self.panels),
                              strict=True))
        return f"RMS in sds: {without:.3g} without {self.effect}, {with_it:.3g} with it."

    @property
    def figures(self) -> tuple[Figure, ...]:
        """A small chart for every panel, all with one y axis."""
        limit = nice_limit(max(_reach(panel) for panel in self.panels))
        return tuple(panel_figure(self.effect, panel, limit) for panel in self.panels)


def axis_charts(refits: Refits) -> tuple[AxisCharts, ...]:
    """The panels of every effect worth showing: the verdict's first, then the covariates'."""
    result = refits.result
    leading = list(_leading(result))
    offered = [c.name for c in result.diagnosis.listed.values()
               if c.probability >= CONSTANTS.least_offered]
    charts: list[AxisCharts] = []
    model = result.calibration.fit.model.names
    known: set[tuple[str, ...]] = set()  # a column and an effect of it have the same panels
    for name in dict.fromkeys([*leading, *offered, *_covariates(result)]):
        effect = refits.effect(name)
        if effect is None or result.triad not in effect.triads or (
                effect.acts_on in ("reading", "noise")):
            continue
        # Together with the other effects that the verdict names.
        names = result.diagnosis.names if name in result.diagnosis.names else ()
        beside = list(dict.fromkeys([*refits.run.added, *names, name]))
        joint = refits.of(beside)
        shown = () if joint is None else panels(joint.fit, effect, _sd_of(result, name))
        drawn = tuple(f"{p.axis} {p.against} {p.per} {p.slope:.4g}" for p in shown)
        if shown and drawn not in known:
            known.add(drawn)
            charts.append(AxisCharts(name, effect.physics, name in leading, name in model, shown))
    return tuple(charts)


def _leading(result: TriadResult) -> Iterator[str]:
    """The effects that the verdict names, or else those that were added to the model."""
    diagnosis = result.diagnosis
    if diagnosis.verdict in (Code.EFFECT, Code.AMBIGUOUS):
        yield from (name for name in (*diagnosis.names, *diagnosis.group)
                    if name in diagnosis.listed)
    if diagnosis.verdict is Code.UNKNOWN:
        if diagnosis.name in result.calibration.fit.poses.columns:
            yield f"{OF_COLUMN}{diagnosis.name}"
        elif diagnosis.name in ("bias_step", "time_s"):
            yield TIME
    yield from (e.name for e in result.calibration.fit.model.effects if e.acts_on != "reading")


def _covariates(result: TriadResult) -> Iterator[str]:
    """Errors against every covariate that varies: time, the logged columns, attitude, plate."""
    poses = result.calibration.fit.poses
    shown = [TIME, *(OF_COLUMN + name for name in list(poses.columns)[:MOST_COLUMNS]),
             "g_sensitivity" if result.triad == "gyroscope" else "quadratic", PLATE]
    unseen = {*result.diagnosis.blind, *result.diagnosis.unavailable}
    yield from (name for name in shown if name not in unseen)


def _sd_of(result: TriadResult, name: str) -> FloatArray | None:
    """Sds (k,) of the parameters of a missing effect, SI, as the verdict quotes them; else None."""
    candidates = result.diagnosis.ranking if name in result.diagnosis.names else ()
    return next((one.sd for one in candidates if one.name == name and one.sd.size), None)


def _reach(panel: Panel) -> float:
    dots = np.abs(np.concatenate([panel.before, panel.after])).max() + panel.sd.max()
    return float(max(dots, np.abs(panel.curve[1]).max()))


def lead_panel(
    result: TriadResult, charts: tuple[AxisCharts, ...]
) -> tuple[Figure | None, str]:
    """The figure of the first screen, and the effect whose before and after it shows.

    The panel of the missing effect with the largest effect, in large; None where nothing is named.
    An error of a shape that no listed effect has is shown against its covariate, without a line and
    a name.
    """
    first = charts[0] if charts else None
    if first is None or not first.leads or first.in_model:
        return None, ""
    if result.diagnosis.verdict is Code.UNKNOWN:
        panel = max(first.panels, key=lambda one: float(np.mean((one.before / one.sd) ** 2)))
        chart, what = _error_chart(panel, nice_limit(_reach(panel)), PLAIN)
        title = f"{what.capitalize()} against {panel.against}"
        return Figure(title, chart.svg(f"{title}."), ""), ""
    panel = max(first.panels, key=_prominence(first.panels))
    figure = panel_figure(first.effect, panel, nice_limit(_reach(panel)), PLAIN)
    return replace(figure, title=_sentence(panel) or figure.title), first.effect


def _prominence(shown: Sequence[Panel]) -> Callable[[Panel], float]:
    """Score of a panel: the slope, as the verdict quotes the largest one.

    Curves without a slope are compared by the part they explain.
    """
    if all(np.isfinite(panel.slope) for panel in shown):
        return lambda panel: abs(panel.slope)
    return lambda panel: panel.significance


def panel_figure(name: str, panel: Panel, limit: float, canvas: Canvas = SMALL) -> Figure:
    """One panel as a chart with a y axis from -limit to limit."""
    chart, what = _error_chart(panel, limit, canvas)
    chart.line(panel.curve[0], np.clip(panel.curve[1], -limit, limit), "effect")
    chart.squares(panel.x, panel.after, "after-squares")
    title = _title(panel)
    alternative = f"{what.capitalize()} against {panel.against}: {title}."
    return Figure(title, chart.svg(f"{name}. {alternative}"), "", "")


def _error_chart(panel: Panel, limit: float, canvas: Canvas) -> tuple[Chart, str]:
    """The errors without the effect, with their sds and the noise band; and a description of them.
    """
    of_reference = panel.axis == REFERENCE
    what = ("error of the reference" if of_reference else
            f"{'scale error' if panel.unit == 'ppm' else 'error'} of axis {panel.axis}")
    x_title = f"{panel.against} [{panel.per}]" if panel.per else panel.against
    chart = Chart(across(panel.x, canvas), upward(-limit, limit, canvas=canvas), x_title,
                  f"{what} [{panel.unit}]", canvas)
    chart.axes(list(panel.ticks) or None)
    noise = float(np.median(panel.sd))
    chart.stripe(-noise, noise)
    chart.level(0.0)
    low, high = (np.clip(panel.before + sign * panel.sd, -limit, limit) for sign in (-1, 1))
    chart.bars(panel.x, low, high, "error-bar")
    chart.poses(panel.x, panel.before, panel.pose, "before-dots")
    return chart, what


def _sentence(panel: Panel) -> str:
    """Description of the panel in words; empty where its curve has no slope."""
    if not np.isfinite(panel.slope) or panel.axis == REFERENCE:
        return ""
    value = with_minus_signs(with_sd(panel.slope, panel.slope_sd))
    what = "The scale of axis" if panel.unit == "ppm" else "Axis"
    return (f"{what} {panel.axis} errs by {value} {panel.unit} per {_per(panel)} of "
            f"{panel.against}")


def _per(panel: Panel) -> str:
    """Unit of the driver in sizes: a change of temperature is in kelvin."""
    return "K" if panel.per == "°C" else panel.per or "unit"


def _title(panel: Panel) -> str:
    """Title of the panel, as a sentence: "Axis x: 0.1217 ± 0.0029 °/s per g"."""
    if np.isfinite(panel.slope):
        text = f"{with_sd(panel.slope, panel.slope_sd)} {panel.unit} per {_per(panel)}"
    else:
        span = float(np.ptp(panel.curve[1]))
        text = f"{tick_text(float(f'{span:.3g}'))} {panel.unit} over {count(len(panel.x), 'pose')}"
    if panel.axis == REFERENCE:
        return with_minus_signs(f"Reference: {text}")
    axis = panel.axis if panel.parameter == panel.axis else f"{panel.axis} ({panel.parameter})"
    return with_minus_signs(f"Axis {axis}: {text}")
