"""Laws that every registered effect keeps; a new effect joins them by being registered."""

import ast
from dataclasses import replace

import numpy as np
import pytest

from calib.effects.catalogue import BASE, find_effect
from calib.effects.effect import EFFECTS, REFERENCE_TEMPERATURE_C, Effect
from calib.effects.expression import read_expression
from calib.effects.formula import axis_terms
from calib.effects.needs import unavailable
from calib.errors import Undetermined
from calib.fit.least_squares.solver import fit
from calib.fit.model import Model, stack_columns
from calib.fit.rows.residuals import Equations
from calib.fit.rows.sensitive_axes import ALIGNED, solve_sensor
from calib.poses.conditions import Conditions
from calib.poses.imu_log import FloatArray, Triad
from calib.poses.triad_kind import TRIAD_KINDS
from tests.calib.made_poses import (
    base_theta,
    linear_form,
    pairs,
    read_through,
    rich_poses,
    some_conditions,
)

NOISE_UNITS = 30.0
ADDED = [name for name, effect in EFFECTS.items() if effect.acts_on not in ("reading", "noise")]
WRITTEN_OUT = [name for name, effect in EFFECTS.items() if effect.page.expressions]
SHAPE_VALUE = {"warm_up": 900.0, "hysteresis": 0.12, "bias_step": 2010.0,
               "temperature_bias_curve": 31.0, "temperature_scale_curve": 31.0}
"""Each between two of the effect's starts."""

ACROSS = {"frame_rotation": 0.01, "lever_arm": 0.02}
"""Effects across the vector, which move its length by nothing or by second order only; and how
large they are here, in rad and m, since noise units are none."""

REFUSED = {(name, triad) for name in ("frame_rotation", "reference_scale") for triad in TRIAD_KINDS}
REFUSED |= {("reference_offset", triad) for triad in ("accelerometer", "magnetometer")}
"""Effects that lengths cannot show: those across them, and a wrong clock or gravity, which is a
gain."""


def shapes_of(model: Model) -> dict[str, float]:
    return {effect.name: SHAPE_VALUE[effect.name] for effect in model.effects if effect.shape}


def evaluated(effect: Effect, triad: Triad) -> FloatArray:
    return effect.evaluate(some_conditions(triad))


@pytest.mark.parametrize(("name", "triad"), pairs(list(EFFECTS)))
def test_columns_have_a_row_per_pose_and_a_column_per_parameter(name: str, triad: Triad) -> None:
    effect = EFFECTS[name]
    k = len(effect.parameters)
    expected = (12, k) if effect.acts_on == "reference" else (12, 3, k)
    assert evaluated(effect, triad).shape == expected


@pytest.mark.parametrize(("name", "triad"), pairs(list(EFFECTS)))
def test_columns_are_finite_and_none_is_empty_on_complete_conditions(
    name: str, triad: Triad
) -> None:
    columns = evaluated(EFFECTS[name], triad)
    assert np.isfinite(columns).all()
    assert (np.abs(columns).reshape(-1, columns.shape[-1]).max(axis=0) > 0).all()


@pytest.mark.parametrize(("name", "triad"), pairs(list(EFFECTS)))
def test_a_row_does_not_depend_on_the_other_rows(name: str, triad: Triad) -> None:
    effect, at = EFFECTS[name], some_conditions(triad)
    whole = effect.evaluate(at)
    for rows in ([0], [7, 3], [11, 10, 9, 1]):
        assert effect.evaluate(at.take(rows)) == pytest.approx(whole[rows], rel=1e-14, abs=0)


@pytest.mark.parametrize(("name", "triad"), pairs(WRITTEN_OUT))
def test_the_expressions_of_the_page_are_the_columns(name: str, triad: Triad) -> None:
    effect, at = EFFECTS[name], some_conditions(triad)
    columns = np.zeros((len(at), 3, len(effect.parameters)))
    for axis, terms in enumerate(axis_terms(effect)):
        for term in terms:
            value = read_expression(ast.unparse(term.value))
            columns[:, axis, term.parameter] += value(at)[:, axis]
    assert columns == pytest.approx(effect.evaluate(at), rel=1e-14, abs=1e-300)


@pytest.mark.parametrize("name", EFFECTS)
def test_what_samples_determine_has_expressions_so_that_programs_correct_it(name: str) -> None:
    effect = EFFECTS[name]
    determined = effect.acts_on == "sensor" and effect.told_by in ("sample", "clock")
    assert bool(effect.page.expressions) == determined


@pytest.mark.parametrize("name", EFFECTS)
def test_the_catalogue_page_is_complete(name: str) -> None:
    effect = EFFECTS[name]
    page = effect.page
    assert effect.name == name
    assert len(effect.physics) > 20
    assert effect.physics.endswith(".")
    assert "=" in page.formula or "→" in page.formula
    assert all(str(size) for size in page.typical.values())
    assert page.typical
    assert page.source
    assert page.confounded
    assert page.separates
    assert effect.triads
    assert set(effect.triads) <= set(TRIAD_KINDS)
    assert len(set(effect.parameters)) == len(effect.parameters)


