"""The one minimiser: exact derivatives, the minimum that SciPy finds, warm starts and cold ones."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from scipy.optimize import least_squares

from calib.effects.catalogue import BASE, find_effect
from calib.effects.expression import read_expression
from calib.effects.user_defined import shape_between, user_effect
from calib.fit.least_squares.gauss_newton import minimise
from calib.fit.least_squares.solver import extend, fit
from calib.fit.model import Model
from calib.fit.rows.problem import Estimate, Problem
from calib.fit.rows.residuals import Equations
from calib.poses.imu_log import FloatArray
from calib.poses.pose_set import PoseSet
from tests.trials import DESIGNS, drawn, poses_of

SHAPED = {"warm_up": 450.0, "hysteresis": 0.3}
"""Effects with a shape parameter, and a value of it that many rows feel."""


@cache
def poses_with(name: str, seed: int = 5) -> PoseSet:
    design = DESIGNS["rich"]()
    hidden = drawn(name, "gyroscope", 20.0, design, seed)
    assert hidden is not None
    return poses_of(design, seed, "gyroscope", [hidden])


@pytest.mark.parametrize("name", SHAPED)
def test_derivatives_by_a_shape_are_those_of_the_rows(name: str) -> None:
    found = fit(poses_with(name), Model.of((*BASE, "quadratic", name)))
    value, step = SHAPED[name], 1e-4
    at = Estimate.of(found.equations, found.theta, found.eta, {name: value})

    def residual(theta: FloatArray, log_change: float) -> FloatArray:
        shapes = {name: float(value * np.exp(log_change))}
        return found.equations.rows(theta, found.eta, shapes).residual

    exact = at.shape_derivatives(found.equations, (name,))
    up, middle, down = (residual(found.theta, h) for h in (step, 0.0, -step))
    slope, curvature = (up - down) / (2 * step), (up + down - 2 * middle) / step**2
    scale = np.abs(slope).max()
    assert scale > 0.1
    assert np.allclose(exact.slope[:, 0], slope, atol=1e-4 * scale)
    assert np.allclose(exact.curvature[:, 0], curvature, atol=0.02 * np.abs(curvature).max())
    k = found.model.slices()[name].start
    size = 0.1 * float(np.abs(found.theta[k]))
    moved = found.theta + size * np.eye(len(found.theta))[k]
    mixed = ((residual(moved, step) - residual(moved, -step)) / (2 * step) - slope) / size
    assert np.allclose(exact.mixed[:, k, 0], mixed, atol=0.02 * np.abs(mixed).max())


@pytest.mark.parametrize("name", ["quadratic", "warm_up"])
def test_scipy_ends_at_the_same_minimum(name: str) -> None:
    found = fit(poses_with(name), Model.of((*BASE, name)))
    equations, p = found.equations, found.model.size
    problem = Problem.of(equations.take(None), found.basis[None])
    directions = problem.directions[0]
    v, h = directions.shape[1], len(problem.free)

    def residual(x: FloatArray) -> FloatArray:
        step = directions @ x[:v]
        shapes = {n: float(found.shapes[n] * np.exp(c))
                  for n, c in zip(problem.free, x[v:], strict=True)}
        return equations.rows(found.theta + step[:p], found.eta + step[p:], shapes).residual

    start = np.concatenate([np.zeros(v), np.full(h, 0.2)])
    reached = least_squares(residual, start, x_scale="jac", xtol=1e-14, ftol=1e-14, gtol=1e-12)
    assert 2 * reached.cost == pytest.approx(found.chi2, abs=1e-4)  # by differences


@pytest.mark.parametrize("names", [("quadratic",), ("warm_up",), ("quadratic", "g_sensitivity")])
def test_a_warm_start_ends_where_a_cold_one_does(names: tuple[str, ...]) -> None:
    poses = poses_with(names[0])
    warm = extend(fit(poses, Model.of(BASE)), [find_effect(name) for name in names])
    cold = fit(poses, Model.of((*BASE, *names)))
    assert warm.model.names == cold.model.names
    assert warm.chi2 == pytest.approx(cold.chi2, abs=1e-3)
    assert np.allclose(warm.theta[3:], cold.theta[3:], atol=1e-2 * np.sqrt(np.diag(cold.cov)).max())


def test_a_valley_too_curved_for_straight_steps_is_followed() -> None:
    """From a time constant far too short, at which the amplitude is off by orders of magnitude."""
    poses = poses_with("warm_up")
    model = Model.of((*BASE, "warm_up"))
    best = fit(poses, model)
    equations = Equations.of_sets((poses,), model)
    problem = Problem.of(equations, best.basis[None])
    shapes = {"warm_up": np.array([40.0])}
    far = Estimate.of(equations, best.theta[None], best.eta[None], shapes)
    assert minimise(problem, far).cost[0] == pytest.approx(best.chi2, rel=1e-6)


def test_the_shape_of_an_effect_on_the_reference_is_fitted() -> None:
    """A rate that settles: the plate's belt warms up."""
    poses = poses_with("quadratic")
    tau_s, size = 400.0, 2e-3
    turning = ~poses.reference.is_null
    error = size * np.exp(-poses.time_s / tau_s) * poses.reference.magnitude
    slower = np.where(turning, 1 + error / np.maximum(poses.reference.magnitude, 1e-300), 1.0)
    settled = replace(poses, reading=poses.reading * slower[:, None])
    belt = user_effect(
        "belt", read_expression("magnitude * exp(-time_s / tau)", ("tau",)), "reference", "1",
        "gyroscope", shape_between("tau", "s", 50.0, 5000.0),
    )
    found = fit(settled, Model.of((*BASE, "quadratic")) + belt)
    assert found.shapes["belt"] == pytest.approx(tau_s, abs=4 * found.shape_sd["belt"])
    assert found.shape_sd["belt"] < 0.2 * tau_s
