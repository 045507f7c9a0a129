"""Effect of a change of the model or of the poses, for the terminal."""

import math
from collections.abc import Iterator

from pipeline.console.parameter_text import effect_rows, shown_effects
from pipeline.console.run_text import verdict_line
from pipeline.model_change import ModelChange, result_of
from pipeline.stages.rate import SettingRate
from pipeline.stages.run import Outcome
from pipeline.stages.triads import TriadResult
from pipeline.text.formatting import DISPLAY
from pipeline.text.tables import table_lines


def change_lines(change: ModelChange) -> Iterator[str]:
    """The table before → after, the new effect's size ± sd, and the new verdict."""
    before, after = (result_of(outcome, change.target) for outcome in (change.before, change.after))
    if before is not None and after is not None:
        yield from _error_lines(str(change.target), before, after)
        for shown in shown_effects(after.calibration):
            if shown.effect.name == change.target.name:
                yield from table_lines(effect_rows(shown), indent="")
        yield verdict_line(after)
        return
    setting = str(change.target.section[1])
    yield from _rate_lines(setting, change.before, change.after)


def exclusion_lines(before: Outcome, after: Outcome) -> Iterator[str]:
    """The errors before → after of every triad that has fewer poses, and its new verdict."""
    for one, other in zip(before.triads, after.triads, strict=True):
        poses = [len(each.comparison.poses) for each in (one, other)]
        if poses[1] < poses[0]:
            yield from _error_lines(f"{one.triad}, {poses[0]} → {poses[1]} poses", one, other)
            yield verdict_line(other)


def _error_lines(title: str, before: TriadResult, after: TriadResult) -> Iterator[str]:
    unit, factor = DISPLAY[before.triad]
    rows = [[title, "before", "after"]]
    rows.append([f"RMS [{unit}]", *(f"{r.comparison.residual_rms * factor:.4g}"
                                    for r in (before, after))])
    rows.append([f"leave-one-out [{unit}]", *(f"{r.comparison.loo_rms * factor:.4g}"
                                              for r in (before, after))])
    rows.append(["chi²/dof", *(f"{r.calibration.fit.chi2 / r.calibration.fit.dof:.3g}"
                               for r in (before, after))])
    rows.append(["verdict", *(r.diagnosis.verdict for r in (before, after))])
    yield from table_lines(rows, indent="")


def _rate_lines(setting: str, before: Outcome, after: Outcome) -> Iterator[str]:
    rates: list[SettingRate] = [outcome.rates[setting] for outcome in (before, after)]
    rows = [[f"rate.{setting}", "before", "after"]]
    largest = (max(clip.fit.rms_rad for clip in rate.clips) for rate in rates)
    rows.append(["phase residual [°]", *(f"{math.degrees(rms):.4g}" for rms in largest)])
    rows.append(["verdict", *(r.clips[0].diagnosis.verdict for r in rates)])
    yield from table_lines(rows, indent="")
    for clip in rates[1].clips[:1]:
        for term in clip.fit.terms:
            values = ", ".join(f"{v:.3g} ± {s:.2g}" for v, s in zip(term.value, term.sd,
                                                                    strict=True))
            yield f"  {term.name}: {values} {term.unit}"
        yield clip.diagnosis.explanation