@pytest.mark.parametrize(("name", "triad"), pairs(list(EFFECTS)))
def test_the_unit_is_that_of_the_triad(name: str, triad: Triad) -> None:
    unit = EFFECTS[name].unit_for(triad)
    assert "{" not in unit
    others = [kind.unit for kind in TRIAD_KINDS.values() if kind.name != triad]
    assert not any(other in unit for other in others) or name in (
        "g_sensitivity", "g_squared_sensitivity", "vibration_rectification")


@pytest.mark.parametrize("name", [n for n, e in EFFECTS.items() if e.shape])
def test_a_shape_starts_within_its_bounds(name: str) -> None:
    shape = EFFECTS[name].shape
    assert shape is not None
    low, high = shape.bounds
    assert all(low < start < high for start in shape.starts)


@pytest.mark.parametrize("name", ["temperature_bias", "temperature_scale"])
def test_temperature_effects_vanish_at_the_reference_temperature(name: str) -> None:
    at = some_conditions("gyroscope")
    at.columns["temperature_c"][:] = REFERENCE_TEMPERATURE_C  # type: ignore[index]
    assert not EFFECTS[name].evaluate(at).any()


def strong_theta(equations: Equations, rng: np.random.Generator) -> FloatArray:
    """Theta of the model with every added effect moving the rows by ``NOISE_UNITS``, (p,)."""
    model, triad = equations.model, equations.poses.triad
    theta = base_theta(model, triad)
    rows = equations.rows(theta, np.zeros(equations.common_count), shapes_of(model))
    for effect in model.effects:
        if effect.acts_on == "reading":
            continue
        where = model.slices()[effect.name]
        direction = rng.standard_normal(where.stop - where.start)
        if effect.name in ACROSS:
            theta[where] = direction * ACROSS[effect.name]
            continue
        moved = rows.jacobian[:, where] @ direction
        theta[where] = direction * NOISE_UNITS / np.sqrt(np.mean(moved**2))
    return theta


@pytest.mark.parametrize(
    ("name", "triad"), pairs([n for n in ADDED if EFFECTS[n].acts_on == "sensor"])
)
def test_correcting_what_was_simulated_gives_the_truth_back(name: str, triad: Triad) -> None:
    effect = EFFECTS[name]
    poses = rich_poses(triad)
    model = Model((effect,))
    equations = Equations.of(poses, model)
    theta = strong_theta(equations, np.random.default_rng(3))
    at = poses.conditions(poses.reading)
    shapes = shapes_of(model)
    simulated = poses.reading + stack_columns(model.effects, at, shapes) @ theta

    def conditions(s: FloatArray) -> Conditions:
        return poses.conditions(s, sensed=poses.reading)

    s = solve_sensor(model.effects, theta, shapes, conditions, simulated, ALIGNED)
    assert s == pytest.approx(poses.reading, abs=1e-12 * np.abs(poses.reading).max())


def differences(equations: Equations, theta: FloatArray, shapes: dict[str, float]) -> FloatArray:
    """Central differences of the whitened rows by theta and eta, (r, p + q)."""
    p, q = equations.model.size, equations.common_count
    at = np.concatenate([theta, np.zeros(q)])
    exact = equations.rows(theta, np.zeros(q), shapes).jacobian
    columns = np.zeros_like(exact)
    for j in range(p + q):
        # A step that moves the rows by about 0.01 noise units.
        step = 1e-2 / max(float(np.abs(exact[:, j]).max()), 1e-3)
        up, down = at.copy(), at.copy()
        up[j] += step
        down[j] -= step
        columns[:, j] = (
            equations.rows(up[:p], up[p:], shapes).residual
            - equations.rows(down[:p], down[p:], shapes).residual
        ) / (2 * step)
    return columns


@pytest.mark.parametrize(("name", "triad"), pairs(ADDED))
def test_the_jacobian_is_the_central_difference(name: str, triad: Triad) -> None:
    model = Model.of((*BASE, name))
    truth = base_theta(model, triad)
    poses = read_through(rich_poses(triad, shared_sd=1e-4), model, truth)
    equations = Equations.of(poses, model)
    theta = strong_theta(equations, np.random.default_rng(5))
    shapes = shapes_of(model)
    exact = equations.rows(theta, np.zeros(equations.common_count), shapes).jacobian
    scale = np.maximum(np.sqrt((exact**2).mean(axis=0)), 1e-3)
    assert differences(equations, theta, shapes) / scale == pytest.approx(exact / scale, abs=2e-5)


