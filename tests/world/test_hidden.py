"""Every hidden effect of the simulated bench does what its name says, in the size asked for."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from tests.world.bench import Design, Run, Turntable, wedge_directions
from tests.world.designs import SLOW, paper_design, rich_design, soak_design
from tests.world.hidden import EFFECTS, Hidden
from tests.world.physics import RunPhysics, live_through
from tests.world.plate import PlateMotion

FloatArray = NDArray[np.float64]

LISTED = [
    *("bias", "scale", "misalignment", "frame_rotation", "quadratic", "cubic", "asymmetry"),
    *("cross_quadratic", "temperature_bias", "temperature_scale", "bias_drift", "scale_drift"),
    *("warm_up", "hysteresis", "vibration_rectification", "g_sensitivity"),
    *("g_squared_sensitivity", "lever_arm", "earth_rate", "reference_offset", "reference_scale"),
    *("reference_drift", "direction_dependent_rate"),
]
UNLISTED = [
    *("column_squared", "memory", "temperature_squared", "temperature_lag", "wander"),
    *("plate_wander", "jump", "bad_pose", "periodic"),
]
SIZE = np.array([1e-3, -2e-3, 3e-3])
DETAIL = {
    "tau_s": 500.0, "time_s": 900.0, "number": 20, "period_s": 700.0, "phase_rad": 0.3,
    "width": 0.4, "lag_s": 300.0, "wander_tau_s": 900.0, "draw": 7,
}
QUICK = rich_design().scaled(sample_rate=0.1)


def named(name: str) -> str:
    return f"{name}:humidity_pct" if name.startswith("column") else name


def errors(
    effect: Hidden, design: Design = QUICK
) -> list[tuple[RunPhysics, FloatArray, FloatArray]]:
    """Per run: the physics, what truly acts along the axes, and the error of the reading."""
    return [
        (run, run.true[effect.triad], run.felt[effect.triad] - run.true[effect.triad])
        for run in live_through(design, 1, (effect,))
    ]


def test_every_name_of_the_contract_can_be_hidden() -> None:
    assert list(EFFECTS) == [*LISTED, "column", *UNLISTED]


TEMPERATURE_ABOVE_25 = lambda run, true: (run.columns["temperature_c"] - 25)[..., None]  # noqa: E731
HUMIDITY_ABOVE_45 = lambda run, true: (run.columns["humidity_pct"] - 45)[..., None]  # noqa: E731


@pytest.mark.parametrize(
    ("name", "shape"),
    [
        ("bias", lambda run, true: 1.0),
        ("scale", lambda run, true: true),
        ("quadratic", lambda run, true: true**2),
        ("cubic", lambda run, true: true**3),
        ("asymmetry", lambda run, true: np.abs(true)),
        ("temperature_bias", TEMPERATURE_ABOVE_25),
        ("temperature_scale", lambda run, true: TEMPERATURE_ABOVE_25(run, true) * true),
        ("bias_drift", lambda run, true: run.time_s[..., None]),
        ("scale_drift", lambda run, true: run.time_s[..., None] * true),
        ("warm_up", lambda run, true: np.exp(-run.time_s / 500)[..., None]),
        ("column", HUMIDITY_ABOVE_45),
        ("column_squared", lambda run, true: HUMIDITY_ABOVE_45(run, true) ** 2),
        ("jump", lambda run, true: (run.time_s >= 900)[..., None]),
        ("periodic", lambda run, true: np.sin(2 * np.pi * run.time_s / 700 + 0.3)[..., None]),
    ],
)
@pytest.mark.parametrize("triad", ["accelerometer", "gyroscope"])
def test_an_effect_on_an_axis_has_its_shape(
    name: str, shape: Callable[[RunPhysics, FloatArray], FloatArray], triad: str
) -> None:
    for run, true, error in errors(Hidden(named(name), triad, SIZE, DETAIL)):
        np.testing.assert_allclose(error, SIZE * shape(run, true) + 0 * true, 1e-6, 1e-12)


def test_misalignment_leans_an_axis_towards_the_next() -> None:
    for _, true, error in errors(Hidden("misalignment", "accelerometer", SIZE)):
        assert error[..., 0] == pytest.approx(3e-3 * true[..., 1] - 2e-3 * true[..., 2])
        assert error[..., 1] == pytest.approx(1e-3 * true[..., 2])
        assert error[..., 2] == pytest.approx(0 * true[..., 2])


def test_frame_rotation_leaves_magnitudes_to_first_order() -> None:
    for _, true, error in errors(Hidden("frame_rotation", "gyroscope", SIZE)):
        assert np.sum(error * true, axis=-1) == pytest.approx(0, abs=1e-15 + 1e-9)
        assert np.abs(error).max() > 1e-3 * np.abs(true).max()


def test_cross_quadratic_multiplies_the_two_other_readings() -> None:
    size = np.zeros((3, 3))
    size[0, 0] = 0.01  # x errs by y z
    size[2, 1] = 0.02  # z errs by z x
    for _, true, error in errors(Hidden("cross_quadratic", "gyroscope", size)):
        x, y, z = np.moveaxis(true, -1, 0)
        assert error[..., 0] == pytest.approx(0.01 * y * z)
        assert error[..., 1] == pytest.approx(0 * y)
        assert error[..., 2] == pytest.approx(0.02 * z * x)


def test_g_sensitivity_shows_at_rest_and_turning_alike() -> None:
    size = np.arange(9.0).reshape(3, 3) * 1e-4
    for run, _, error in errors(Hidden("g_sensitivity", "gyroscope", size)):
        up = run.attitude[:, 2, :]  # the case direction that points up
        assert error.mean(axis=1) == pytest.approx(9.80267 * up @ size.T, abs=4e-4)


def test_g_squared_sensitivity_does_not_ask_for_the_sign() -> None:
    axes = QUICK.sensor.gyroscope.axes
    design = replace(QUICK, turntable=Turntable((0.0, 0.0), vibration_m_s2=0.0))
    for run, _, error in errors(Hidden("g_squared_sensitivity", "gyroscope", SIZE), design):
        along = 9.80267 * run.attitude[:, 2, :] @ axes.T
        assert error.mean(axis=1) == pytest.approx(SIZE * along**2, abs=5e-3 * 0.3)


def test_hysteresis_remembers_the_sign_of_the_pose_before() -> None:
    last = np.zeros(3)
    for _, true, error in errors(Hidden("hysteresis", "accelerometer", SIZE)):
        means = true.mean(axis=1)
        before = np.vstack([last, means[:-1]])
        pushed = np.abs(before) > 0.02
        assert error[:, 0][pushed] == pytest.approx((SIZE * np.sign(before))[pushed])
        last = means[-1]


def test_gyroscope_hysteresis_has_nothing_to_remember_of_a_plate_at_rest() -> None:
    still, *turning = errors(Hidden("hysteresis", "gyroscope", SIZE))
    assert not still[2].any()
    assert np.abs(turning[0][2][1:, 0]) == pytest.approx(np.abs(np.tile(SIZE, (17, 1))))


def test_vibration_rectification_follows_the_variance_that_the_accelerometers_show() -> None:
    effect = Hidden("vibration_rectification", "gyroscope", np.array([0.1, 0.1, 0.1]))
    design = replace(rich_design(), turntable=Turntable((0.0, 0.0), vibration_m_s2=0.2))
    still, *turning = errors(effect, design)
    assert not still[2].any()
    for run, _, error in turning:
        shown = run.true["accelerometer"].var(axis=1).sum(axis=1)
        assert error[:, 0, 0] == pytest.approx(0.1 * shown, rel=0.12)


def test_a_lever_arm_adds_the_centripetal_acceleration_of_the_plate() -> None:
    run = Run("17rpm", PlateMotion(SLOW), wedge_directions(), 2.0, in_accelerometer_section=True)
    design = replace(paper_design(), runs=(run,))
    [(physics, _, error)] = errors(Hidden("lever_arm", "accelerometer", [0.1, 0.0, 0.0]), design)
    felt = error.mean(axis=1) @ np.linalg.inv(design.sensor.accelerometer.axes).T
    spindle = physics.attitude[:, 2, :]
    inward = SLOW**2 * (spindle * spindle[:, :1] * 0.1 - [0.1, 0.0, 0.0])
    assert felt == pytest.approx(inward, abs=1e-9)


def test_one_bad_pose_is_one_pose() -> None:
    runs = errors(Hidden("bad_pose", "gyroscope", SIZE, DETAIL))
    touched = np.concatenate([error.any(axis=(1, 2)) for _, _, error in runs])
    assert np.flatnonzero(touched).tolist() == [20]


def spins(effect: Hidden) -> dict[str, FloatArray]:
    """Signed mean rate about the spindle per pose of each run on the plate."""
    found = {}
    for run in live_through(QUICK, 1, (effect,)):
        rate = run.true["gyroscope"].mean(axis=1) @ np.linalg.inv(QUICK.sensor.gyroscope.axes).T
        found[run.run.name] = np.sum(rate * run.attitude[:, 2, :], axis=1)
    return found


@pytest.mark.parametrize(
    ("name", "size", "change"),
    [
        ("reference_offset", 0.01, lambda rate, time: np.sign(rate) * 0.01),
        ("reference_scale", 0.01, lambda rate, time: rate * 0.01),
        ("reference_drift", 1e-6, lambda rate, time: rate * 1e-6 * time),
        ("direction_dependent_rate", 0.01, lambda rate, time: np.abs(rate) * 0.01),
        ("earth_rate", 0.01, lambda rate, time: 0.01),
    ],
)
def test_the_plate_turns_differently_from_what_is_stated(
    name: str, size: float, change: Callable[[float, FloatArray], FloatArray]
) -> None:
    plain = spins(Hidden("bias", "gyroscope", np.zeros(3)))
    really = spins(Hidden(name, "gyroscope", np.array(size)))
    for run, begin in zip(QUICK.runs, QUICK.begins_s(), strict=True):
        time = begin + np.arange(18) * (run.seconds + run.rest_s) + run.seconds / 2
        rate = run.motion.rate_rad_s if run.motion else 0.0
        if run.motion is None and name != "earth_rate":
            expected = np.zeros(18)
        else:
            expected = change(rate, time) * np.ones(18)
        assert really[run.name] - plain[run.name] == pytest.approx(expected, abs=2e-6)


@pytest.mark.parametrize(
    ("name", "gravity"), [("reference_scale", 9.9), ("reference_offset", 9.81)]
)
def test_gravity_can_differ_from_what_is_stated(name: str, gravity: float) -> None:
    design = paper_design()
    size = gravity / 9.80267 - 1 if name == "reference_scale" else gravity - 9.80267
    still = next(live_through(design, 1, (Hidden(name, "accelerometer", size),)))
    force = still.true["accelerometer"] @ np.linalg.inv(design.sensor.accelerometer.axes).T
    assert np.linalg.norm(force, axis=-1) == pytest.approx(gravity)


def test_memory_grows_with_the_push_before_and_saturates() -> None:
    for run, true, error in errors(Hidden("memory", "gyroscope", SIZE, DETAIL)):
        if run.run.motion is None:
            continue
        before = true.mean(axis=1)[:-1]
        largest = np.abs(before).max()
        small, large = np.abs(before) < 0.05 * largest, np.abs(before) > 0.9 * largest
        share = (error.mean(axis=1) / SIZE)[1:]
        assert (np.abs(share[small]) < 0.2).all()
        assert (np.abs(share[large]) > 0.9).all()


def test_a_lagging_bias_settles_where_the_die_does_and_comes_later() -> None:
    design = soak_design().scaled(sample_rate=0.1)
    lag = Hidden("temperature_lag", "accelerometer", SIZE, DETAIL)
    at_once = Hidden("temperature_bias", "accelerometer", SIZE, DETAIL)
    late, prompt = errors(lag, design), errors(at_once, design)
    for (run, _, a), (_, _, b) in zip(late, prompt, strict=True):
        a, b = np.broadcast_to(a, b.shape), b
        if run.run.name == "warm":  # 20 minutes of soak begin with the run
            assert np.abs(a[0]).max() < 0.9 * np.abs(b[0]).max()
            assert np.abs(a[-1]).max() > np.abs(a[0]).max()


def test_a_wandering_bias_has_its_size_and_its_correlation_time() -> None:
    values = []
    for draw in range(60):
        detail = {**DETAIL, "draw": draw}
        runs = errors(Hidden("wander", "gyroscope", np.ones(3), detail))
        values.append(np.concatenate([error.mean(axis=1) for _, _, error in runs]))
        time_s = np.concatenate([run.time_s.mean(axis=1) for run, _, _ in runs])
    every = np.array(values)
    assert every.var() == pytest.approx(1.0, rel=0.15)
    later = int(np.searchsorted(time_s, time_s[0] + 900.0))
    apart = np.exp(-(time_s[later] - time_s[0]) / 900.0)
    assert (every[:, 0] * every[:, later]).mean() == pytest.approx(apart, abs=0.2)


def test_a_wandering_plate_turns_unevenly_over_minutes() -> None:
    still, moved = (
        [run for run in live_through(QUICK, 1, hidden) if run.run.motion is not None]
        for hidden in ((), (Hidden("plate_wander", "gyroscope", np.array(1e-3), DETAIL),))
    )
    share = np.concatenate([
        np.linalg.norm(b.true["gyroscope"], axis=2).mean(axis=1)
        / np.linalg.norm(a.true["gyroscope"], axis=2).mean(axis=1) - 1
        for a, b in zip(still, moved, strict=True)
    ])
    assert 2e-4 < share.std() < 1.5e-3
    assert np.abs(share).max() < 3e-3


def test_a_coarse_converter_delivers_every_sixteenth_count() -> None:
    triad = replace(paper_design().sensor.accelerometer, step_counts=16)
    along = np.full((2, 50, 3), 3.0)
    time_s = np.arange(100.0).reshape(2, 50)
    counts = triad.convert(along, time_s, np.random.default_rng(1))
    assert (counts % 16 == 0).all()
