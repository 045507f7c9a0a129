"""An effect that stands for another errs by what that one would have corrected in another log."""

from dataclasses import replace

import numpy as np
import pytest

from calib.assess import AssessedTriad, assess
from calib.effects.catalogue import BASE
from calib.fit.model import Model
from calib.poses.attitudes import spread_directions
from calib.poses.conditions import Conditions
from calib.poses.imu_log import TEMPERATURE, FloatArray
from tests.calib.made_poses import GRAVITY, SPECS, made_poses, with_noise

DRIFT = np.array([8e-5, -6e-5, 1e-4])  #: bias per second, m/s²/s


def warmed(temperature_c: FloatArray) -> AssessedTriad:
    """18 poses whose bias drifts with the clock, with ``temperature_bias`` in the model."""
    poses = made_poses("accelerometer", (0.0,), seed=3, jitter_deg=1.0)
    drifts = poses.reading + DRIFT * poses.time_s[:, None]
    poses = with_noise(replace(poses, reading=drifts, columns={TEMPERATURE: temperature_c}),
                       np.random.default_rng(3))
    return assess(poses, Model.of((*BASE, "temperature_bias")), SPECS["accelerometer"])


def test_temperature_that_stands_for_the_clock_errs_in_another_log_as_stated() -> None:
    clock = made_poses("accelerometer", (0.0,), seed=3).time_s
    found = warmed(22 + clock / 200)
    alike = found.diagnosis.stands_for["temperature_bias"]
    assert "bias_drift" in alike.names
    assert 0.3 < sum(alike.probability) < 1
    rng = np.random.default_rng(2)
    time_s, temperature_c = (rng.choice(values, 300) for values in (clock, 22 + clock / 200))
    true = GRAVITY * spread_directions(300)
    corrected = found.calibration.correct(Conditions.of_vectors(
        true + DRIFT * time_s[:, None], {TEMPERATURE: temperature_c}, time_s=time_s))
    off = np.sqrt(np.mean((np.linalg.norm(corrected, axis=1) - GRAVITY) ** 2))
    assert found.prediction is not None
    assert off > 3 * found.prediction.by_poses
    assert off / np.sqrt(np.mean(found.prediction.sd**2)) == pytest.approx(1.2, abs=0.4)


def test_an_effect_that_the_poses_tell_from_all_others_stands_for_none() -> None:
    poses = made_poses("accelerometer", (0.0,), seed=3, jitter_deg=1.0)
    temperature_c = 22 + 5 * np.sin(np.arange(len(poses)))
    bent = poses.reading + 0.01 * (temperature_c - 22)[:, None] * [1, -1, 1]
    poses = with_noise(replace(poses, reading=bent, columns={TEMPERATURE: temperature_c}),
                       np.random.default_rng(3))
    found = assess(poses, Model.of((*BASE, "temperature_bias")), SPECS["accelerometer"])
    assert not found.diagnosis.stands_for
    assert found.prediction is not None
    assert found.prediction.by_open < 0.1 * found.prediction.by_poses
