"""A further triad is one more record: fit, diagnosis, prediction and words need no other line."""

from collections.abc import Iterator

import numpy as np
import pytest

from calib.assess import assess
from calib.diagnosis.verdict.decision import Code
from calib.effects.catalogue import BASE
from calib.effects.effect import EFFECTS
from calib.fit.model import Model
from calib.poses.data_sheet import TriadSpec
from calib.poses.imu_log import SI_UNIT, FloatArray
from calib.poses.pose_set import PoseSet
from calib.poses.reference import Reference
from calib.poses.triad_kind import TRIAD_KINDS, TriadKind

FIELD_T, NOISE_T = 48e-6, 20e-9
GAIN, BIAS_T = np.array([1.01, 0.98, 1.015]), np.array([2e-6, -1e-6, 3e-6])
PER_KELVIN = np.array([30e-9, -20e-9, 40e-9])
SHEET = TriadSpec(1e-4, 16, "twos-complement")


@pytest.fixture
def fluxgate() -> Iterator[str]:
    """Three axes against the field of the Earth, in a place where it is known."""
    kind = TriadKind("fluxgate", "fluxgate", "T", "nT", 1e9, "the field of the Earth",
                     ("flux_x", "flux_y", "flux_z"), ("ut",), "field_ut")
    TRIAD_KINDS[kind.name] = kind
    yield kind.name
    del TRIAD_KINDS[kind.name]


def poses_of(triad: str, per_kelvin: FloatArray, n: int = 26) -> PoseSet:
    """Directions at random, a temperature that is no clock."""
    random = np.random.default_rng(1)
    directions = random.normal(size=(n, 3))
    field = FIELD_T * directions / np.linalg.norm(directions, axis=1, keepdims=True)
    temperature = 25 + 10 * np.sin(np.arange(n))
    reading = GAIN * field + BIAS_T + per_kelvin * (temperature - 25)[:, None]
    unlogged = np.full((n, 3), np.nan)
    return PoseSet(
        triad=triad,  # type: ignore[arg-type]
        label=tuple(f"pose {i}" for i in range(n)), run=("field",) * n,
        reading=reading + NOISE_T * random.normal(size=(n, 3)), sd=np.full((n, 3), NOISE_T),
        force=unlogged, vibration=unlogged, spin_rad_s=np.zeros(n), time_s=30.0 * np.arange(n),
        expected=np.zeros((n, 3)), columns={"temperature_c": temperature},
        reference=Reference(np.full(n, FIELD_T), np.zeros(n), np.full((n, 1), 1e-9), ("field",)))


def test_it_is_calibrated_and_the_prediction_is_in_its_unit(fluxgate: str) -> None:
    found = assess(poses_of(fluxgate, np.zeros(3)), Model.of(BASE), SHEET)
    assert found.diagnosis.verdict is Code.NOTHING_MISSING
    slices = found.calibration.fit.model.slices()
    off = found.calibration.fit.theta[slices["bias"]] - BIAS_T / GAIN
    sd = np.sqrt(np.diag(found.calibration.fit.cov))[slices["bias"]]
    assert np.abs(off / sd).max() < 4
    assert found.prediction is not None
    assert found.prediction.by_poses < 3 * NOISE_T


def test_a_missing_effect_is_named_in_its_unit_and_the_error_falls(fluxgate: str) -> None:
    poses = poses_of(fluxgate, PER_KELVIN)
    before = assess(poses, Model.of(BASE), SHEET)
    assert before.diagnosis.name == "temperature_bias"
    assert "nT per K" in before.diagnosis.text
    after = assess(poses, Model.of((*BASE, "temperature_bias")), SHEET)
    assert after.diagnosis.verdict is Code.NOTHING_MISSING
    assert after.comparison.loo_rms < 0.2 * before.comparison.loo_rms
    added = after.calibration.fit.theta[after.calibration.fit.model.slices()["temperature_bias"]]
    assert added == pytest.approx(PER_KELVIN, abs=4e-9)


def test_effects_of_no_triad_in_particular_are_its_own_too(fluxgate: str) -> None:
    assert fluxgate in EFFECTS["quadratic"].triads
    assert fluxgate not in EFFECTS["g_sensitivity"].triads
    assert EFFECTS["temperature_bias"].unit_for(fluxgate) == "T/K"
    assert SI_UNIT[fluxgate] == "T"
