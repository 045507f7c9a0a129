"""Model beside measurements: leave-one-out in closed form, and which pose is worst."""

from dataclasses import replace

import numpy as np
import pytest

from calib.effects.catalogue import BASE
from calib.fit.least_squares.solver import fit
from calib.fit.model import Model
from calib.fit.rows.residuals import Equations
from calib.fit.triad.calibration import calibrate_triad
from calib.fit.validation.leave_one_out import LARGEST_LEVERAGE, compare, left_out_residual
from calib.poses.pose_set import PoseSet
from tests.calib.made_poses import (
    FAST,
    SLOW,
    SPECS,
    base_theta,
    chosen,
    made_poses,
    noisy,
    read_through,
    with_noise,
)

MODEL = Model.of(BASE)


@pytest.mark.parametrize("pose", [0, 9, 20, 40])
def test_leaving_one_out_in_closed_form_is_refitting_without_it(pose: int) -> None:
    """Magnitude rows and the three rows of a pose at rest alike."""
    read = noisy(made_poses("gyroscope", (SLOW, FAST, 0.0), shared_sd=1e-4), 3)
    compared = compare(fit(read, MODEL)).poses[pose]
    rest = [i for i in range(len(read)) if i != pose]
    without = fit(chosen(read, rest), MODEL)
    rows = Equations.of(read, MODEL).rows(without.theta, without.eta, {})
    equations = Equations.of(read, MODEL)
    mine = equations.row_pose == pose
    left_out = (rows.residual[: equations.data_count] * equations.row_sd)[mine]
    if read.reference.is_null[pose]:
        assert compared.left_out == pytest.approx(np.linalg.norm(left_out), rel=2e-3)
    else:
        assert compared.left_out == pytest.approx(left_out[0], rel=5e-3, abs=1e-8)


def test_the_pose_that_was_spoilt_is_the_worst() -> None:
    read = noisy(made_poses("gyroscope", (SLOW, -SLOW)), 5)
    reading = read.reading.copy()
    reading[11] *= 1.01
    worst = compare(fit(replace(read, reading=reading), MODEL)).worst(1)[0]
    assert worst.label == "pose 12"
    assert worst.in_sd > 10
    assert worst.left_out > worst.residual


def test_the_root_mean_squares_are_those_of_the_rows() -> None:
    found = fit(noisy(made_poses("gyroscope", (SLOW, 0.0)), 6), MODEL)
    compared = compare(found)
    assert compared.residual_rms == pytest.approx(np.sqrt(np.mean(found.residual_si**2)))
    assert compared.loo_rms > compared.residual_rms
    assert len(compared.poses) == 36
    signed = [pose.residual for pose in compared.poses[:18]]
    assert min(signed) < 0 < max(signed)
    lengths = [pose.residual for pose in compared.poses[18:]]
    assert min(lengths) > 0


def spoilt(pose: int, factor: float) -> PoseSet:
    """Eighteen wedge poses under gravity, one of them off by ``factor``."""
    read = noisy(made_poses("accelerometer", (0.0,)), 4)
    reading = read.reading.copy()
    reading[pose] *= factor
    return replace(read, reading=reading)


@pytest.mark.parametrize("robust", [False, True])
@pytest.mark.parametrize("pose", [2, 11])
def test_the_error_of_a_spoilt_pose_is_that_of_a_refit_without_it(robust: bool, pose: int) -> None:
    """A tenth of gravity off in one of eighteen poses, far from where the fit is linear.

    The weights of a robust loss are held, which moves a sound pose by a part of its sd.
    """
    read = spoilt(pose, 0.9)
    fitted = fit(read, MODEL, robust=robust)
    compared = compare(fitted)
    for k in (pose, 5):
        rest = [i for i in range(len(read)) if i != k]
        without = fit(read.take(rest), MODEL, robust=robust)
        rows = fitted.equations.rows(without.theta, without.eta, {})
        expected = rows.residual[k] * fitted.equations.row_sd[k]
        within = compared.poses[k].sd / 2 if robust else 1e-4
        assert compared.poses[k].left_out == pytest.approx(expected, rel=2e-3, abs=within)
    assert compared.poses[pose].left_out == pytest.approx(-0.98, abs=0.05)  # what was done to it


