"""Waves of a leaning plate, simulated sample by sample, against the truth that made them."""


from dataclasses import replace
from functools import lru_cache

import numpy as np
import pytest

from calib.assess import assess
from calib.diagnosis.hypotheses.courses import by_clock
from calib.effects.catalogue import BASE
from calib.fit.least_squares.solver import extend, fit
from calib.fit.model import Model
from calib.fit.rows.residuals import Equations
from calib.fit.validation.leave_one_out import compare
from calib.poses.imu_log import Triad
from calib.poses.pose_set import PoseSet
from tests.calib.leaning_poses import PER_SI, gyro_poses
from tests.fitting import pose_sets, tilted_pose_sets
from tests.world.bench import Site, wedge_directions
from tests.world.designs import SLOW, still_run, tilted_design
from tests.world.imu import mpu6050
from tests.world.session import simulate
from tests.world.truth import g_sensitivity_seen

WITH_G = Model.of([*BASE, "g_sensitivity"])


def deviations(poses: PoseSet, hide: bool = True) -> np.ndarray:
    """(estimate - truth)/sd of the nine elements."""
    fitted = fit(poses, WITH_G)
    where = fitted.model.slices()["g_sensitivity"]
    truth = g_sensitivity_seen(mpu6050(), PER_SI * hide).ravel()
    return np.asarray((fitted.theta[where] - truth) / np.sqrt(np.diag(fitted.cov)[where]))


def test_a_level_plate_has_none() -> None:
    poses, _ = gyro_poses(0.4)
    assert poses.ring is None
    assert not any("tilt" in name for name in poses.reference.common_names)


@lru_cache
def accelerometer_poses() -> PoseSet:
    """Nine mountings on a plate that leans by 20°."""
    return tilted_pose_sets(simulate(replace(tilted_design(20.0), sample_rate_hz=25.0), 3))[0]


@pytest.mark.parametrize(("triad", "effects"), [
    ("gyroscope", []), ("gyroscope", ["g_sensitivity", "quadratic"]),
    ("accelerometer", []), ("accelerometer", ["quadratic", "asymmetry"])])
def test_their_jacobian_is_exact(triad: Triad, effects: list[str]) -> None:
    names = [*BASE, *effects]
    poses = accelerometer_poses() if triad == "accelerometer" else gyro_poses(10.0)[0]
    equations = Equations.of(poses, Model.of(names))
    rng = np.random.default_rng(3)
    size = np.where(np.arange(equations.model.size) < 9, 1e-2, 1e-4)
    theta = size * rng.standard_normal(equations.model.size)
    eta = rng.standard_normal(len(poses.reference.common_names))
    rows = equations.rows(theta, eta, {})
    both = np.concatenate([theta, eta])
    for i in range(len(both)):
        step = np.zeros(len(both))
        step[i] = 1e-6 * (size[i] if i < len(theta) else 1.0) * 100
        up, down = ((equations.rows(each[: len(theta)], each[len(theta) :], {})).residual
                    for each in (both + step, both - step))
        slope = (up - down) / (2 * step[i])
        scale = np.abs(rows.jacobian[:, i]).max() + 1e-9
        assert rows.jacobian[:, i] / scale == pytest.approx(slope / scale, abs=1e-4)


@pytest.mark.parametrize(("tilt_deg", "sd"), [(5.0, 0.045), (20.0, 0.012)])
def test_they_show_all_nine_elements_of_a_g_sensitivity(tilt_deg: float, sd: float) -> None:
    poses, spec = gyro_poses(tilt_deg)
    assert np.sqrt(np.mean(deviations(poses) ** 2)) < 2
    fitted = fit(poses, WITH_G)
    stated = np.sqrt(np.diag(fitted.cov)[fitted.model.slices()["g_sensitivity"]])
    assert np.degrees(stated).max() * 9.80665 < 1.5 * sd
    assert 0.6 < fitted.chi2 / fitted.dof < 1.5
    assert assess(poses, Model.of(BASE), spec).diagnosis.names == ("g_sensitivity",)


def test_the_residual_of_a_pose_is_that_of_its_waves_too() -> None:
    """With its g-sensitivity left out of the model the lengths fit, and the waves do not."""
    poses, _ = gyro_poses(10.0)
    lacking, whole = (fit(poses, model) for model in (Model.of(BASE), WITH_G))
    lengths = lacking.rows.residual[: len(poses)]
    assert np.sqrt(np.mean(lengths**2)) < 1.5
    assert max(pose.in_sd for pose in compare(lacking).poses) > 2
    for each in (lacking, whole):
        in_sd = np.array([pose.in_sd for pose in compare(each).poses])
        rows = each.rows.residual[: each.equations.data_count]
        assert in_sd**2 @ each.equations.row_count == pytest.approx(rows @ rows)


