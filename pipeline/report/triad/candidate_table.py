"""The candidates of the diagnosis as tables: their ranking, and what was looked for in vain."""

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from calib.diagnosis.verdict.ranking import Candidate
from calib.diagnosis.verdict.wording import odds_in_words, readable
from calib.effects.units import display_unit
from calib.numbers import NO_LENGTH
from pipeline.drawings.charts import tick_text
from pipeline.stages.triads import TriadResult
from pipeline.text.formatting import DISPLAY, with_minus_signs, with_sd

RANKED = 8  #: rows that are always shown; the others unfold
LEAST_SHARE = 1e-3  #: share of chi²: smaller drops are written as none


@dataclass(frozen=True)
class CandidateRow:
    """One hypothesis: what adding it alone does."""

    name: str
    probability: str
    chi2_drop: str
    size: str
    rms: str
    loo: str
    worse: bool
    aliases: str


def candidate_rows(result: TriadResult) -> tuple[CandidateRow, ...]:
    """Every hypothesis of the ranking, the most probable first."""
    return tuple(_row(result, each) for each in result.diagnosis.ranking if each.kind != "noise")


def _row(result: TriadResult, each: Candidate) -> CandidateRow:
    _, factor = DISPLAY[result.triad]
    rms, loo = (("–" if math.isnan(error) else f"{error * factor:.3g}")
                for error in (each.rms_after, each.loo_after))
    share = each.chi2_drop / max(result.calibration.fit.chi2, NO_LENGTH)
    name = each.name if each.kind == "listed" else readable(each.name, each.follows)
    drop = tick_text(float(f"{each.chi2_drop:.3g}"))
    return CandidateRow(
        name, odds_in_words(each.probability),
        f"{drop} ({100 * share:.0f} %)" if share > LEAST_SHARE else "–",
        _size(each), rms, loo,
        bool(each.loo_after > result.comparison.loo_rms), ", ".join(each.aliases))


def _size(each: Candidate) -> str:
    """The largest parameter with its sd, in the units of a data sheet."""
    if not each.size.size:
        return ""
    largest = max(range(len(each.size)), key=lambda j: abs(float(each.size[j])))
    unit, factor = display_unit(each.unit, each.size)
    value = with_sd(float(each.size[largest]) * factor, float(each.sd[largest]) * factor)
    return with_minus_signs(f"{value} {unit}")


def limit_rows(result: TriadResult) -> Iterator[tuple[str, str]]:
    """Every effect that was looked for and not named, with its upper limit at 95 %."""
    for limit in result.diagnosis.limits:
        unit, factor = display_unit(limit.unit, np.array([limit.value]))
        yield limit.name, f"{limit.value * factor:.2g} {unit}"