@pytest.mark.parametrize("triad", TRIAD_KINDS)
def test_the_jacobian_holds_with_every_effect_at_once(triad: Triad) -> None:
    names = [name for name in ADDED if triad in EFFECTS[name].triads]
    model = Model.of((*BASE, *names))
    poses = read_through(rich_poses(triad, shared_sd=1e-4), model, base_theta(model, triad))
    equations = Equations.of(poses, model)
    theta = strong_theta(equations, np.random.default_rng(6))
    theta[model.positions(model.acting_on("sensor"))] *= 0.3  # all at once still have a true vector
    shapes = shapes_of(model)
    exact = equations.rows(theta, np.zeros(equations.common_count), shapes).jacobian
    scale = np.maximum(np.sqrt((exact**2).mean(axis=0)), 1e-3)
    assert differences(equations, theta, shapes) / scale == pytest.approx(exact / scale, abs=2e-5)


@pytest.mark.parametrize(("name", "triad"), pairs(ADDED))
def test_what_went_in_comes_out_and_nothing_else_changes(name: str, triad: Triad) -> None:
    """Noise-free: the effect's parameters come back, bias, scale and misalignment as they were."""
    model = Model.of((*BASE, name))
    poses = rich_poses(triad)
    shapes = shapes_of(model)
    for effect in model.within(poses.conditions(poses.reading)).effects:
        if effect.shape is not None and not effect.shape.is_fitted:  # one of those that are tried
            value = shapes[effect.name]
            shapes[effect.name] = min(effect.shape.starts, key=lambda start: abs(start - value))
    theta = strong_theta(Equations.of(poses, model), np.random.default_rng(7))
    read = read_through(poses, model, theta, shapes)
    if name == "cross_quadratic":  # of x·y·z on three axes, a length shows the sum: no more goes in
        for _ in range(6):  # to where the readings and what they show agree
            seen = np.linalg.qr(fit(read, model).basis[9:, 9:])[0]
            theta[9:] = seen @ (seen.T @ theta[9:])
            read = read_through(poses, model, theta, shapes)
    if (name, triad) in REFUSED:
        with pytest.raises(Undetermined, match=f"cannot see '{name}'"):
            fit(read, model)
        return
    found = fit(read, model)
    assert found.shapes == pytest.approx(shapes, rel=2e-3)
    # A time constant is found to 1e-4 of itself; whatever is linear to rounding.
    tolerance = 2e-3 if shapes else 1e-7
    size = np.abs(theta[model.slices()[name]]).max()
    assert found.theta[9:] == pytest.approx(theta[9:], abs=tolerance * size)
    assert found.theta[:9] == pytest.approx(theta[:9], abs=tolerance * 0.1)
    assert found.basis.shape[1] == model.size - (2 if name == "cross_quadratic" else 0)


@pytest.mark.parametrize(("name", "triad"), pairs(ADDED))
def test_what_an_effect_lacks_is_said(name: str, triad: Triad) -> None:
    poses = rich_poses(triad)
    assert unavailable(EFFECTS[name], poses.conditions(poses.reading)) is None
    n = len(poses)
    bare = replace(
        poses,
        columns={},
        time_s=np.full(n, np.nan),
        force=np.full((n, 3), np.nan),
        vibration=np.full((n, 3), np.nan),
    )
    of_time = {"bias_step", "bias_drift", "scale_drift", "warm_up", "hysteresis", "reference_drift"}
    of_force = {"g_sensitivity", "g_squared_sensitivity", "earth_rate", "vibration_rectification"}
    said = unavailable(EFFECTS[name], bare.conditions(bare.reading))
    if name.startswith("temperature_"):
        assert said == "the logs have no complete column temperature_c"
    elif name in of_time:
        assert said is not None
        assert "the order in time is not known" in said
    elif name in of_force:
        assert said is not None
        assert "the accelerometer was not logged" in said
    else:
        assert said is None


def test_the_linear_form_of_the_columns_is_that_of_the_paper() -> None:
    """``y - E(y) theta`` of bias, scale and misalignment is ``M y + c`` with eq. (2)'s zeros."""
    model = Model.of(BASE)
    theta = base_theta(model, "gyroscope")
    at = some_conditions("gyroscope")
    matrix, offset = linear_form(model, theta)
    by_columns = at.vector - stack_columns(model.effects, at, {}) @ theta
    assert by_columns == pytest.approx(at.vector @ matrix.T + offset, abs=1e-15)
    assert matrix[np.tril_indices(3, -1)] == pytest.approx(0, abs=0)


def test_a_column_effect_follows_its_column() -> None:
    effect = find_effect("column:humidity_pct")
    at = some_conditions("gyroscope")
    expected = at.columns["humidity_pct"][:, None, None] * np.eye(3)
    assert effect.evaluate(at) == pytest.approx(expected)
    assert effect.unit_for("gyroscope") == "rad/s per %"
