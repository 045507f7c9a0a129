"""A bias that follows the temperature is no motion, and a sensor that moved stays one that did."""

import numpy as np
import pytest

from calib.poses.averaging.average_pose import average_pose
from calib.poses.averaging.drift_within import average_poses
from calib.poses.averaging.pose_mean import PoseMean
from calib.poses.checks.pose_checks import SensorMoved
from calib.poses.data_sheet import TriadSpec
from calib.poses.imu_log import FloatArray, ImuLog
from tests.world.bench import wedge_directions

SI = TriadSpec(np.inf, 0, "si")
NOISE, SAMPLES, SECONDS = 0.03, 800, 8.0


def pose(
    i: int, per_kelvin: FloatArray, kelvin: float, turn_deg: float = 0.0, logged: bool = True
) -> ImuLog:
    """A pose at rest that warms by ``kelvin`` and is turned half way through."""
    rng = np.random.default_rng([i, 3])
    time_s = np.linspace(0.0, SECONDS, SAMPLES) + 20.0 * i
    warmth = kelvin * np.linspace(-0.5, 0.5, SAMPLES)
    up = np.tile(wedge_directions()[i], (SAMPLES, 1))
    axis = np.cross(up[0], [0.3, 0.5, 0.8])
    up[SAMPLES // 2 :] += np.deg2rad(turn_deg) * axis / np.linalg.norm(axis)
    force = 9.81 * up + warmth[:, None] * per_kelvin + NOISE * rng.standard_normal((SAMPLES, 3))
    noisy = 30.0 + i + warmth + 0.01 * rng.standard_normal(SAMPLES)
    columns = {"temperature_c": noisy} if logged else {}
    return ImuLog(f"pose_{i}", time_s, force, np.full((SAMPLES, 3), np.nan), columns)


def averaged(logs: list[ImuLog]) -> list[PoseMean]:
    return average_poses(logs, {"accelerometer": SI}, [0.0] * len(logs))


PER_KELVIN = np.array([0.4, -0.9, 0.2])
WARMING_K = [0.08, 0.05, -0.06, 0.07, 0.09, -0.04, 0.06, 0.1]


@pytest.mark.parametrize("logged", [True, False])
def test_poses_that_warm_are_poses(logged: bool) -> None:
    """Without a log of the temperature the poses must at least drift alike with time."""
    warming = WARMING_K if logged else [0.08] * len(WARMING_K)
    logs = [pose(i, PER_KELVIN, kelvin, logged=logged) for i, kelvin in enumerate(warming)]
    with pytest.raises(SensorMoved, match="accelerometer y strays"):
        average_pose(logs[0], {"accelerometer": SI})
    still = averaged([pose(i, 0 * PER_KELVIN, 0.0) for i in range(len(logs))])
    for drifted, same in zip(averaged(logs), still, strict=True):
        assert drifted.accelerometer.mean == pytest.approx(same.accelerometer.mean, abs=2e-3)


def test_a_pose_that_moved_is_refused_among_poses_that_warm() -> None:
    for warming in (WARMING_K, [0.0] * len(WARMING_K)):
        logs = [pose(i, PER_KELVIN, kelvin, turn_deg=0.6 if i == 3 else 0.0)
                for i, kelvin in enumerate(warming)]
        with pytest.raises(SensorMoved, match="pose_3: the sensor moved"):
            averaged(logs)


def test_too_few_other_poses_show_no_drift() -> None:
    logs = [pose(i, PER_KELVIN, kelvin) for i, kelvin in enumerate(WARMING_K)]
    with pytest.raises(SensorMoved, match="pose_0"):
        averaged(logs[:3])
