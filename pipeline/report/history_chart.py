"""The staircase: the errors of every model in the history."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import groupby

import numpy as np

from pipeline.formatting import DISPLAY, count, short_model
from pipeline.report.svg import LEFT, RIGHT, WIDTH, Chart, Figure, Scale, upward
from pipeline.results.history import Step, TriadStep

MOST_STEPS = 12  #: the last ones are shown


@dataclass(frozen=True)
class Stair:
    """One step as the page lists it: number, model, errors, verdict."""

    number: int
    model: str
    rms: str
    loo: str
    chi2: str
    verdict: str


@dataclass(frozen=True)
class Staircase:
    """All steps of one triad; no figures where there is one step only."""

    triad: str
    unit: str
    stairs: tuple[Stair, ...]
    figures: tuple[Figure, ...]


def staircase(triad: str, steps: Sequence[Step]) -> Staircase:
    """The steps of ``triad``; of neighbouring runs with one result, one step."""
    steps_of_triad = [step.triads[triad] for step in steps if triad in step.triads]
    kept = [step for step, _ in groupby(steps_of_triad)][-MOST_STEPS:]
    unit, factor = DISPLAY[triad]
    stairs = tuple(
        Stair(
            i, short_model(step.model), f"{step.residual_rms * factor:.4g}",
            f"{step.loo_rms * factor:.4g}", f"{step.chi2 / step.dof:.3g}",
            step.verdict.replace("_", " "),
        )
        for i, step in enumerate(kept, 1)
    )
    figures = (_errors(kept, unit, factor), _chi2(kept)) if len(kept) > 1 else ()
    return Staircase(triad, unit, stairs, figures)


def _errors(kept: Sequence[TriadStep], unit: str, factor: float) -> Figure:
    rms = np.array([step.residual_rms * factor for step in kept])
    loo = np.array([step.loo_rms * factor for step in kept])
    chart = _stairs_chart(np.concatenate([rms, loo]), len(kept), f"error [{unit}]")
    _draw(chart, loo, "loo", 1)
    _draw(chart, rms, "rms", 0)
    caption = (
        f"The residual (dots) changed from {rms[0]:.3g} to {rms[-1]:.3g} {unit}, the leave-one-out "
        f"error (squares) from {loo[0]:.3g} to {loo[-1]:.3g} {unit}, in {count(len(kept), 'step')}."
    )
    return Figure(
        "Errors, step by step", chart.svg(f"Errors, step by step. {caption}"),
        "both errors decrease. If the residual decreases and the leave-one-out error increases, "
        "the model fits the noise: remove the effect again.",
        caption,
    )


def _chi2(kept: Sequence[TriadStep]) -> Figure:
    values = np.array([step.chi2 / step.dof for step in kept])
    chart = _stairs_chart(np.append(values, 1.0), len(kept), "chi²/dof")
    chart.level(1.0, "diagonal")
    _draw(chart, values, "rms", 0)
    caption = f"chi²/dof changed from {values[0]:.3g} to {values[-1]:.3g}; the dashed line is 1."
    return Figure(
        "chi²/dof, step by step", chart.svg(f"chi²/dof, step by step. {caption}"),
        "the last step is near 1: the noise of the poses explains the residuals.",
        caption,
    )


def _stairs_chart(values: np.ndarray, steps: int, y_title: str) -> Chart:
    positive = values[values > 0]
    low, high = float(positive.min()), float(positive.max())
    chart = Chart(
        Scale(0.5, steps + 0.5, LEFT, WIDTH - RIGHT),
        upward(low / 1.6, high * 1.6, logarithmic=True), "step", y_title,
    )
    chart.axes([(i, str(i)) for i in range(1, steps + 1)])
    return chart


def _draw(chart: Chart, values: np.ndarray, kind: str, shape: int) -> None:
    at = np.arange(1, len(values) + 1, dtype=float)
    shown = np.maximum(values, chart.y.low)
    chart.line(np.stack([at - 0.5, at + 0.5], axis=1).ravel(), np.repeat(shown, 2), kind)
    for x, y in zip(at, shown, strict=True):
        chart.mark(x, y, shape, f"mark {kind}")
