"""The fit: known answers, what its sds mean, and what it refuses."""

from dataclasses import replace

import numpy as np
import pytest

from calib.effects.catalogue import BASE
from calib.errors import Undetermined
from calib.fit.least_squares.angrisano import fit_paper
from calib.fit.least_squares.solver import Fit, fit
from calib.fit.least_squares.unknown_sd import with_estimated_sds
from calib.fit.model import Model
from calib.fit.triad.calibration import calibrate_triad
from calib.poses.imu_log import TRIADS, FloatArray, Triad
from calib.poses.pose_set import PoseSet
from tests.calib.made_poses import (
    FAST,
    GRAVITY,
    MODEL,
    SLOW,
    SPECS,
    STATED_SD,
    base_theta,
    chosen,
    made_poses,
    noisy,
    read_through,
    rich_poses,
    with_noise,
)
from tests.chance import spread_bounds


def in_sd(found: Fit, truth: FloatArray) -> FloatArray:
    """(estimate - truth) / sd of every parameter."""
    return np.asarray((found.theta - truth) / np.sqrt(np.diag(found.cov)))


# --- known answers -----------------------------------------------------------------------------


@pytest.mark.parametrize("triad", TRIADS)
@pytest.mark.parametrize("speeds", [(SLOW,), (SLOW, -SLOW), (SLOW, -FAST, 0.0)])
def test_noise_free_poses_give_the_parameters_back(triad: Triad, speeds: tuple[float, ...]) -> None:
    truth = base_theta(MODEL, triad)
    found = fit(read_through(made_poses(triad, speeds), MODEL, truth), MODEL)
    assert found.theta == pytest.approx(truth, abs=1e-11)
    assert found.chi2 < 1e-12


@pytest.mark.parametrize("triad", TRIADS)
def test_a_unit_far_from_its_data_sheet_needs_no_start_from_the_user(triad: Triad) -> None:
    truth = base_theta(MODEL, triad)
    truth[:3] *= 30
    truth[3:6] = 0.3, -0.25, 0.2
    found = fit(read_through(made_poses(triad, (SLOW,)), MODEL, truth), MODEL)
    assert found.theta == pytest.approx(truth, abs=1e-9)


def test_both_solvers_agree_to_1e_9_of_a_sd_with_several_runs_and_common_errors() -> None:
    poses = made_poses("gyroscope", (SLOW, -SLOW, FAST, 0.0), shared_sd=STATED_SD)
    for seed in range(4):
        read = noisy(poses, seed)
        spec = SPECS["gyroscope"]
        default = calibrate_triad(fit(read, MODEL), spec)
        paper = calibrate_triad(fit_paper(read, MODEL, spec), spec)
        for name in ("misalignment_rad", "bias_counts", "scale_counts_per_unit"):
            one, other = (getattr(c.parameters, name) for c in (default, paper))
            assert one == pytest.approx(other, rel=1e-9, abs=1e-9 * np.abs(one).max())
        assert paper.fit.cov == pytest.approx(default.fit.cov, rel=1e-5, abs=1e-20)


def test_the_order_of_the_poses_does_not_matter() -> None:
    read = noisy(made_poses("gyroscope", (SLOW, 0.0)), 1)
    turned = chosen(read, np.arange(len(read))[::-1])
    assert fit(turned, MODEL).theta == pytest.approx(fit(read, MODEL).theta, abs=1e-12)


# --- honest sds --------------------------------------------------------------------------------


@pytest.mark.parametrize("triad", TRIADS)
def test_the_estimates_scatter_as_their_sds_say(triad: Triad) -> None:
    poses = made_poses(triad, (SLOW,), shared_sd=STATED_SD)
    truth = base_theta(MODEL, triad)
    z = np.array([in_sd(fit(noisy(poses, seed), MODEL), truth) for seed in range(80)])
    low, high = spread_bounds(len(z) - 1, chance=1e-3)
    assert ((low < z.std(axis=0, ddof=1)) & (z.std(axis=0, ddof=1) < high)).all()
    low, high = spread_bounds(z.size, chance=1e-3)
    assert low < np.sqrt((z**2).mean()) < high
    assert np.abs(z.mean(axis=0)).max() < 3.3 / np.sqrt(len(z))  # one in a thousand, per parameter


def test_sds_stated_half_as_large_are_found_out() -> None:
    """Negative control of the test above: wrong noise shows in the spread and in chi-square."""
    poses = made_poses("gyroscope", (SLOW,))
    truth = base_theta(MODEL, "gyroscope")
    z, chi2 = [], []
    for seed in range(60):
        read = noisy(poses, seed)
        found = fit(replace(read, sd=read.sd / 2), MODEL)
        z.append(in_sd(found, truth))
        chi2.append(found.chi2 / found.dof)
    assert np.std(z) == pytest.approx(2.0, abs=0.3)
    assert np.mean(chi2) == pytest.approx(4.0, abs=0.5)


