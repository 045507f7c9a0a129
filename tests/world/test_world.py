"""The simulated bench against first principles: kinematics, surroundings, and a fit to its truth.

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
from tests.world.imu import Triad
from tests.world.physics import RunPhysics, live_through
from tests.world.plate import PlateMotion
from tests.world.session import simulate

WORLD = [path for path in sorted(Path(__file__).parent.glob("*.py"))
         if not path.name.startswith("test_")]


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


@pytest.mark.parametrize("module", WORLD, ids=lambda path: path.stem)
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
        # Differences of 0.2 ms leave 3e-6; Coriolis acceleration, the smallest part, is 5e-5.
        inner = slice(5, -5)  # the plate's own angular acceleration is one-sided at the ends
        assert force[i, 1:-1][inner] == pytest.approx(back.apply(felt)[inner], abs=1e-5)

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
