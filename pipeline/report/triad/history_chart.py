"""The staircase: the errors of every model in the history, its steps named by effect."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import groupby, pairwise

import numpy as np

from pipeline.drawings.charts import Chart, Figure, rightward, upward
from pipeline.results.schema.noise import HistoryLine, HistoryTriad
from pipeline.text.formatting import DISPLAY, count, short_model, shortened

MOST_STEPS = 12  #: the last ones are shown
NAMED_STEPS = 4  #: so many names have room under the axis; more steps are numbered
LONGEST_NAME = {2: 22, 3: 15, 4: 12}  #: characters of a step's name, by the number of steps


@dataclass(frozen=True)
class Staircase:
    """All steps of one triad; no figure where there is one step only.

    A row of ``stairs`` has number, change, residual, leave-one-out error, chi²/dof and verdict.
    """

    triad: str
    unit: str
    stairs: tuple[tuple[str, ...], ...]
    figure: Figure | None


def staircase(triad: str, steps: Sequence[HistoryLine]) -> Staircase:
    """The steps of ``triad``; of neighbouring runs with one result, one step."""
    steps_of_triad = [step.triads[triad] for step in steps if triad in step.triads]
    kept = [step for step, _ in groupby(steps_of_triad)][-MOST_STEPS:]
    unit, factor = DISPLAY[triad]
    changes = step_names([one.model for one in kept])
    stairs = tuple(
        (str(i), change, f"{step.residual_rms * factor:.4g}", f"{step.loo_rms * factor:.4g}",
         f"{step.chi2 / step.dof:.3g}", step.verdict.replace("_", " "))
        for i, (step, change) in enumerate(zip(kept, changes, strict=True), 1)
    )
    figure = _errors(kept, unit, factor) if len(kept) > 1 else None
    return Staircase(triad, unit, stairs, figure)


def step_names(models: Sequence[Sequence[str]]) -> list[str]:
    """What every step changed: the effects it added (+) and removed (−).

    >>> step_names([["bias", "scale"], ["bias", "scale", "cubic"], ["bias", "scale"]])
    ['bias scale', '+ cubic', '− cubic']
    """
    names = [short_model(models[0])] if models else []
    for before, after in pairwise(models):
        words = [f"+ {name}" for name in after if name not in before]
        words += [f"− {name}" for name in before if name not in after]
        names.append(", ".join(words) or "run again")
    return names


def _errors(kept: Sequence[HistoryTriad], unit: str, factor: float) -> Figure:
    """Residual and leave-one-out error of every step, the steps named where there is room."""
    errors = {name: np.array([getattr(step, f"{name}_rms") * factor for step in kept])
              for name in ("loo", "residual")}
    shown = np.concatenate(list(errors.values()))
    low, high = shown[shown > 0].min() / 1.6, shown.max() * 1.6
    named, longest = len(kept) <= NAMED_STEPS, LONGEST_NAME.get(len(kept), 0)
    chart = Chart(rightward(0.5, len(kept) + 0.5), upward(low, high, logarithmic=True),
                  "" if named else "step", f"error [{unit}]")
    names = step_names([one.model for one in kept])
    chart.axes([(i, shortened(name, longest) if named else str(i))
                for i, name in enumerate(names, 1)])
    at = np.arange(1, len(kept) + 1, dtype=float)
    for shape, (name, values) in zip((1, 0), errors.items(), strict=True):
        heights = np.maximum(values, low)
        chart.line(np.stack([at - 0.5, at + 0.5], axis=1).ravel(), np.repeat(heights, 2), name)
        for x, y in zip(at, heights, strict=True):
            chart.mark(x, y, shape, f"mark {name}")
    rms, loo = errors["residual"], errors["loo"]
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