def scale_sd(poses: PoseSet) -> FloatArray:
    found = fit(read_through(poses, MODEL, base_theta(MODEL, poses.triad)), MODEL)
    return np.asarray(np.sqrt(np.diag(found.cov))[3:6])


def test_the_sd_of_a_shared_rate_does_not_average_down() -> None:
    one = made_poses("gyroscope", (SLOW,), shared_sd=1e-3)
    ten = replace(chosen(one, list(range(18)) * 10))
    own_one = scale_sd(made_poses("gyroscope", (SLOW,)))
    own_ten = scale_sd(chosen(made_poses("gyroscope", (SLOW,)), list(range(18)) * 10))
    assert own_ten == pytest.approx(own_one / np.sqrt(10), rel=1e-6)
    assert scale_sd(ten) ** 2 == pytest.approx(own_ten**2 + 1e-6, rel=0.05)
    assert (scale_sd(ten) > 0.97e-3).all()


def test_weights_are_right_although_the_data_sheet_is_a_third_off() -> None:
    """Sds are known in nominal units; the same noise must weigh the same in true units."""
    poses = noisy(made_poses("gyroscope", (SLOW,), shared_sd=STATED_SD), 3)
    off = replace(poses, reading=1.3 * poses.reading, sd=1.3 * poses.sd)
    right, wrong = fit(poses, MODEL), fit(off, MODEL)
    assert wrong.chi2 == pytest.approx(right.chi2, rel=1e-6)
    gain = (1 - right.theta[3:6]) / 1.3
    assert 1 - wrong.theta[3:6] == pytest.approx(gain, rel=1e-9)
    sd = np.sqrt(np.diag(right.cov))[3:6] / 1.3
    assert np.sqrt(np.diag(wrong.cov))[3:6] == pytest.approx(sd, rel=1e-6)


def test_noisier_poses_weigh_less() -> None:
    poses = made_poses("gyroscope", (SLOW, SLOW))
    sd = poses.sd * np.where(np.arange(36) < 18, 1.0, 10.0)[:, None]
    read = noisy(replace(poses, sd=sd), 4)
    good = chosen(read, list(range(18)))
    both, alone = fit(read, MODEL), fit(good, MODEL)
    moved = np.abs(both.theta - alone.theta) / np.sqrt(np.diag(alone.cov))
    assert moved.max() < 0.5
    assert (np.diag(both.cov) < np.diag(alone.cov)).all()


def test_poses_at_rest_pin_the_bias() -> None:
    turning = noisy(made_poses("gyroscope", (SLOW,)), 6)
    with_rest = noisy(made_poses("gyroscope", (SLOW, 0.0)), 6)
    sd = [np.sqrt(np.diag(fit(p, MODEL).cov))[:3] for p in (turning, with_rest)]
    at_rest = 3e-4 / np.sqrt(18)
    assert (sd[1] < 1.1 * at_rest).all()
    assert (sd[0] > 1.3 * sd[1]).all()


def test_the_noise_of_means_at_rest_alone_is_that_of_their_residuals() -> None:
    poses = noisy(made_poses("gyroscope", (0.0,)), 6)
    unknown = replace(poses, sd=np.full_like(poses.sd, np.nan))
    estimated = with_estimated_sds(unknown, Model.of(("bias",)))
    assert estimated.sd[0, 0] == pytest.approx(poses.sd[0, 0], rel=0.4)


def test_poses_at_rest_read_what_the_earth_turns() -> None:
    poses = made_poses("gyroscope", (SLOW, 0.0))
    earth = 5e-5 * poses.force / GRAVITY
    null = poses.reference.is_null[:, None]
    turns = replace(poses, reading=np.where(null, earth, poses.reading),
                    expected=np.where(null, earth, 0.0))
    truth = base_theta(MODEL, "gyroscope")
    assert fit(read_through(turns, MODEL, truth), MODEL).theta == pytest.approx(truth, abs=1e-12)
    blind = replace(turns, expected=np.zeros_like(earth))
    assert fit(read_through(blind, MODEL, truth), MODEL).chi2 > 0.1


# --- one bad pose ------------------------------------------------------------------------------


def test_the_robust_loss_hardly_feels_one_bad_pose() -> None:
    read = noisy(made_poses("gyroscope", (SLOW,)), 7)
    reading = read.reading.copy()
    reading[5] *= 1.03
    spoilt = replace(read, reading=reading)
    sd = np.sqrt(np.diag(fit(read, MODEL).cov))
    clean = fit(read, MODEL).theta
    plain = np.abs((fit(spoilt, MODEL).theta - clean) / sd).max()
    robust = fit(spoilt, MODEL, robust=True)
    assert plain > 40
    assert np.abs((robust.theta - clean) / sd).max() < 4
    assert np.argmin(robust.weight) == 5
    assert fit(read, MODEL).weight == pytest.approx(1.0)


