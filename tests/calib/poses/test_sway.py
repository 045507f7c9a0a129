"""A pose that rocks: its mean is short of gravity, its sd knows it, and much of it is refused."""

import numpy as np
import pytest

from calib.errors import Undetermined
from calib.poses.averaging.average_pose import average_pose
from calib.poses.averaging.mean_noise import pose_mean_sd
from calib.poses.averaging.pose_mean import PoseMean
from calib.poses.averaging.sway import check_calm
from calib.poses.data_sheet import TriadSpec
from calib.poses.imu_log import TRIADS, ImuLog
from calib.poses.pose_set import pose_set
from calib.poses.runs.reference_runs import gravity_run

G = 9.8
SI = TriadSpec(np.inf, 0, "si")
NOISE_M_S2 = 0.02
TIME_S = np.arange(0.0, 8.0, 0.01)


def rocking(degrees: float, shake_m_s2: float = 0.0, *, gyro: bool = True, seed: int = 1) -> ImuLog:
    """A pose that swings about x twice a second by an amplitude, or is shaken along x."""
    rng = np.random.default_rng(seed)
    angle = np.radians(degrees) * np.sin(4 * np.pi * TIME_S)
    force = G * np.column_stack([0 * angle, np.sin(angle), np.cos(angle)])
    force[:, 0] += shake_m_s2 * np.sin(40 * np.pi * TIME_S)
    rate = np.zeros((len(TIME_S), 3))
    rate[:, 0] = np.gradient(angle, TIME_S)
    return ImuLog(f"pose {seed}", TIME_S, force + rng.normal(0, NOISE_M_S2, force.shape),
                  rate + (rng.normal(0, 2e-3, rate.shape) if gyro else np.nan))


def averaged(log: ImuLog) -> PoseMean:
    return average_pose(log, dict.fromkeys(TRIADS, SI))


@pytest.mark.parametrize("gyro", [True, False])
@pytest.mark.parametrize("degrees", [1.0, 3.0, 4.5])
def test_the_sd_of_a_rocking_pose_covers_what_its_mean_lacks(degrees: float, gyro: bool) -> None:
    still = [averaged(rocking(0.0, gyro=gyro, seed=seed)) for seed in range(2, 12)]
    pose = averaged(rocking(degrees, gyro=gyro))
    lacking = G - np.linalg.norm(pose.accelerometer.mean)
    assert lacking == pytest.approx(G * np.radians(degrees) ** 2 / 4, abs=3e-3)
    sd = pose_mean_sd([[pose, *still]], "accelerometer")
    assert lacking - 2e-3 < sd[0].min() < 1.5 * lacking + 3e-3
    assert sd[1:].max() < 3e-3


def test_a_pose_that_rocks_by_five_degrees_is_refused() -> None:
    with pytest.raises(Undetermined, match=r"pose 1: the sensor was shaken: .* rocks by 5\.[67]°"):
        averaged(rocking(8.0))


def test_readings_that_are_no_gravity_are_left_to_the_check_of_their_unit() -> None:
    """Counts that are called g and °/s: 16384 g, of which the noise would be a rocking of 1°."""
    check_calm("pose 1", np.full(3, 320.0**2), 0.02**2, 16384 * G, 0.02)
    with pytest.raises(Undetermined, match="shaken"):
        check_calm("pose 1", np.full(3, 0.6**2), 0.08**2, G, 0.02)


def test_vibration_along_a_line_keeps_its_weight_where_the_gyroscope_rests_and_is_said() -> None:
    means = [averaged(rocking(0.0, shake_m_s2=2.0 * (seed == 3), seed=seed))
             for seed in range(2, 20)]
    sd = pose_mean_sd([means], "accelerometer")
    assert sd[1].max() < 0.01  # rocking by as much would make it 0.1 m/s² short
    (note,) = [each for each in pose_set("accelerometer", [gravity_run("rest", means, G, 0.0)],
                                         0.0).notes if "shaken" in each]
    assert "pose 3" in note
    assert "1.4 m/s²" in note
