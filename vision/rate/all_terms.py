"""All terms that a phase track lacks: the named one is added and the rest diagnosed again."""

from collections.abc import Sequence
from dataclasses import replace

from vision.geometry import FloatArray
from vision.rate.diagnosis import PhaseDiagnosis, diagnose
from vision.rate.terms import Regressors


def diagnose_all(
    model: Sequence[str], base: Regressors, angle_rad: FloatArray, dropped: int
) -> PhaseDiagnosis:
    """The diagnosis of the stated model, with the terms that are missing beside the named one.

    Parameters are those of :func:`vision.rate.diagnosis.diagnose`. A term that looks the same as
    the named one is none of them.
    """
    first = diagnose(model, base, angle_rad, dropped)
    if first.verdict != "effect" or first.name is None:
        return first
    rest = diagnose_all((*model, first.name), base, angle_rad, dropped)
    if rest.verdict != "effect" or rest.name is None or rest.name in first.group:
        return first
    further = (rest.name, *rest.further)
    return replace(first, further=further, explanation=(
        f"{first.explanation} Then {' and '.join(further)} {'are' if further[1:] else 'is'} "
        f"missing too."))