# --- shape parameters --------------------------------------------------------------------------


def test_the_time_constant_of_a_warm_up_is_fitted_within_its_sd() -> None:
    model = Model.of((*BASE, "warm_up"))
    poses = rich_poses("gyroscope")
    truth = base_theta(model, "gyroscope")
    truth[9:] = 4e-3, -3e-3, 5e-3
    read = read_through(poses, model, truth, {"warm_up": 450.0})
    z = []
    for seed in range(12):
        found = fit(with_noise(read, np.random.default_rng([seed, 9])), model)
        z.append([(found.shapes["warm_up"] - 450.0) / found.shape_sd["warm_up"],
                  *in_sd(found, truth)[9:]])
        assert found.dof == found.equations.data_count - 13
    assert np.sqrt(np.mean(np.square(z))) == pytest.approx(1.0, abs=0.45)
    assert found.shape_sd["warm_up"] < 60


# --- refusals ----------------------------------------------------------------------------------


def test_eight_poses_are_refused() -> None:
    few = chosen(noisy(made_poses("accelerometer", (0.0,)), 1), list(range(8)))
    with pytest.raises(Undetermined, match=r"8 equations for 9 parameters.*poses lie within"):
        fit(few, MODEL)


def test_an_unknown_that_all_poses_have_in_common_takes_an_equation_too() -> None:
    """Ten poses on a leaning plate leave no degree of freedom: chi-square was divided by 0."""
    few = chosen(noisy(made_poses("accelerometer", (0.0,)), 1), list(range(10)))
    leaning = replace(few.reference, common=np.full((10, 1), 1e-3), common_names=("tilt of 33rpm",))
    with pytest.raises(Undetermined, match=r"1 that the poses have in common.*at least 11 are"):
        fit(replace(few, reference=leaning), MODEL)


def test_nine_poses_leave_nothing_to_check_with_and_are_refused() -> None:
    few = chosen(noisy(made_poses("accelerometer", (0.0,)), 1), list(range(9)))
    with pytest.raises(Undetermined, match="nothing to check the fit with; at least 10"):
        fit(few, MODEL)


def test_eighteen_copies_of_one_pose_are_refused() -> None:
    same = chosen(made_poses("accelerometer", (0.0,)), [3] * 18)
    rng = np.random.default_rng(0)
    with pytest.raises(Undetermined, match="do not determine"):
        fit(with_noise(same, rng), MODEL)


def test_poses_in_one_half_are_refused_and_the_missing_side_is_named() -> None:
    poses = noisy(made_poses("accelerometer", (0.0, 0.0, 0.0, 0.0)), 2)
    upper = np.flatnonzero(poses.reading[:, 2] > 4)
    with pytest.raises(Undetermined, match=r"do not determine .*z.*Add the others, first .*-z up"):
        fit(chosen(poses, upper), MODEL)


def test_poses_at_rest_alone_are_refused() -> None:
    rest = made_poses("gyroscope", (0.0,))
    with pytest.raises(Undetermined, match="Poses on the turning plate are missing"):
        fit(rest, MODEL)


def test_an_effect_that_no_length_shows_is_refused() -> None:
    """A rotation errs across the readings: what rounding leaves of it along them is no signal."""
    for triad in TRIADS:
        poses = noisy(made_poses(triad, (SLOW, FAST)), 1)
        with pytest.raises(Undetermined, match="cannot see 'frame_rotation'"):
            fit(poses, Model.of([*BASE, "frame_rotation"]))


def test_a_model_without_misalignment_is_fitted_as_such() -> None:
    model = Model.of(("bias", "scale"))
    truth = base_theta(model, "accelerometer")
    found = fit(read_through(made_poses("accelerometer", (0.0,)), model, truth), model)
    assert found.theta == pytest.approx(truth, abs=1e-10)
    parameters = calibrate_triad(found, SPECS["accelerometer"]).parameters
    assert np.isnan(parameters.sd[0]).all()
    assert parameters.misalignment_rad == pytest.approx(0, abs=0)


# --- columns whose zero means nothing ----------------------------------------------------------


@pytest.mark.parametrize(("mean", "spread"), [(5.0, 0.03), (1013.0, 4.0), (0.0, 1.0)])
def test_a_bias_follows_a_column_whatever_the_columns_zero(mean: float, spread: float) -> None:
    """A supply of 5 V that varies by 30 mV varies; six thousandths of its size are no blindness."""
    model = Model.of((*BASE, "column:logged"))
    poses = rich_poses("gyroscope")
    logged = mean + spread * np.random.default_rng(2).standard_normal(len(poses))
    poses = replace(poses, columns={**poses.columns, "logged": logged})
    truth = base_theta(model, "gyroscope")
    truth[9:] = np.array([1e-3, -2e-3, 5e-4]) / spread
    found = fit(read_through(poses, model, truth), model)
    assert found.theta[9:] == pytest.approx(truth[9:], rel=1e-6)
