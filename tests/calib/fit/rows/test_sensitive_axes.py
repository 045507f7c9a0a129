"""Effects act on what the sensitive axes feel: judged on a simulated bench that bends those."""

from dataclasses import replace

import numpy as np
import pytest

from calib.effects.catalogue import BASE, find_effect
from calib.errors import FitFailed, Undetermined
from calib.fit.least_squares.solver import fit
from calib.fit.model import Model
from calib.fit.rows.residuals import Equations
from calib.fit.rows.sensitive_axes import ALIGNED, solve_sensor
from calib.poses.conditions import Conditions
from calib.poses.pose_set import PoseSet
from tests.calib.made_poses import GRAVITY, base_theta, made_poses, read_through, with_noise
from tests.calib.plate_poses import CHIP_M, on_the_plate
from tests.fitting import pose_sets
from tests.trials import DESIGNS, drawn
from tests.world.session import simulate


@pytest.fixture(scope="module", params=["quadratic", "asymmetry"])
def strong(request: pytest.FixtureRequest) -> tuple[str, list[PoseSet]]:
    """Accelerometers with an effect of 300 noise units, bent by the simulated world."""
    design = DESIGNS["soak"]()
    evenings = []
    for seed in (2, 3):
        hidden = drawn(request.param, "accelerometer", 300.0, design, seed)
        assert hidden is not None
        evenings.append(pose_sets(simulate(design, seed, (hidden,)))[0])
    return request.param, evenings


def test_at_300_noise_units_the_right_effect_leaves_noise(
    strong: tuple[str, list[PoseSet]],
) -> None:
    name, evenings = strong
    for poses in evenings:
        bare, right = fit(poses, Model.of(BASE)), fit(poses, Model.of((*BASE, name)))
        assert bare.chi2 / bare.dof > 1000
        assert right.chi2 / right.dof < 1.6


def test_on_orthogonal_axes_it_would_not(strong: tuple[str, list[PoseSet]]) -> None:
    """The negative control: the same columns without the turn back by the misalignment."""
    name, evenings = strong
    wrong = Model.of(BASE) + replace(find_effect(name), orthogonal=True)
    right = Model.of((*BASE, name))
    worse = [fit(poses, wrong).chi2 / fit(poses, right).chi2 for poses in evenings]
    assert max(worse) > {"quadratic": 3, "asymmetry": 1.3}[name]


@pytest.mark.parametrize("width", [0.05, 0.3, 1.5])
def test_a_memory_of_any_width_is_found_with_it(width: float) -> None:
    """Two hundred sds of a memory that is a sign, a curve or nearly a proportion."""
    model = Model.of((*BASE, "hysteresis"))
    poses = made_poses("accelerometer", (0.0, 0.0, 0.0), corners=True)
    theta = base_theta(model, "accelerometer")
    theta[9:] = 200 * poses.sd[0, 0] * np.array([1.0, -0.7, 0.5])
    read = with_noise(
        read_through(poses, model, theta, {"hysteresis": width}), np.random.default_rng(3)
    )
    found = fit(read, model)
    assert found.chi2 / found.dof < 1.5
    assert found.shapes["hysteresis"] == pytest.approx(width, rel=0.1)
    assert found.theta[9:] == pytest.approx(theta[9:], rel=0.1)


@pytest.mark.parametrize("seed", [1, 2])
def test_a_lever_arm_is_fitted_although_its_derivative_vanishes_at_zero(seed: int) -> None:
    poses = on_the_plate(seed, (0.0, 50 / 3, 100 / 3))
    bare = fit(poses, Model.of(BASE))
    assert bare.chi2 / bare.dof > 10
    found = fit(poses, Model.of((*BASE, "lever_arm")))
    assert found.chi2 / found.dof < 1.5
    sd = np.sqrt(np.diag(found.cov))[9:]
    assert (sd < 0.004).all()
    assert np.abs((found.theta[9:] - np.array(CHIP_M)) / sd).max() < 3.5


def test_a_lever_arm_is_refused_where_nothing_turned() -> None:
    poses = with_noise(made_poses("accelerometer", (0.0,), corners=True), np.random.default_rng(1))
    assert np.linalg.norm(poses.reading[0]) == pytest.approx(GRAVITY, rel=1e-2)
    with pytest.raises(Undetermined, match="lever_arm"):
        fit(poses, Model.of((*BASE, "lever_arm")))


@pytest.mark.parametrize("share", [0.5, 0.9])
def test_an_effect_that_takes_most_of_the_gain_is_still_taken_off(share: float) -> None:
    """Reading ``s + c s³`` with ``3 c s² = -share`` at 1 g: a fixed point creeps or fails there."""
    cubic = find_effect("cubic")
    size = np.full(3, -share / 3 / 9.81**2)
    true = 9.81 * np.array([[1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.6, 0.0, 0.8]])
    at = Conditions.of_vectors(true)
    read = true + cubic.evaluate(at) @ size
    s = solve_sensor((cubic,), size, {}, Conditions.of_vectors, read, ALIGNED)
    assert s == pytest.approx(true, abs=1e-9)


def test_a_response_that_turns_back_is_refused() -> None:
    size = np.full(3, -1.3 / 3 / 9.81**2)
    with pytest.raises(FitFailed, match="larger than the readings"):
        solve_sensor((find_effect("cubic"),), size, {}, Conditions.of_vectors,
                     9.81 * np.eye(3), ALIGNED)


def test_a_gain_of_nothing_has_no_axes_and_no_warning() -> None:
    """A minimiser tries such gains on its way; numpy's warnings are errors here."""
    model = Model.of([*BASE, "cubic"])
    poses = made_poses("accelerometer", [0.0])
    equations = Equations.of(poses, model)
    theta = np.zeros(model.size)
    theta[model.slices()["scale"]] = [1.0, 0.0, 0.0]
    rows = equations.rows(theta, np.zeros(equations.common_count), {})
    assert np.isfinite(rows.jacobian).all()
