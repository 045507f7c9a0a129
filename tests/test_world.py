"""The simulated bench against first principles: kinematics, sensor, noise and implied parameters.

Nothing here touches the packages under test: the world is their measure, so it is measured alone.
"""

import ast
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation

from tests.world.bench import (
    EARTH_RATE_RAD_S,
    Design,
    Run,
    Site,
    Turntable,
    attitudes,
    corner_directions,
    wedge_directions,
)
from tests.world.designs import FAST, SLOW, paper_design, rich_design, soak_design
from tests.world.hidden import Hidden
from tests.world.imu import (
    MTI_SPREAD,
    Sensor,
    Triad,
    another_unit,
    gauss_markov,
    low_pass,
    mpu6050,
    mti,
)
from tests.world.physics import RunPhysics, live_through
from tests.world.plate import PlateMotion
from tests.world.session import simulate
from tests.world.truth import (
    g_sensitivity_seen,
    gyroscope_to_accelerometer,
    gyroscope_to_accelerometer_rad,
    parameters,
)

WORLD = Path(__file__).parent / "world"


def in_case(triad: Triad, along_axes: NDArray[np.float64]) -> NDArray[np.float64]:
    """Undo the projection on the sensitive axes."""
    return along_axes @ np.linalg.inv(triad.axes).T


