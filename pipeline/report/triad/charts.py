"""The charts of one triad: its residuals pose by pose, and its errors model by model.

The staircase shows the errors of every model in the history, its steps named by effect.
"""

from collections.abc import Mapping, Sequence
from itertools import groupby, pairwise

import numpy as np
from scipy.special import gammainc

from calib.diagnosis.next_measurement.advice import pose_in_words, shown_name
from calib.fit.least_squares.result import Fit
from pipeline.drawings.charts import (
    SHAPES,
    Chart,
    Figure,
    nice_limit,
    pixel,
    rightward,
    tick_text,
    upward,
)
from pipeline.results.json_values import Json
from pipeline.results.schema.noise import HistoryLine, HistoryTriad
from pipeline.stages.triads import TriadResult
from pipeline.text.formatting import DISPLAY, count, short_model, shortened, with_sd

SHOWN_SD = 4.0  #: residual charts reach at least this many typical sds
FRACTIONS = (-1.0, -0.5, 0.0, 0.5, 1.0)  #: shares of a chart's limit that have a number
RUN_COLOURS = 6  #: number of colours of the style sheet

EXCLUDED = "excluded"  #: class of their marks, and name of their group in the chart


def residual_figure(result: TriadResult) -> Figure:
    """The residual of every pose with its noise band, in the order of the configuration."""
    poses = result.comparison.poses
    excluded = [one.predicted for one in result.excluded if one.predicted is not None]
    rows = result.calibration.fit.equations.row_count
    unit, factor = DISPLAY[result.triad]
    typical = sorted(pose.sd for pose in poses)[len(poses) // 2]
    reach = max(SHOWN_SD * typical, *(abs(pose.residual) + pose.sd for pose in poses))
    limit = nice_limit(reach * factor)  # the script of the page computes the same
    chart = Chart(rightward(-0.5, len(poses) + len(excluded) - 0.5),
                  upward(-limit / factor, limit / factor), "pose", f"residual [{unit}]")
    chart.y_axis([(part * limit / factor, tick_text(part * limit)) for part in FRACTIONS],
                 [f' data-fraction="{part:g}"' for part in FRACTIONS])
    chart.level(0.0)
    chart.groups([*(pose.run for pose in poses), *[EXCLUDED] * len(excluded)])
    number = _run_numbers(result)
    for i, pose in enumerate(poses):
        attribute = f' data-i="{i}" data-x="{pixel(chart.x(i))}"'
        low = -pose.sd if rows[i] == 1 else 0.0  # several rows have no sign together
        chart.bar(i, low, pose.sd, "band", attribute)
    for i, pose in enumerate(poses):
        attribute = f' data-i="{i}" data-x="{pixel(chart.x(i))}"'
        value = with_sd(pose.residual * factor, pose.sd * factor)
        chart.mark(i, pose.residual, number[pose.run],
                   f"mark run{number[pose.run] % RUN_COLOURS}",
                   f"{shown_name(pose.label)}: {value} {unit}, {pose.in_sd:+.1f} sd", attribute)
    for i, one in enumerate(excluded, len(poses)):  # those far off are at the edge
        pose = one.residual
        value = with_sd(pose.residual * factor, pose.sd * factor)
        chart.mark(i, float(np.clip(pose.residual, chart.y.low, chart.y.high)), 0, EXCLUDED,
                   f"{shown_name(pose.label)}: excluded; {value} {unit}",
                   f' data-x="{pixel(chart.x(i))}" data-value="{pose.residual * factor:.6g}"')
    within = sum(abs(pose.in_sd) <= 1 for pose in poses)
    worst = result.comparison.worst(1)[0]
    caption = (
        f"{within} of {len(poses)} residuals are smaller than one sd; "
        f"{_expected_within(result):.0f} are expected. The largest is "
        f"{abs(worst.in_sd):.1f} sds: {pose_in_words(result.calibration.fit, worst.label)}."
    )
    if excluded:
        marks, them = (("mark is the pose", "it") if len(excluded) == 1 else
                       ("marks are the poses", "them"))
        caption += (f" The hollow {marks} that the configuration excludes, by the fit without "
                    f"{them}.")
    title = "Residual of every pose"
    span = f' data-top="{chart.y.end:g}" data-bottom="{chart.y.start:g}"'
    return Figure(title, chart.svg(f"{title}. {caption}", span, "residuals"),
                  _good_residuals(result.calibration.fit), caption)


def _good_residuals(fit: Fit) -> str:
    """The look of good residuals; those of poses with several rows cannot scatter about zero."""
    several, at_rest = fit.equations.row_count > 1, fit.poses.reference.is_null
    scatter = "have no pattern" if several.all() else "scatter about zero without a pattern"
    words = f"the marks {scatter}, most of them inside their bar (one sd of the noise of the pose)."
    if at_rest.any():
        words += (" A pose with the plate stopped shows the length of the remaining vector, which "
                  "cannot be negative.")
    if (several & ~at_rest).any():
        words += (" A pose in which gravity goes round shows all its residuals: the root mean "
                  "square of that of its length and of those along and across the axis, each in "
                  "its sd, which cannot be negative.")
    return words


def _expected_within(result: TriadResult) -> float:
    """The expected number of residuals below one sd if the model is right.

    The fit absorbs part of the noise: it reduces the variance of a residual by ``dof / rows``.
    """
    fit = result.calibration.fit
    half = fit.equations.row_count / 2
    return float(gammainc(half, half * fit.equations.data_count / max(fit.dof, 1)).sum())


def _run_numbers(result: TriadResult) -> Mapping[str, int]:
    """The runs, numbered in their order, for the shape and colour of their marks."""
    runs = dict.fromkeys(pose.run for pose in result.comparison.poses)
    return {run: i for i, run in enumerate(runs)}


def run_legend(result: TriadResult) -> list[tuple[str, str, str]]:
    """Class, outline and name of every run; empty for one run."""
    number = _run_numbers(result)
    if len(number) < 2:
        return []
    return [(f"run{i % RUN_COLOURS}", SHAPES[i % len(SHAPES)], run) for run, i in number.items()]


MOST_STEPS = 12  #: the last ones are shown
NAMED_STEPS = 4  #: names that fit under the axis; more steps are numbered
LONGEST_NAME = {2: 20, 3: 13, 4: 9}  #: characters of a step's name, by the number of steps


def staircase(triad: str, steps: Sequence[HistoryLine]) -> Json:
    """The steps of ``triad``; of neighbouring runs with one result, one step.

    A row of ``stairs`` has number, change, residual, leave-one-out error, chi²/dof and verdict.
    There is no figure where there is one step only.
    """
    steps_of_triad = [step.triads[triad] for step in steps if triad in step.triads]
    kept = [step for step, _ in groupby(steps_of_triad)][-MOST_STEPS:]
    unit, factor = DISPLAY[triad]
    changes = step_names([one.model for one in kept])
    stairs = [
        (str(i), change, f"{step.residual_rms * factor:.4g}", f"{step.loo_rms * factor:.4g}",
         f"{step.chi2 / step.dof:.3g}", step.verdict.replace("_", " "))
        for i, (step, change) in enumerate(zip(kept, changes, strict=True), 1)
    ]
    figure = _errors(kept, unit, factor) if len(kept) > 1 else None
    return {"unit": unit, "stairs": stairs, "figure": figure}


def step_names(models: Sequence[Sequence[str]]) -> list[str]:
    """Change of every step: the effects it added (+) and removed (−).

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
    """Residual and leave-one-out error of every step, with the steps' names if they fit."""
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
        f"In {count(len(kept) - 1, 'step')} the residual (dots) changed from {rms[0]:.3g} to "
        f"{rms[-1]:.3g} {unit}, the leave-one-out error (squares) from {loo[0]:.3g} to "
        f"{loo[-1]:.3g} {unit}."
    )
    return Figure(
        "Errors, step by step", chart.svg(f"Errors, step by step. {caption}"),
        "both errors decrease. If the residual decreases and the leave-one-out error increases, "
        "the model fits the noise: remove the effect again.",
        caption,
    )
