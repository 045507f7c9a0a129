"""Logs that no Allan deviation should be made of are refused, with the place."""

import numpy as np
import pytest

from calib.errors import Undetermined
from calib.noise.stillness import require_still, sample_step_s
from calib.poses.imu_log import ImuLog

COUNT = 6000
TIME_S = np.arange(COUNT) / 50


def a_log(time_s: np.ndarray = TIME_S) -> ImuLog:
    readings = np.random.default_rng(0).standard_normal((len(time_s), 3))
    return ImuLog("still.csv", time_s, readings + np.array([0, 0, 9.8]), 0.01 * readings)


def test_too_short_says_how_long() -> None:
    with pytest.raises(Undetermined, match=r"999 samples; at least 1000 .* hours for bias"):
        sample_step_s(a_log(TIME_S[:999]))


def test_a_gap_is_named_with_the_part_that_is_whole() -> None:
    gapped = TIME_S + 3.0 * (np.arange(COUNT) >= 2000)
    with pytest.raises(Undetermined, match=r"1 gap .* 3.02 s at 39.98 s.*43 to 122.98 s"):
        sample_step_s(a_log(gapped))


def test_bursts_of_a_serial_port_are_no_gaps() -> None:
    late = 0.1 * (np.arange(COUNT) // 5) + 1e-3 * (np.arange(COUNT) % 5)
    assert sample_step_s(a_log(late)) == pytest.approx(0.02, rel=1e-3)


@pytest.mark.parametrize("change", ["tilt", "knock"])
def test_a_movement_is_named_with_its_time(change: str) -> None:
    log = a_log()
    readings = log.accelerometer.copy()
    if change == "tilt":
        readings[3000:, 1] += 4.0
    else:
        readings[3000:3020, 1] += 40.0 * np.sin(np.arange(20))
    require_still(log, "accelerometer", log.accelerometer, 0.02)
    with pytest.raises(Undetermined, match=r"not still: the accelerometer y moves after 60 s"):
        require_still(log, "accelerometer", readings, 0.02)


def test_a_turning_plate_and_a_stuck_axis_are_no_rest() -> None:
    log = a_log()
    with pytest.raises(Undetermined, match=r"turns at 99.2 °/s"):
        require_still(log, "gyroscope", log.gyroscope + 1.0, 0.02)
    with pytest.raises(Undetermined, match="gyroscope x reads the same"):
        require_still(log, "gyroscope", log.gyroscope * [0.0, 1.0, 1.0], 0.02)
