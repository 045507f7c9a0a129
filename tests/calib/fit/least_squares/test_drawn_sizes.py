"""Sizes of what is drawn anew with every pose come back, and the sds of the parameters hold."""

from dataclasses import replace

import numpy as np
import pytest

from calib.effects.catalogue import BASE
from calib.errors import FitFailed, Remedy, Undetermined
from calib.fit.least_squares.result import Fit
from calib.fit.least_squares.solver import fit
from calib.fit.model import Model
from calib.fit.validation.leave_one_out import compare
from calib.poses.pose_set import PoseSet
from tests.calib.made_poses import SD, base_theta, noisy, rich_poses, walk, with_noise


def drawn(name: str, poses: PoseSet, seed: int) -> tuple[PoseSet, float]:
    """``poses`` with a draw of what ``name`` is, and its size."""
    random, sd = np.random.default_rng([seed, 9]), SD[poses.triad]
    if name == "extra_noise":
        return replace(poses, reading=poses.reading + 3 * poses.sd * random.normal(
            size=poses.sd.shape)), 3.0
    if name == "pose_scatter":
        return replace(poses, reading=poses.reading + 3 * sd * random.normal(
            size=poses.sd.shape)), 3 * sd
    if name == "rate_scatter":
        return replace(poses, reading=poses.reading * (1 + 2e-3 * random.normal(
            size=(len(poses), 1)))), 2e-3
    return replace(poses, reading=poses.reading + 5 * sd * walk(poses.time_s, random)), 5 * sd


def fitted(name: str, seed: int) -> tuple[Fit, Fit, float]:
    """The fits without and with what is drawn, and its true size."""
    poses, size = drawn(name, noisy(rich_poses("gyroscope", seed), seed), seed)
    return fit(poses, Model.of(BASE)), fit(poses, Model.of((*BASE, name))), size


@pytest.mark.parametrize("name", ["extra_noise", "pose_scatter", "rate_scatter", "bias_wander"])
def test_its_size_comes_back_within_its_sd_and_explains_the_rows(name: str) -> None:
    scores = []
    for seed in range(6):
        before, after, size = fitted(name, seed)
        where = after.model.slices()[name].start
        scores.append((after.theta[where] - size) / np.sqrt(after.cov[where, where]))
        assert before.p_value < 1e-6
        assert after.p_value > 1e-3
        assert after.dof == before.dof
    assert np.sqrt(np.mean(np.square(scores))) < 1.8, scores


def test_a_wander_in_the_model_predicts_poses_that_took_no_part_better() -> None:
    for seed in range(3):
        before, after, _ = fitted("bias_wander", seed)
        assert compare(after).loo_rms < 0.8 * compare(before).loo_rms


def test_the_parameters_beside_it_err_as_their_sds_say() -> None:
    scores = []
    for seed in range(8):
        _, after, _ = fitted("bias_wander", seed)
        off = after.theta[3:9] - base_theta(after.model, "gyroscope")[3:9]
        scores.append(off / np.sqrt(np.diag(after.cov)[3:9]))
    assert 0.75 < np.sqrt(np.mean(np.square(scores))) < 1.3


def test_of_nothing_the_size_is_none_and_the_fit_is_as_without() -> None:
    poses = noisy(rich_poses("gyroscope", 0), 0)
    before, after = fit(poses, Model.of(BASE)), fit(poses, Model.of((*BASE, "pose_scatter")))
    size, sd = after.theta[9], np.sqrt(after.cov[9, 9])
    assert size < 2 * sd < SD["gyroscope"]
    assert after.theta[:9] == pytest.approx(before.theta, rel=1e-3, abs=1e-6)


def test_two_that_are_drawn_are_told_apart_where_the_poses_differ_in_length() -> None:
    """Half of the poses ten times as long: scatter of the lays stays, noise goes."""
    made = rich_poses("gyroscope", 3)
    long = np.where(np.arange(len(made)) % 2, 1.0, 1 / np.sqrt(10))[:, None]
    made = with_noise(replace(made, sd=made.sd * long), np.random.default_rng(4))
    poses, size = drawn("pose_scatter", made, 3)
    both = fit(poses, Model.of((*BASE, "pose_scatter", "extra_noise")))
    scatter, noise = both.theta[9:11]
    assert scatter == pytest.approx(size, rel=0.2)
    assert noise < 2 * np.sqrt(both.cov[10, 10])


def test_a_wander_without_a_clock_is_refused() -> None:
    poses = replace(rich_poses("gyroscope", 0), time_s=np.full(130, np.nan))
    with pytest.raises(Undetermined, match="'bias_wander' cannot be evaluated: the logs' clocks"):
        fit(poses, Model.of((*BASE, "bias_wander")))


def test_a_scatter_of_the_rate_that_took_the_gains_along_is_the_cause_that_is_named() -> None:
    """The references of an error that follows gravity are sound: the effect that was added is not.
    """
    true = rich_poses("gyroscope", 0)
    error = true.force @ np.random.default_rng(0).normal(size=(3, 3)).T
    poses = noisy(replace(true, reading=true.reading + 100 * SD["gyroscope"] * error / error.std()),
                  0)
    assert fit(poses, Model.of(BASE)).chi2 > 0
    with pytest.raises(FitFailed, match=r"or on its scatter, has taken the gains along") as failed:
        fit(poses, Model.of((*BASE, "rate_scatter")))
    assert failed.value.remedy == Remedy("remove_effect", "gyroscope")


@pytest.mark.parametrize(("name", "further"), [
    ("pose_scatter", ()), ("pose_scatter", ("reference_drift",)),
    ("bias_wander", ("reference_drift",)),
])
def test_a_second_fit_of_widened_poses_widens_them_once(
    name: str, further: tuple[str, ...]
) -> None:
    poses, _ = drawn(name, noisy(rich_poses("gyroscope", 1), 1), 1)
    after = fit(poses, Model.of((*BASE, name, *further)))
    again = fit(after.poses, after.model)
    assert again.theta[9] == pytest.approx(after.theta[9], rel=1e-2)
    assert again.poses.reference.common_names == after.poses.reference.common_names
