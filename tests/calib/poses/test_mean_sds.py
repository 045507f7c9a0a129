"""Sds of pose means where poses are not alike: held in a hand, or giving way as a whole."""

import numpy as np
import pytest

from calib.poses.averaging.average_pose import average_pose
from calib.poses.averaging.mean_noise import pose_mean_sd, shared_dof
from calib.poses.averaging.pose_mean import PoseMean
from calib.poses.data_sheet import TriadSpec
from calib.poses.imu_log import TRIADS, FloatArray, ImuLog

IN_SI = TriadSpec(np.inf, 0, "si")
RATE_HZ, SECONDS, NOISE = 100.0, 4.0, 1e-3
TIME_S = np.arange(round(SECONDS * RATE_HZ)) / RATE_HZ


def averaged(values: FloatArray, gyroscope: FloatArray | None = None) -> PoseMean:
    blank = np.full_like(values, np.nan)
    log = ImuLog("pose", TIME_S, values, blank if gyroscope is None else gyroscope)
    limit = {"accelerometer": 1.0, "gyroscope": 1.0}
    return average_pose(log, dict.fromkeys(TRIADS, IN_SI), 0.0, limit)


@pytest.mark.parametrize("spread", [0.0, 0.7, 1.5])
def test_sds_hold_for_every_pose_however_unlike_the_poses_are(spread: float) -> None:
    """``spread`` is that of the logarithm of the noise over the poses."""
    rng = np.random.default_rng(1)
    scores, noisiest = [], []
    for _ in range(24):
        noise = NOISE * np.exp(spread * rng.standard_normal(20))
        means = [averaged(9.8 + sd * rng.standard_normal((len(TIME_S), 3))) for sd in noise]
        z = np.array([m.accelerometer.mean - 9.8 for m in means]) / pose_mean_sd(
            [means], "accelerometer")
        scores.append(z)
        noisiest.append(z[np.argsort(noise)[-5:]])
    # A fixed weight of the other poses leaves 0.83 and 0.78 of the noisiest within their sds.
    assert 0.88 < np.mean(np.abs(np.array(noisiest)) < 1.96) < 0.98
    assert np.mean(np.abs(np.array(scores)) < 1.96) > 0.94


def test_poses_that_are_alike_count_for_each_other_and_unlike_ones_do_not() -> None:
    rng = np.random.default_rng(2)
    alike = rng.chisquare(5, (40, 3)) / 5
    unlike = alike * 2.0 / rng.chisquare(2, (40, 3))
    assert shared_dof(alike) > 12
    assert 1.2 < shared_dof(unlike) < 4
    assert shared_dof(alike[:1]) == 0.0


@pytest.mark.parametrize("turn_deg_s", [0.0, 0.1])
def test_a_gyroscope_in_a_pose_that_gives_way_is_known_as_badly_as_it_turned(
    turn_deg_s: float
) -> None:
    """The pose tips about a level axis all the while; what the gyroscope reads is no bias."""
    rng = np.random.default_rng(3)
    turn = np.radians(turn_deg_s)
    means = []
    for _ in range(20):
        angle, axis = turn * (TIME_S - TIME_S.mean()), rng.uniform(0, 2 * np.pi)
        level = np.array([np.cos(axis), np.sin(axis), 0.0])
        up = np.cross(np.array([0.0, 0.0, 1.0]), level)
        force = 9.8 * (np.cos(angle)[:, None] * [0, 0, 1] + np.sin(angle)[:, None] * up)
        rate = turn * level + 1e-4 * rng.standard_normal((len(TIME_S), 3))
        means.append(averaged(force + NOISE * rng.standard_normal(force.shape), rate))
    sd = pose_mean_sd([means], "gyroscope")
    error = np.array([mean.gyroscope.mean for mean in means])
    if turn == 0.0:
        assert sd.max() < 3e-5
    assert np.mean(np.abs(error) < 1.96 * sd) > 0.94
    assert np.median(sd) == pytest.approx(max(turn / np.sqrt(2), 5e-6), rel=0.4)