@pytest.mark.parametrize("rate", [SLOW, -SLOW])
def test_the_vertical_part_of_the_rate_of_the_earth_is_no_g_sensitivity(rate: float) -> None:
    """The horizontal part changes its sign where the plate leans to and away from north."""
    isotropic = []
    for heading_deg in (90.0, 270.0):
        poses, _ = gyro_poses(20.0, False, rate=rate, heading_deg=heading_deg, noise=0.1)
        fitted = fit(poses, WITH_G)
        isotropic.append(fitted.theta[fitted.model.slices()["g_sensitivity"]][::4].mean())
    as_rate = np.array(isotropic) * Site().gravity_m_s2 * np.sin(np.radians(20.0))
    vertical = Site().earth_rate()[2] * np.sin(np.radians(20.0))
    horizontal = Site().earth_rate()[0] * np.cos(np.radians(20.0))
    assert abs(as_rate.mean()) < 0.2 * vertical
    assert np.ptp(as_rate) / 2 == pytest.approx(horizontal, rel=0.1)


@pytest.mark.parametrize("changes", [
    {"wow": 7.0}, {"rate": -SLOW}, {"seed": 5},
], ids=["a bad drive", "clockwise", "another evening"])
def test_they_name_nothing_that_is_not_there(changes: dict[str, float]) -> None:
    poses, spec = gyro_poses(10.0, hide=False, **changes)  # type: ignore[arg-type]
    assert np.sqrt(np.mean(deviations(poses, hide=False) ** 2)) < 2
    said = assess(poses, Model.of(BASE), spec).diagnosis
    assert said.names == ()
    assert "g_sensitivity" not in said.blind


@pytest.mark.parametrize(("name", "times"), [("quadratic", 0.7), ("asymmetry", 0.65)])
def test_what_comes_twice_per_turn_shows_effects_of_attitude(name: str, times: float) -> None:
    """The sds of its elements, beside those without these rows."""
    poses = accelerometer_poses()
    assert poses.ring is not None
    once = poses.ring.sd.copy()
    once[:, 1] = np.nan
    model = Model.of([*BASE, name])
    both, without = (fit(some, model) for some in (
        poses, replace(poses, ring=replace(poses.ring, sd=once))))
    of_effect = model.slices()[name]
    ratio = np.sqrt(np.diag(both.cov)[of_effect] / np.diag(without.cov)[of_effect])
    assert ratio.max() < times
    assert both.equations.data_count == without.equations.data_count + 6 * len(poses)


def test_a_mounting_left_out_takes_its_waves_along() -> None:
    poses, _ = gyro_poses(10.0)
    without = poses.take(np.arange(1, len(poses)))
    assert without.ring is not None
    assert poses.ring is not None
    assert (without.ring.place == np.arange(len(without))).all()
    assert (without.ring.reading == poses.ring.reading[1:]).all()
    again = poses.take([0]).concat(without)
    assert again.ring is not None
    assert (again.ring.place == np.arange(len(poses))).all()


def test_a_pose_that_is_off_is_one_beside_poses_at_rest_too() -> None:
    """A bias of one pose alone has as many rows round a turn as that pose, wherever it stands."""
    design = tilted_design(8.0)
    design = replace(design, runs=(still_run(wedge_directions(), "stopped"), *design.runs))
    _, poses, _ = pose_sets(simulate(replace(design, sample_rate_hz=25.0), 1))
    assert poses.ring is not None
    off, place = np.array([0.0, 0.0, 2e-3]), int(poses.ring.place[2])
    reading, points = poses.reading.copy(), poses.ring.reading.copy()
    reading[place] += off
    points[2] += off
    moved = replace(poses, reading=reading, ring=replace(poses.ring, reading=points))
    base = fit(moved, Model.of(BASE))
    (odd,) = [h for h in by_clock(base) if h.kind == "bad_pose" and h.detail == poses.label[place]]
    assert odd.effect is not None
    found = extend(base, [odd.effect])
    assert found.theta[-3:] == pytest.approx(off, abs=3e-4)
