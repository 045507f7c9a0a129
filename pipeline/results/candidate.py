"""An entry of a ranking in results.json, of a triad's model and of a phase track's alike."""

from collections.abc import Sequence
from typing import Protocol

from calib.poses.imu_log import FloatArray
from pipeline.results.json_values import Json, number, numbers


class Ranked(Protocol):
    """What the candidates of both diagnoses have in common."""

    @property
    def name(self) -> str:
        """Name of the effect or term."""

    @property
    def log_evidence(self) -> float:
        """Log Bayes factor against the present model."""

    @property
    def chi2_drop(self) -> float:
        """Reduction of chi² with it."""

    @property
    def size(self) -> FloatArray:
        """Its parameters, (k,), each in its unit."""

    @property
    def sd(self) -> FloatArray:
        """Sds of its parameters, (k,), in the same units."""

    @property
    def aliases(self) -> Sequence[str]:
        """Effects or terms with the same signature in these data."""


def candidate_json(
    each: Ranked, rms_after: float, loo_after: float | None = None, is_blind: bool = False
) -> Json:
    """The entry of a candidate.

    Parameters
    ----------
    each : Ranked
    rms_after : float
        RMS residual with it: SI units of a triad, rad of a phase track.
    loo_after : float, optional
        Leave-one-out error with it, in the same unit; None where there is none.
    is_blind : bool
        Whether the data cannot determine it.
    """
    return {
        "name": each.name,
        "log_evidence": number(each.log_evidence),
        "chi2_drop": number(each.chi2_drop),
        "size": numbers(each.size),
        "sd": numbers(each.sd),
        "rms_after": number(rms_after),
        "loo_after": None if loo_after is None else number(loo_after),
        "blind": is_blind,
        "aliases": list(each.aliases),
    }
