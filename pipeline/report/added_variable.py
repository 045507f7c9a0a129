"""The added-variable plot: what one effect explains of the residual of the rest of the model.

    before   residual of the model without the effect
    after    that residual less what the effect explains
    x        what the effect explains

each in noise units and with the rest of the model projected out (Cook & Weisberg, Residuals and
Influence in Regression, 1982, 2.3.2), so that the points before scatter about the diagonal when
the effect is there, and the points after about zero.
"""

from collections.abc import Sequence

import numpy as np

from pipeline.report.fingerprint import fingerprint
from pipeline.report.svg import Chart, Figure, across, upward
from pipeline.results.json_values import Json
from pipeline.stages.triads import TriadResult
from pipeline.text.formatting import count

ROOM = 1.08  #: the chart reaches beyond the largest value by this factor
TWO_SD = 2.0  #: half-width of the stripe: noise leaves it once in 22


def subject_of(result: TriadResult) -> str | None:
    """The effect to plot: the missing one, the one added last, or the most probable one."""
    diagnosis = result.diagnosis
    listed = [c.name for c in diagnosis.ranking if c.kind == "listed"]
    if diagnosis.verdict == "effect" and diagnosis.name in listed:
        return diagnosis.name
    added = [e.name for e in result.calibration.fit.model.effects if e.acts_on != "reading"]
    if added:
        return added[-1]
    open_names = [name for name in diagnosis.group if name in listed]
    return next(iter([*open_names, *listed]), None)


def added_variable_figure(result: TriadResult, payload: Json) -> Figure | None:
    """Before and after for the leading effect; None where no effect is in question.

    ``payload`` is :func:`pipeline.report.refit_data.refit_json` of the same triad.
    """
    name = subject_of(result)
    entries: Sequence[Json] = payload["effects"]
    entry = next((e for e in entries if e["name"] == name and e["reason"] is None), None)
    if name is None or entry is None:
        return None
    seen = fingerprint(payload, entry)
    before, explained = seen.measured, seen.pattern
    after = before - explained
    limit = ROOM * float(np.abs(np.concatenate([before, [2 * TWO_SD]])).max())
    chart = Chart(
        across(np.append(explained, [-TWO_SD, TWO_SD])), upward(-limit, limit),
        f"what {name} explains [sd]", "residual [sd]",
    )
    chart.axes()
    chart.stripe(-TWO_SD, TWO_SD)
    ends = np.array([max(chart.x.low, -limit), min(chart.x.high, limit)])
    chart.line(ends, ends, "diagonal")
    chart.level(0.0)
    for x, one, other, pose in zip(explained, before, after, payload["row_pose"], strict=True):
        chart.mark(x, one, 0, "mark before", attribute=f' data-i="{pose}"')
        chart.mark(x, other, 1, "mark after", attribute=f' data-i="{pose}"')
    outside = int((np.abs(after) > TWO_SD).sum())
    idle = result.diagnosis.verdict == "nothing_missing" and not entry["in_model"]
    caption = (
        f"{'Nothing is missing; this is the most probable candidate. ' if idle else ''}"
        f"The RMS residual is {np.sqrt(np.mean(before**2)):.3g} sd without {name} and "
        f"{np.sqrt(np.mean(after**2)):.3g} sd with it. With it, {outside} of "
        f"{count(len(before), 'residual')} exceed two sds."
    )
    return Figure(
        f"What {name} explains", chart.svg(f"Added-variable plot of {name}. {caption}"),
        "if the effect is real, the dots (without it) lie along the diagonal and the squares "
        "(with it) lie in the horizontal band of ± 2 sd.",
        caption,
    )
