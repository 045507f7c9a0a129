"""What a calibration says it will err by, held against what it errs by, by direction."""

from dataclasses import replace

import numpy as np
import pytest

from calib.effects.catalogue import BASE
from calib.fit.least_squares.solver import fit
from calib.fit.model import Model
from calib.fit.triad.calibration import calibrate_triad
from calib.fit.validation.prediction import gradient_of, other_logs, predict
from calib.fit.validation.weak_directions import variances_along
from calib.poses.attitudes import spread_directions
from calib.poses.imu_log import TEMPERATURE, Triad
from tests.calib.made_poses import (
    GRAVITY,
    MODEL,
    SLOW,
    SPECS,
    base_theta,
    linear_form,
    made_poses,
    noisy,
)
from tests.fitting import pose_sets
from tests.world.designs import paper_design
from tests.world.imu import mpu6050
from tests.world.plate import PlateMotion
from tests.world.session import simulate


def errors(triad: Triad, seed: int, lost: bool, directions: np.ndarray) -> tuple[np.ndarray, float]:
    """Errors of the next magnitudes in ``directions`` (n,), and the sd that was stated for them."""
    poses = noisy(made_poses(triad, (SLOW,), seed=seed), seed)
    if lost:
        up = poses.force[:, 1] / GRAVITY
        poses = poses.take(np.flatnonzero(up < 0.5))
    calibration = calibrate_triad(fit(poses, MODEL), SPECS[triad])
    size = GRAVITY if triad == "accelerometer" else SLOW
    matrix, offset = linear_form(MODEL, base_theta(MODEL, triad))
    readings = np.linalg.solve(matrix, (size * directions - offset).T).T
    at = poses.take(np.zeros(len(readings), int)).conditions(readings)
    stated = predict(calibration)
    assert stated is not None
    return np.linalg.norm(calibration.correct(at), axis=1) - size, stated.sd_median


@pytest.mark.parametrize("triad", ["accelerometer", "gyroscope"])
@pytest.mark.parametrize("lost", [False, True])
def test_the_stated_sd_is_that_of_the_next_log(triad: Triad, lost: bool) -> None:
    directions = spread_directions(60)
    sessions = [errors(triad, seed, lost, directions) for seed in range(40)]
    rms = np.sqrt(np.mean([error**2 for error, _ in sessions], axis=0))
    stated = float(np.mean([sd for _, sd in sessions]))
    assert np.median(rms) == pytest.approx(stated, rel=0.15)


def test_a_lost_face_is_the_worst_direction_and_is_not_good() -> None:
    whole = noisy(made_poses("accelerometer", (0.0,)), 1)
    up = whole.force / GRAVITY
    one_sided = whole.take(np.flatnonzero(up[:, 1] < 0.5))
    full, lost = (
        predict(calibrate_triad(fit(poses, MODEL), SPECS["accelerometer"]))
        for poses in (whole, one_sided)
    )
    assert full is not None
    assert lost is not None
    assert full.holds_everywhere
    assert not lost.holds_everywhere
    assert lost.worst_direction[1] > 0.8
    assert lost.sd_worst > 2 * full.sd_worst


def test_a_common_error_counts_in_full_and_spoils_no_direction() -> None:
    poses = noisy(made_poses("gyroscope", (SLOW,), shared_sd=1e-2), 2)
    stated = predict(calibrate_triad(fit(poses, MODEL), SPECS["gyroscope"]))
    assert stated is not None
    assert stated.sd_median == pytest.approx(1e-2 * SLOW, rel=0.05)
    assert stated.holds_everywhere


def test_poses_at_rest_beside_a_rate_that_is_hardly_known_spoil_no_direction_either() -> None:
    """They show the scale by Earth's rotation, a little; a pose more on the plate mends nothing."""
    design = paper_design(mpu6050().with_noise(0.1), PlateMotion(2 * SLOW))
    design = replace(design, rests_count_for_gyroscope=True, rate_sd_relative=3e-3,
                     sample_rate_hz=25.0)
    _, poses, specs = pose_sets(simulate(design, 1))
    stated = predict(calibrate_triad(fit(poses, MODEL), specs[1]))
    assert stated is not None
    assert stated.sd_median == pytest.approx(3e-3 * 2 * SLOW, rel=0.05)
    assert stated.holds_everywhere
    assert stated.wanted == ()


def test_added_effects_enlarge_it() -> None:
    poses = noisy(made_poses("gyroscope", (SLOW, 2 * SLOW, 0.0)), 3)
    bare, more = (
        predict(calibrate_triad(fit(poses, Model.of(names)), SPECS["gyroscope"]))
        for names in (BASE, (*BASE, "quadratic"))
    )
    assert bare is not None
    assert more is not None
    assert more.sd_median > bare.sd_median


def test_where_only_rest_was_measured_there_is_none() -> None:
    poses = noisy(made_poses("gyroscope", (0.0,)), 4, Model.of(["bias"]))
    found = fit(poses, Model.of(["bias"]))
    assert predict(calibrate_triad(found, SPECS["gyroscope"])) is None


def test_gravity_of_the_next_log_points_anywhere_also_where_the_model_has_its_effect() -> None:
    poses = noisy(made_poses("gyroscope", (SLOW, 2 * SLOW)), 5)
    calibration = calibrate_triad(fit(poses, Model.of((*BASE, "g_sensitivity"))),
                                  SPECS["gyroscope"])
    stated = predict(calibration)
    assert stated is not None
    where = calibration.fit.model.slices()["g_sensitivity"]
    elements = GRAVITY * np.sqrt(np.diag(calibration.fit.cov)[where])
    assert stated.sd_median > 0.5 * np.sqrt(np.mean(elements**2))


def test_temperatures_of_another_log_count_as_by_the_exact_gradient() -> None:
    """Beside a strong nonlinearity; at the median temperature a coefficient adds nothing."""
    poses = made_poses("accelerometer", (0.0,), seed=2, jitter_deg=1.0)
    warmed = replace(poses, reading=poses.reading + 0.001 * poses.reading**2,
                     columns={TEMPERATURE: 20 + np.linspace(0, 8, len(poses))})
    fitted = fit(noisy(warmed, 2), Model.of((*BASE, "quadratic", "temperature_scale")))
    stated = predict(calibrate_triad(fitted, SPECS["accelerometer"]))
    assert stated is not None
    size, directions = stated.magnitude[0], stated.directions
    gradient = gradient_of(fitted, other_logs(fitted.poses, size * directions))
    cov = calibrate_triad(fitted, SPECS["accelerometer"]).fit.cov
    exact = variances_along(gradient.reshape(-1, *stated.gradient.shape[1:]), cov).mean(axis=0)
    assert stated.variance[0] == pytest.approx(exact, rel=0.02)
    assert exact.mean() > 1.2 * variances_along(stated.gradient, cov).mean()