def test_a_pose_through_which_the_fit_passes_keeps_the_closed_form() -> None:
    """One of ten poses holds a parameter up: a refit without it crawls along a valley."""
    read = read_through(made_poses("accelerometer", (0.0,), jitter_deg=4.0), MODEL,
                        base_theta(MODEL, "accelerometer"))
    fitted = fit(noisy(chosen(read, list(range(8, 18))), 2), MODEL)
    rows, jacobian = fitted.rows.residual, fitted.weighted_jacobian
    closed = left_out_residual(rows, jacobian, fitted.equations.row_pose)
    leverage = 1 - rows[: len(closed)] / closed
    pose = int(leverage.argmax())
    assert leverage[pose] == pytest.approx(LARGEST_LEVERAGE)  # the most that counts
    left_out = compare(fitted).poses[pose].left_out
    assert left_out == pytest.approx(closed[pose] * fitted.equations.row_sd[pose], rel=1e-9)


@pytest.mark.parametrize("bad_poses", [0, 1])
def test_huber_s_sds_hold_with_and_without_a_bad_pose(bad_poses: int) -> None:
    """30 draws of 18 poses; the bad one by 8 to 30 sds, anywhere."""
    truth = base_theta(MODEL, "accelerometer")
    scores, widenings = [], []
    for seed in range(30):
        rng = np.random.default_rng([seed, 9])
        poses = read_through(made_poses("accelerometer", (0.0,), seed=seed), MODEL, truth)
        read = with_noise(poses, rng)
        reading = read.reading.copy()
        for k in rng.permutation(18)[:bad_poses]:
            off = rng.choice([-1, 1]) * rng.uniform(8, 30) * read.sd[k, 0]
            reading[k] *= 1 + off / np.linalg.norm(reading[k])
        fitted = fit(replace(read, reading=reading), MODEL, robust=True)
        calibration = calibrate_triad(fitted, SPECS["accelerometer"])
        widenings.append(calibration.widening)
        scores.append((fitted.theta - truth) / np.sqrt(np.diag(calibration.fit.cov)))
    covered = np.mean(np.abs(scores) < 1.96)
    assert 0.90 < covered < 0.985
    assert np.median(widenings) < 1.3


def few_poses(seed: int) -> PoseSet:
    """Fourteen of the wedge poses in which nothing is missing."""
    read = read_through(made_poses("accelerometer", (0.0,), jitter_deg=8.0), MODEL,
                        base_theta(MODEL, "accelerometer"))
    return noisy(chosen(read, list(range(1, 15))), seed)


def test_the_leave_one_out_error_of_few_sound_poses_is_what_noise_makes_of_it() -> None:
    compared = [compare(fit(few_poses(seed), MODEL)) for seed in range(60)]
    square = np.mean([each.loo_rms**2 for each in compared])
    by_noise = np.mean([each.loo_noise**2 for each in compared])
    assert square == pytest.approx(by_noise, rel=0.4)
    assert by_noise > 9 * np.mean([each.residual_rms**2 for each in compared])


def test_of_few_poses_what_is_not_there_lowers_the_error_but_predicts_no_better() -> None:
    """The leave-one-out error rests on the pose that holds a parameter up."""
    names = ("temperature_bias", "temperature_scale", "bias_drift", "scale_drift")
    lower, better = 0, 0
    for seed in range(24):
        base = fit(few_poses(seed), MODEL)
        before = compare(base)
        after = [compare(fit(base.poses, Model.of((*BASE, name)))) for name in names]
        lower += any(each.loo_rms < 0.8 * before.loo_rms for each in after)
        better += any(each.predicts_better_than(before) for each in after)
    assert lower >= 5
    assert better <= 2


def test_an_effect_that_is_there_predicts_better_in_few_poses_too() -> None:
    better = 0
    for seed in range(10):
        poses = few_poses(seed)
        warm = poses.columns["temperature_c"][:, None] - 30
        spoilt_by_it = replace(poses, reading=poses.reading + warm * [0.004, -0.003, 0.005])
        base = fit(spoilt_by_it, MODEL)
        with_it = fit(spoilt_by_it, Model.of((*BASE, "temperature_bias")))
        better += compare(with_it).predicts_better_than(compare(base))
    assert better >= 6