def force_and_rate(
    design: Design, physics: RunPhysics
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    return (
        in_case(design.sensor.accelerometer, physics.true["accelerometer"]),
        in_case(design.sensor.gyroscope, physics.true["gyroscope"]),
    )


@pytest.mark.parametrize("module", sorted(WORLD.glob("*.py")), ids=lambda path: path.stem)
def test_the_world_imports_nothing_of_what_it_measures(module: Path) -> None:
    imported = set()
    for node in ast.walk(ast.parse(module.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            imported |= {alias.name.partition(".")[0] for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            imported.add((node.module or "").partition(".")[0])
    assert not imported & {"calib", "vision", "pipeline"}


def test_the_specific_force_at_rest_is_gravity_and_the_rate_is_earths() -> None:
    design = paper_design()
    still = next(live_through(design, 1))
    force, rate = force_and_rate(design, still)
    assert np.linalg.norm(force, axis=-1) == pytest.approx(design.site.gravity_m_s2, abs=1e-10)
    assert np.linalg.norm(rate, axis=-1) == pytest.approx(EARTH_RATE_RAD_S, rel=1e-9)


def test_earth_turns_north_and_up_by_the_latitude() -> None:
    north, west, up = Site(latitude_deg=30.0).earth_rate()
    assert (north, west, up) == pytest.approx(
        (EARTH_RATE_RAD_S * np.sqrt(3) / 2, 0.0, EARTH_RATE_RAD_S / 2)
    )


@pytest.mark.parametrize("rate", [SLOW, -SLOW, FAST, -FAST])
def test_over_whole_turns_the_mean_rate_is_the_plates_plus_earths_along_the_spindle(
    rate: float,
) -> None:
    seconds = 4 * 2 * np.pi / abs(rate)
    run = Run("turning", PlateMotion(rate), wedge_directions(), seconds)
    design = replace(paper_design(), runs=(run,), sample_rate_hz=200 / seconds)
    design = replace(design, turntable=replace(design.turntable, tilt_rad=(0.05, 0.0)))
    _, omega = force_and_rate(design, next(live_through(design, 2)))
    latitude = np.deg2rad(design.site.latitude_deg)
    spindle = np.array([0.0, -np.sin(0.05), np.cos(0.05)])  # tilted about north, towards east
    along = EARTH_RATE_RAD_S * np.array([np.cos(latitude), 0.0, np.sin(latitude)]) @ spindle
    expected = abs(rate) + np.sign(rate) * along
    assert np.linalg.norm(omega.mean(axis=1), axis=1) == pytest.approx(expected, rel=1e-12)


def test_force_and_rate_are_the_derivatives_of_where_the_case_is() -> None:
    """Attitude and position are differentiated by finite differences, in the site's frame."""
    motion = PlateMotion(FAST, wow=((1.0, 0.05, 0.3), (3.0, 0.02, 1.0)), angle_rad=0.4)
    table = Turntable((0.03, -0.02), (0.08, 0.05), placement_sd_m=0.0, vibration_m_s2=0.0)
    run = Run("turning", motion, wedge_directions()[:5], seconds=0.2, rest_s=1.0)
    design = replace(paper_design(), runs=(run,), turntable=table, sample_rate_hz=5000.0)
    physics = next(live_through(design, 3))
    force, rate = force_and_rate(design, physics)

    earth = design.site.earth_rate()
    spindle = Rotation.from_rotvec([*table.tilt_rad, 0.0])
    step = physics.time_s[0, 1] - physics.time_s[0, 0]
    for i, attitude in enumerate(physics.attitude):
        turn = motion.angle(physics.time_s[i])[:, None] * [0.0, 0.0, 1.0]
        site_from_case = spindle * Rotation.from_rotvec(turn) * Rotation.from_matrix(attitude)
        lever = attitude.T @ [*table.offset_m, 0.0] + design.sensor.chip_m
        position = site_from_case.apply(lever)
        velocity = (position[2:] - position[:-2]) / (2 * step)
        acceleration = (position[2:] - 2 * position[1:-1] + position[:-2]) / step**2
        back = site_from_case[1:-1].inv()
        felt = acceleration + 2 * np.cross(earth, velocity)
        felt[:, 2] += design.site.gravity_m_s2
        # Differences of 0.2 ms: truncation is below 1e-6, rounding of positions about 1e-8.
        inner = slice(5, -5)  # the plate's own angular acceleration is one-sided at the ends
        assert force[i, 1:-1][inner] == pytest.approx(back.apply(felt)[inner], abs=3e-4)

        between = (site_from_case[:-2].inv() * site_from_case[2:]).as_rotvec() / (2 * step)
        assert rate[i, 1:-1] == pytest.approx(between + back.apply(earth), abs=1e-6)


def test_off_the_spindle_the_sensor_feels_the_centripetal_acceleration() -> None:
    run = Run("turning", PlateMotion(FAST), wedge_directions(), seconds=2.0)
    table = Turntable((0.0, 0.0), (0.10, 0.0), placement_sd_m=0.0, vibration_m_s2=0.0)
    design = replace(paper_design(), runs=(run,), turntable=table)
    design = replace(design, sensor=replace(design.sensor, chip_m=np.zeros(3)))
    force, _ = force_and_rate(design, next(live_through(design, 4)))
    outward = FAST**2 * 0.10
    expected = np.hypot(design.site.gravity_m_s2, outward)
    assert np.linalg.norm(force, axis=-1) == pytest.approx(expected, abs=1e-4)  # Coriolis: 5e-5
    assert outward**2 / 2 / 9.8 == pytest.approx(0.076, abs=0.001)


def test_the_wedge_gives_18_antipodal_directions_and_corners_8_more() -> None:
    wedge, corners = wedge_directions(), corner_directions()
    assert wedge.shape == (18, 3)
    assert corners.shape == (8, 3)
    both = np.vstack([wedge, corners])
    assert np.linalg.norm(both, axis=1) == pytest.approx(1)
    cosines = both @ both.T
    assert (np.isclose(cosines, -1).sum(axis=1) == 1).all()
    assert (np.isclose(cosines, 1).sum(axis=1) == 1).all()


def test_attitudes_point_their_direction_up_within_the_jitter() -> None:
    directions = np.tile(wedge_directions(), (100, 1))
    exact = attitudes(directions, 0.0, np.random.default_rng(1))
    up = np.einsum("pij,pj->pi", exact, directions)
    assert up == pytest.approx(np.tile([0.0, 0.0, 1.0], (1800, 1)), abs=1e-12)
    loose = attitudes(directions, 3.0, np.random.default_rng(1))
    up = np.einsum("pij,pj->pi", loose, directions)
    assert np.rad2deg(up[:, :2].std(axis=0)) == pytest.approx(3.0, rel=0.07)


# --- the sensor --------------------------------------------------------------------------------


@pytest.mark.parametrize("sensor", [mti(), mpu6050()], ids=lambda sensor: sensor.name)
def test_the_implied_parameters_invert_the_sensor_up_to_a_rotation(sensor: Sensor) -> None:
    vectors = np.random.default_rng(5).standard_normal((50, 3))
    for triad in (sensor.accelerometer, sensor.gyroscope):
        found = parameters(triad)
        counts = vectors @ (triad.gain[:, None] * triad.axes).T + triad.offset
        x, y, z = ((counts - found.bias_counts) / found.scale_counts_per_unit).T
        ax, ay, az = found.misalignment_rad
        corrected = np.stack([x + az * y + ay * z, y + ax * z, z], axis=1)
        assert corrected == pytest.approx(vectors @ found.case_to_orthogonal.T, abs=1e-12)
        assert np.linalg.det(found.case_to_orthogonal) == pytest.approx(1)
        error = np.array([0.1, -0.2, 0.3])
        moved = found.reading_to_orthogonal @ error
        shift = error * triad.gain / found.scale_counts_per_unit
        assert moved == pytest.approx(
            [shift[0] + az * shift[1] + ay * shift[2], shift[1] + ax * shift[2], shift[2]]
        )


def test_the_mti_has_the_published_gains_offsets_and_misalignment() -> None:
    found = parameters(mti().accelerometer)
    assert found.misalignment_rad == pytest.approx([-0.0135, -0.0036, 0.0005], abs=1e-5)
    assert found.scale_counts_per_unit == pytest.approx([549.7, 552.7, 550.4], rel=1e-4)
    assert found.bias_counts == pytest.approx([33652, 33395, 32034])
    found = parameters(mti().gyroscope)
    assert found.misalignment_rad == pytest.approx([-0.0089, -0.0026, 0.0130], abs=2e-4)
    assert found.scale_counts_per_unit == pytest.approx([9651, 9402, 9417], rel=2e-4)


def test_both_orthogonal_frames_differ_by_the_stated_rotation() -> None:
    sensor, vector = mpu6050(), np.array([0.3, -1.1, 0.7])
    as_gyroscope = parameters(sensor.gyroscope).case_to_orthogonal @ vector
    as_accelerometer = parameters(sensor.accelerometer).case_to_orthogonal @ vector
    assert gyroscope_to_accelerometer(sensor) @ as_gyroscope == pytest.approx(as_accelerometer)
    turned = Rotation.from_rotvec(gyroscope_to_accelerometer_rad(sensor)).apply(as_gyroscope)
    assert turned == pytest.approx(as_accelerometer)


def test_g_sensitivity_between_the_orthogonal_frames_gives_the_same_reading_error() -> None:
    sensor, force = mpu6050(), np.array([4.0, -5.0, 7.0])
    size = np.arange(1.0, 10.0).reshape(3, 3) * 1e-4
    gyr, acc = parameters(sensor.gyroscope), parameters(sensor.accelerometer)
    seen = g_sensitivity_seen(sensor, size) @ (acc.case_to_orthogonal @ force)
    assert seen == pytest.approx(gyr.reading_to_orthogonal @ (size @ force))


def test_counts_are_whole_and_stop_at_the_rails() -> None:
    design = rich_design(mti())  # 200 °/s is beyond this unit
    session = simulate(design.scaled(seconds=0.2), 6)
    fast = next(log for log in session.runs if log.run.name == "33rpm")
    assert fast.gyroscope.dtype == np.int64
    assert fast.gyroscope.max() == 2**16 - 1
    assert fast.accelerometer.min() > 0
    assert mpu6050().gyroscope.rails == (-32768, 32767)
    slow = next(log for log in session.runs if log.run.name == "17rpm")
    assert slow.gyroscope.max() < 2**16 - 1


def test_without_noise_a_count_is_the_rounded_physics() -> None:
    design = paper_design(mti().with_noise(0.0))
    log = simulate(design, 7).runs[0]
    physics = next(live_through(design, 7))
    triad = design.sensor.accelerometer
    exact = physics.true["accelerometer"] * triad.gain + triad.offset
    assert np.abs(log.accelerometer - exact).max() <= 0.5


def test_slow_noise_has_its_sd_and_its_time_constant_also_across_pauses() -> None:
    rng = np.random.default_rng(8)
    time = np.arange(4000)[:, None] * 1.5 + np.arange(50) * 0.02  # pause of 0.52 s
    x = gauss_markov(time, sd=3.0, tau_s=0.5, rng=rng)
    assert x.std() == pytest.approx(3.0, rel=0.02)
    for lag in (1, 10, 25):
        within = (x[:, lag:] * x[:, :-lag]).mean() / 9
        assert within == pytest.approx(np.exp(-lag * 0.02 / 0.5), abs=0.03)
    across = (x[1:, 0] * x[:-1, -1]).mean() / 9
    assert across == pytest.approx(np.exp(-0.52 / 0.5), abs=0.03)


def test_the_low_pass_keeps_the_mean_and_damps_a_sine_by_its_corner() -> None:
    time = np.arange(20_000) / 1000.0
    sine = np.sin(2 * np.pi * 10 * time)[None, :, None]
    passed = low_pass(sine + 5.0, corner=10 / 1000.0)
    assert passed.mean() == pytest.approx(5.0, abs=1e-3)
    assert passed[0, 1000:].std() == pytest.approx(0.5, rel=0.05)  # sine's 0.707, down by 3 dB


@pytest.mark.parametrize("triad", ["accelerometer", "gyroscope"])
def test_pose_means_scatter_as_stated_and_far_more_than_white_noise(triad: str) -> None:
    sensor = mti()
    part: Triad = getattr(sensor, triad)
    time = np.arange(400)[:, None] * 30.0 + np.arange(800) / 100
    counts = part.convert(np.zeros((400, 800, 3)), time, np.random.default_rng(9))
    scatter = (counts.mean(axis=1) / part.gain).std(axis=0)
    assert scatter == pytest.approx(part.pose_mean_sd(800, 0.01), rel=0.12)
    white = part.white_sd / part.gain / np.sqrt(800)
    ratio = {"accelerometer": 3.1, "gyroscope": 1.2}[triad]
    assert np.mean(scatter / white) == pytest.approx(ratio, rel=0.1)


def test_another_unit_differs_by_the_spread_of_production() -> None:
    rng = np.random.default_rng(10)
    units = [another_unit(mti(), MTI_SPREAD, rng) for _ in range(400)]
    gains = np.array([unit.gyroscope.gain for unit in units]) / mti().gyroscope.gain
    assert gains.std() == pytest.approx(MTI_SPREAD.gain, rel=0.1)
    alphas = np.array([parameters(unit.accelerometer).misalignment_rad for unit in units])
    assert alphas.std(axis=0) == pytest.approx(MTI_SPREAD.tilt_rad, rel=0.12)


# --- the evening -------------------------------------------------------------------------------


def test_temperature_warms_up_and_a_soak_adds_its_own() -> None:
    paper = simulate(paper_design(), 11)
    warm = np.concatenate([log.columns["temperature_c"].mean(axis=1) for log in paper.runs])
    assert warm[0] == pytest.approx(24.0, abs=1.2)
    end = 24 + 8 * (1 - np.exp(-paper.design.end_s / 600))
    assert warm[-1] == pytest.approx(end, abs=1.2)
    soaks = [log.columns["temperature_c"].mean() for log in simulate(soak_design(), 11).runs]
    assert np.diff(soaks) == pytest.approx([20.0, -20.0], abs=1.0)


def test_time_runs_on_through_the_evening() -> None:
    session = simulate(rich_design(), 12)
    time = np.concatenate([log.time_s.ravel() for log in session.runs])
    assert (np.diff(time) > 0).all()
    assert sum(len(log.poses) for log in session.runs) == 90


def test_the_stated_rate_is_off_by_its_own_sd() -> None:
    design = paper_design().scaled(sample_rate=0.05)
    off = [
        (stated.rate_rad_s - SLOW) / stated.sd_rad_s
        for stated in (simulate(design, seed).rates["17rpm"] for seed in range(200))
    ]
    assert np.std(off) == pytest.approx(1.0, rel=0.15)


def test_the_same_seed_gives_the_same_logs_and_hiding_touches_nothing_else() -> None:
    design = paper_design().scaled(seconds=0.2)
    plain, again = simulate(design, 13), simulate(design, 13)
    touched = simulate(design, 13, (Hidden("bias", "gyroscope", np.full(3, 0.01)),))
    for a, b, c in zip(plain.runs, again.runs, touched.runs, strict=True):
        assert np.array_equal(a.gyroscope, b.gyroscope)
        assert np.array_equal(a.accelerometer, c.accelerometer)
        shift = 0.01 * design.sensor.gyroscope.gain
        assert (c.gyroscope - a.gyroscope).mean(axis=(0, 1)) == pytest.approx(shift, abs=0.05)
    other = simulate(design, 14)
    assert not np.array_equal(plain.runs[0].accelerometer, other.runs[0].accelerometer)


def test_magnitudes_alone_lead_a_plain_least_squares_fit_to_the_truth() -> None:
    """Nine free numbers in M (s_out - b), no knowledge of the model's usual form."""
    session = simulate(paper_design(), 15)
    log, truth = session.runs[0], session.accelerometer
    triad = session.design.sensor.accelerometer
    means = log.accelerometer.mean(axis=1)
    sd = triad.pose_mean_sd(800, 0.01).mean()

    def unpack(p: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        k = 1 / (550 * (1 + p[3:6] / 100))
        t = np.array([[1, p[2], p[1]], [0, 1, p[0]], [0, 0, 1]])
        return t * k, 33000 + 1000 * p[6:]

    def misfit(p: NDArray[np.float64]) -> NDArray[np.float64]:
        m, b = unpack(p)
        return (np.linalg.norm((means - b) @ m.T, axis=1) - session.design.site.gravity_m_s2) / sd

    fit = least_squares(misfit, np.zeros(9), x_scale="jac", xtol=1e-14, ftol=1e-14)
    cov = np.linalg.inv(fit.jac.T @ fit.jac)
    expected = np.concatenate(
        [
            truth.misalignment_rad,
            100 * (truth.scale_counts_per_unit / 550 - 1),
            (truth.bias_counts - 33000) / 1000,
        ]
    )
    assert np.abs((fit.x - expected) / np.sqrt(np.diag(cov))).max() < 3.5
    assert np.sqrt(np.diag(cov))[6:].max() < 5e-3  # biases to 5 counts or better
    assert 2 * fit.cost == pytest.approx(9, abs=13)  # chi-square with nine degrees of freedom
