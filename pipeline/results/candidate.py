"""An entry of a ranking in results.json, of a triad's model and of a phase track's alike."""

from collections.abc import Sequence
from typing import Protocol

from calib.poses.imu_log import FloatArray
from pipeline.results.json_values import Json, number, numbers


class Ranked(Protocol):
    """What the candidates of both diagnoses have in common."""

    @property
    def name(self) -> str:
        """Effect or term."""

    @property
    def log_evidence(self) -> float:
        """Against the present model."""

    @property
    def chi2_drop(self) -> float:
        """By how much chi² falls with it."""

    @property
    def size(self) -> FloatArray:
        """Of its parameters, (k,), each in its unit."""

    @property
    def sd(self) -> FloatArray:
        """Of these, (k,), in the same unit."""

    @property
    def aliases(self) -> Sequence[str]:
        """What looks the same."""


def candidate_json(
    each: Ranked, rms_after: float, loo_after: float | None = None, is_blind: bool = False
) -> Json:
    """The entry of a candidate; its errors are in the unit of its ranking, None where none is.

    ``is_blind`` says that the data cannot see it.
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
