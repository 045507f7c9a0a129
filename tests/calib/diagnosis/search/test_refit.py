"""The joint refits: they end at the minimum, and the evidence asked for there is the same."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from scipy.optimize import minimize_scalar

from calib.diagnosis.diagnose import diagnose
from calib.diagnosis.hypotheses.listed import listed_hypotheses
from calib.diagnosis.search.refit import refit
from calib.diagnosis.search.search import search
from calib.diagnosis.search.table_at import table_at
from calib.effects.catalogue import BASE, find_effect
from calib.fit.least_squares.solver import fit
from calib.fit.model import Model
from calib.fit.triad.calibration import covariance_with_misfit
from calib.poses.pose_set import PoseSet
from tests.trials import DESIGNS, drawn, poses_of


@cache
def session(name: str, size: float, design: str = "paper", seed: int = 41) -> PoseSet:
    """The gyro's poses of one evening that hides ``name``."""
    made = DESIGNS[design]()
    hidden = drawn(name, "gyroscope", size, made, seed)
    assert hidden is not None
    return poses_of(made, seed, "gyroscope", [hidden])


@pytest.mark.parametrize(("design", "size"), [("paper", 5.0), ("rich", 5.0), ("rich", 30.0)])
def test_the_time_constant_is_where_the_profile_of_chi_square_is_lowest(
    design: str, size: float
) -> None:
    poses = session("warm_up", size, design, seed=43)
    found = fit(poses, Model.of((*BASE, "warm_up")))
    warm_up = find_effect("warm_up")

    def profile(log_tau: float) -> float:
        tau = float(np.exp(log_tau))
        held = replace(warm_up, columns=lambda at: warm_up.evaluate(at, tau), shape=None)
        return fit(poses, Model.of(BASE) + held).chi2

    near = np.log(found.shapes["warm_up"])
    searched = minimize_scalar(profile, bounds=(near - 0.5, near + 0.5), method="bounded",
                               options={"xatol": 1e-6})
    assert near == pytest.approx(searched.x, abs=1e-3)
    assert found.chi2 <= searched.fun + 1e-6


def test_a_time_constant_begun_near_it_ends_at_the_same() -> None:
    poses, warm_up = session("warm_up", 5.0, "rich"), find_effect("warm_up")
    whole = fit(poses, Model.of(BASE) + warm_up)
    assert warm_up.shape is not None
    near_it = replace(warm_up, shape=replace(warm_up.shape, starts=(300.0,)))
    near = fit(poses, Model.of(BASE) + near_it)
    assert near.shapes["warm_up"] == pytest.approx(whole.shapes["warm_up"], rel=1e-5)


@pytest.mark.parametrize("seed", [43, 45, 48])
def test_what_a_pose_remembers_is_judged_at_the_solution(seed: int) -> None:
    """Near zero a bias that is off by the effect turns the sign of what the pose before felt."""
    poses = session("hysteresis", 10.0, seed=seed)
    found = fit(poses, Model.of((*BASE, "hysteresis")))
    assert found.chi2 / found.dof < 3
    remembered = np.sign(found.equations.at_start.previous)
    at_solution = np.sign(poses.conditions(poses.reading, found.sensed).previous)
    assert (remembered == at_solution).all()


def test_one_of_them_would_be_misled_by_the_start() -> None:
    """The negative control of the test above."""
    start = [
        fit(session("hysteresis", 10.0, seed=seed), Model.of(BASE)).equations.at_start.previous
        for seed in (43, 45, 48)
    ]
    solved = [
        fit(session("hysteresis", 10.0, seed=seed), Model.of((*BASE, "hysteresis")))
        for seed in (43, 45, 48)
    ]
    assert any(
        (np.sign(before) != np.sign(found.equations.at_start.previous)).any()
        for before, found in zip(start, solved, strict=True)
    )


@pytest.mark.parametrize("name", ["quadratic", "bias_drift", "reference_drift", "scale_drift"])
def test_for_an_effect_near_the_noise_the_refit_changes_no_evidence(name: str) -> None:
    """Linear there: the closed form at the base fit and at the joint refit are one."""
    base = fit(session(name, 3.0, "rich"), Model.of(BASE))
    listed, _ = listed_hypotheses(base)
    alone = [(j,) for j, h in enumerate(listed) if h.name == name]  # clips at one time, or each
    (at_refit,) = (e for e in search(base, listed).entries
                   if e.members in alone and e.refit is not None)
    (j,) = at_refit.members
    at_base = float(table_at(base, listed).batch([(j,)]).averaged()[0]) + listed[j].log_prior
    assert at_refit.log_posterior == pytest.approx(at_base, abs=0.4)


@pytest.mark.parametrize("names", [("quadratic",), ("bias_drift", "g_sensitivity"), ("warm_up",)])
def test_a_refit_from_where_the_base_stood_ends_at_the_same_minimum(names: tuple[str, ...]) -> None:
    base = fit(session(names[0], 10.0, "rich"), Model.of(BASE))
    effects = [find_effect(name) for name in names]
    joint = refit(base, effects)
    whole = fit(base.poses, Model.of((*BASE, *names)))
    assert joint is not None
    assert joint.fit.chi2 == pytest.approx(whole.chi2, abs=1e-3)
    assert joint.fit.rows.vector == pytest.approx(whole.rows.vector, rel=1e-5, abs=1e-6)
    assert joint.fit.theta[3:] == pytest.approx(whole.theta[3:], rel=2e-3, abs=1e-7)
    sd = np.sqrt(np.diag(whole.cov))  # but for the bias, of which the effect's mean is a part
    assert np.sqrt(np.diag(joint.fit.cov))[3:] == pytest.approx(sd[3:], rel=1e-2)


def test_what_the_poses_do_not_determine_is_no_refit() -> None:
    base = fit(session("quadratic", 5.0), Model.of(BASE))
    assert refit(base, [find_effect("quadratic"), find_effect("asymmetry")]) is None


def test_sizes_in_the_ranking_are_those_of_the_refit() -> None:
    poses = session("quadratic", 10.0, "rich")
    base = fit(poses, Model.of(BASE))
    (own,) = (c for c in diagnose(base).ranking if c.name == "quadratic")
    refit = fit(poses, Model.of((*BASE, "quadratic")))
    where = refit.model.slices()["quadratic"]
    assert own.size == pytest.approx(refit.theta[where], rel=1e-6)
    assert own.chi2_drop == pytest.approx(base.chi2 - refit.chi2, rel=1e-6)
    assert own.rms_after == pytest.approx(refit.residual_rms, rel=1e-6)


def test_sds_in_the_ranking_hold_the_misfit_that_is_left_as_those_of_a_calibration_do() -> None:
    poses = session("quadratic", 10.0, "rich")
    poses = replace(poses, sd=poses.sd / 2)
    (own,) = (c for c in diagnose(fit(poses, Model.of(BASE))).ranking if c.name == "quadratic")
    refit = fit(poses, Model.of((*BASE, "quadratic")))
    where = refit.model.slices()["quadratic"]
    sd = np.sqrt(np.diag(covariance_with_misfit(refit))[where])
    assert own.sd == pytest.approx(sd, rel=1e-3)
    assert (sd > 1.5 * np.sqrt(np.diag(refit.cov)[where])).all()
