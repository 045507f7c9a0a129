"""The staircase: how the errors fell from model to model."""

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
    taken = [step.triads[triad] for step in steps if triad in step.triads]
    kept = [own for own, _ in groupby(taken)][-MOST_STEPS:]
    unit, factor = DISPLAY[triad]
    stairs = tuple(
        Stair(
            i, short_model(own.model), f"{own.residual_rms * factor:.4g}",
            f"{own.loo_rms * factor:.4g}", f"{own.chi2 / own.dof:.3g}",
            own.verdict.replace("_", " "),
        )
        for i, own in enumerate(kept, 1)
    )
    figures = (_errors(kept, unit, factor), _chi2(kept)) if len(kept) > 1 else ()
    return Staircase(triad, unit, stairs, figures)


def _errors(kept: Sequence[TriadStep], unit: str, factor: float) -> Figure:
    rms = np.array([own.residual_rms * factor for own in kept])
    loo = np.array([own.loo_rms * factor for own in kept])
    chart = _stairs_chart(np.concatenate([rms, loo]), len(kept), f"error [{unit}]")
    _draw(chart, loo, "loo", 1)
    _draw(chart, rms, "rms", 0)
    says = f"Residual (dots) from {rms[0]:.3g} to {rms[-1]:.3g} {unit}, leave-one-out (squares) " \
           f"from {loo[0]:.3g} to {loo[-1]:.3g} {unit}, in {count(len(kept), 'step')}."
    return Figure(
        "Errors, step by step", chart.svg(f"Errors, step by step. {says}"),
        "both stairs lead down together. Where the residual falls and the leave-one-out error "
        "rises, the model has learned the noise: take the effect out again.",
        says,
    )


def _chi2(kept: Sequence[TriadStep]) -> Figure:
    values = np.array([own.chi2 / own.dof for own in kept])
    chart = _stairs_chart(np.append(values, 1.0), len(kept), "chi²/dof")
    chart.level(1.0, "diagonal")
    _draw(chart, values, "rms", 0)
    says = f"From {values[0]:.3g} to {values[-1]:.3g}; the dashed line is 1."
    return Figure(
        "chi²/dof, step by step", chart.svg(f"chi²/dof, step by step. {says}"),
        "the last step ends near 1: then the poses' own noise explains what is left.",
        says,
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
