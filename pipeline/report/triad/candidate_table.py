"""The candidates of the diagnosis as tables: their ranking, and what was looked for in vain."""

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from calib.diagnosis.verdict.ranking import Candidate
from calib.diagnosis.verdict.wording import odds_in_words, readable
from calib.effects.units import display_unit
from calib.numbers import NO_LENGTH
from calib.rounding import in_digits, two_digits
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
    return tuple(_row(result, one) for one in result.diagnosis.ranking if one.kind != "noise")


def _row(result: TriadResult, candidate: Candidate) -> CandidateRow:
    _, factor = DISPLAY[result.triad]
    rms, loo = (("–" if math.isnan(error) else in_digits(error * factor, 3))
                for error in (candidate.rms_after, candidate.loo_after))
    share = candidate.chi2_drop / max(result.calibration.fit.chi2, NO_LENGTH)
    name = candidate.name
    if candidate.kind != "listed":
        name = readable(name, candidate.follows)
    drop = tick_text(float(f"{candidate.chi2_drop:.3g}"))
    classes = (one.members for one in result.diagnosis.inclusion if name in one.members)
    shared = len(next(classes, ()))
    odds = odds_in_words(candidate.probability)
    return CandidateRow(
        name, f"one of {shared}: {odds}" if shared > 1 else odds,
        f"{drop} ({100 * share:.0f} %)" if share > LEAST_SHARE else "–",
        _size(candidate), rms, loo,
        bool(candidate.loo_after > result.comparison.loo_rms), ", ".join(candidate.aliases))


def _size(candidate: Candidate) -> str:
    """The largest parameter with its sd, in the units of a data sheet."""
    if not candidate.size.size:
        return ""
    largest = max(range(len(candidate.size)), key=lambda j: abs(float(candidate.size[j])))
    unit, factor = display_unit(candidate.unit, candidate.size)
    value = with_sd(float(candidate.size[largest]) * factor, float(candidate.sd[largest]) * factor)
    return with_minus_signs(f"{value} {unit}")


def limit_rows(result: TriadResult) -> Iterator[tuple[str, str]]:
    """Every effect that was looked for and not named, with its upper limit at 95 %."""
    for limit in result.diagnosis.limits:
        unit, factor = display_unit(limit.unit, np.array([limit.value]))
        yield limit.name, f"{two_digits(limit.value * factor)} {unit}"
