"""Several clips decide between a readout delay and a wave of the plate."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest

from vision.rate.diagnosis import PhaseDiagnosis, TermCandidate
from vision.rate.together import judge_together

SLOW, FAST = 1.745, 3.491  #: rad/s


def verdict(delay_s: float, wave_rad: float, kind: str = "ambiguous") -> PhaseDiagnosis:
    """A clip that fits a delay and a wave nearly equally well."""
    delay = TermCandidate("rolling_shutter", 100.0, 900.0, np.array([delay_s]), np.array([1e-7]),
                          5e-4, False, ("once_per_rev",))
    wave = TermCandidate("once_per_rev", 99.0, 900.0, wave_rad * np.array([0.6, 0.8]),
                         np.full(2, 2e-5), 6e-4, False, ("rolling_shutter",))
    group = ("rolling_shutter", "once_per_rev")
    return PhaseDiagnosis(kind, group[0], group, "", "Film again.", (delay, wave))


def judged(rates: Sequence[float], delays: Sequence[float], waves: Sequence[float]) -> str:
    """The term that the clips together name for the first of them; empty where they do not."""
    clips = [(f"clip {i}", verdict(delay, wave), rate)
             for i, (rate, delay, wave) in enumerate(zip(rates, delays, waves, strict=True))]
    return getattr(judge_together(clips).get("clip 0"), "name", "") or ""


@pytest.mark.parametrize("rates", [(SLOW, FAST), (FAST, -FAST), (SLOW, FAST, -FAST)])
def test_a_delay_is_one_time_and_a_wave_one_size(rates: tuple[float, ...]) -> None:
    signed = np.array(rates)
    delay = 3e-5 * np.array([1.0, 1.03, 0.98])[: len(rates)]
    assert judged(rates, delay, np.abs(signed) * 4e-3) == "rolling_shutter"
    wave = 0.014 * np.array([1.0, 0.97, 1.02])[: len(rates)]
    # As a delay a wave of the plate reads inversely to the signed rate.
    assert judged(rates, 1e-4 / signed, wave) == "once_per_rev"


def test_one_speed_in_one_direction_decides_nothing() -> None:
    assert judged((FAST, FAST), (3e-5, 3.1e-5), (0.014, 0.0141)) == ""
    assert judged((FAST,), (3e-5,), (0.014,)) == ""


def test_no_clip_says_otherwise_than_all_together() -> None:
    """A small wave beside the delay has one clip name a wave."""
    alike = verdict(3e-5, 0.007, "effect")
    clips = [("a", alike, SLOW), ("b", verdict(3e-5, 0.014), FAST)]
    assert set(judge_together(clips)) == {"b"}
    clips[0] = ("a", replace(alike, name="once_per_rev"), SLOW)
    decided = judge_together(clips).values()
    assert {each.name for each in decided} == {"rolling_shutter"}
    assert {each.together.partition(":")[0] for each in decided} == {
        "The clips a, b together decide"}
    assert set(judge_together(clips)) == {"a", "b"}
