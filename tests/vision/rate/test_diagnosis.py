"""Which term is missing: each hidden one is named, added, and the residual falls to the noise."""

from collections.abc import Callable, Sequence

import numpy as np
import pytest

from tests.vision.phase_tracks import CLOCK, NOISE, RPM, phase_track, steady
from vision.errors import RateRefused
from vision.geometry import FloatArray
from vision.rate.measure import RateMeasurement, measure_rate

Wave = Callable[[FloatArray, FloatArray], FloatArray]

ROWS_PX = 0.9 * 140  # the mark's radius in the made track


def measured(
    angle: FloatArray, model: Sequence[str] = (), **changes: object
) -> RateMeasurement:
    time, _ = steady()
    track = phase_track(time, angle, noise_rad=NOISE, **changes)
    return measure_rate(track, timebase=CLOCK, model=["constant_rate", *model])


def test_a_plain_track_misses_nothing() -> None:
    for seed in range(20):
        time, angle = steady()
        track = phase_track(time, angle, noise_rad=NOISE, seed=seed)
        assert measure_rate(track, timebase=CLOCK).diagnosis.verdict == "nothing_missing"


@pytest.mark.parametrize(
    ("name", "wave"),
    [
        ("once_per_rev", lambda t, a: 3e-3 * np.cos(a + 0.2)),
        ("twice_per_rev", lambda t, a: 2e-3 * np.sin(2 * a + 1.0)),
        ("rate_drift", lambda t, a: 0.5 * 4e-6 * (t - 30) ** 2),
    ],
)
def test_the_hidden_term_is_named_added_and_gone(name: str, wave: Wave) -> None:
    time, angle = steady()
    before = measured(angle + wave(time, angle))
    assert (before.diagnosis.verdict, before.diagnosis.name) == ("effect", name)
    after = measured(angle + wave(time, angle), [name])
    assert after.diagnosis.verdict == "nothing_missing"
    assert after.fit.rms_rad < 1.1 * NOISE < before.fit.rms_rad
    predicted = before.diagnosis.ranking[0].rms_after_rad
    assert after.fit.rms_rad == pytest.approx(predicted, rel=0.05)


def test_a_drift_is_measured_in_its_unit() -> None:
    time, angle = steady()
    after = measured(angle + 0.5 * 4e-6 * (time - 30) ** 2, ["rate_drift"])
    (term,) = after.fit.terms
    assert term.unit == "rad/s²"
    assert abs(term.value[0] - 4e-6) < 4 * term.sd[0]


def test_readout_delay_and_a_wave_are_one_group_with_the_way_to_separate_them() -> None:
    _, angle = steady()
    line_s = 30e-6
    seen = angle - 33.3 * RPM * line_s * ROWS_PX * np.sin(angle)
    diagnosis = measured(seen).diagnosis
    assert diagnosis.verdict == "ambiguous"
    assert set(diagnosis.group) == {"once_per_rev", "rolling_shutter"}
    assert "other direction" in str(diagnosis.record_next)
    after = measured(seen, ["rolling_shutter"])
    (term,) = after.fit.terms
    assert abs(term.value[0] - line_s) < 4 * term.sd[0] + 0.02 * line_s
    assert after.fit.rms_rad < 1.1 * NOISE


def test_a_wave_that_readout_delay_cannot_make_is_not_confused_with_it() -> None:
    _, angle = steady()
    diagnosis = measured(angle + 3e-3 * np.cos(angle)).diagnosis  # the other quadrature
    assert (diagnosis.verdict, diagnosis.name) == ("effect", "once_per_rev")


def test_readout_delay_and_a_wave_together_cannot_be_fitted() -> None:
    _, angle = steady()
    with pytest.raises(RateRefused, match="cannot separate the terms"):
        measured(angle, ["once_per_rev", "rolling_shutter"])


def test_dropped_frames_are_a_term_like_any_other() -> None:
    time, angle = steady()
    keep = np.random.default_rng(2).random(len(time)) > 0.01
    keep[:2] = True
    track = phase_track(time[: keep.sum()], angle[keep], noise_rad=NOISE)
    before = measure_rate(track, timebase=CLOCK)
    assert before.diagnosis.name == "frame_steps"
    assert before.fit.rms_rad > 100 * NOISE
    after = measure_rate(track, timebase=CLOCK, model=["constant_rate", "frame_steps"])
    assert after.fit.rms_rad < 1.1 * NOISE
    assert after.rate_rad_s == before.rate_rad_s
    assert after.fit.terms[0].value[0] == pytest.approx(1.0, abs=1e-3)


def test_a_shape_in_the_angle_that_no_term_has_is_unknown() -> None:
    _, angle = steady()
    diagnosis = measured(angle + 2e-3 * np.cos(5 * angle)).diagnosis
    assert (diagnosis.verdict, diagnosis.name) == ("unknown", "plate angle")


def test_all_hidden_terms_are_named_at_once() -> None:
    time, angle = steady()
    seen = angle + 4e-3 * np.cos(angle) + 2e-3 * np.cos(2 * angle) + 0.5 * 4e-6 * (time - 30) ** 2
    found = measured(seen).diagnosis
    every = (found.name, *found.further)
    assert {*every} == {"once_per_rev", "twice_per_rev", "rate_drift"}
    assert f"Then {' and '.join(found.further)} are missing too." in found.explanation
    assert measured(seen, [*every]).diagnosis.verdict == "nothing_missing"
