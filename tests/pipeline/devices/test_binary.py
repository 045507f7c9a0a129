"""Twelve bytes a sample with no start sign: the phase is found, kept, and found again."""

import numpy as np
import pytest

from pipeline.devices.mpu6050_binary import Mpu6050BinaryParser
from tests.world.designs import paper_design
from tests.world.imu import mpu6050
from tests.world.session import simulate


@pytest.fixture(scope="module")
def poses() -> np.ndarray:
    """Words (p, n, 6) of 18 poses at rest, as the chip gives them."""
    run = simulate(paper_design(mpu6050()), seed=5).runs[0]
    return np.concatenate([run.accelerometer, run.gyroscope], axis=2)


def stream(words: np.ndarray) -> bytes:
    return words.astype(">i2").tobytes()


def read(parser: Mpu6050BinaryParser, data: bytes, piece: int = 97) -> np.ndarray:
    samples = [s for i in range(0, len(data), piece) for s in parser.feed(data[i : i + piece])]
    return np.array([(*s.accelerometer, *s.gyroscope) for s in samples])


def test_readings_begin_where_the_greeting_ends(poses: np.ndarray) -> None:
    greeting = (b"Initializing I2C devices...\r\nTesting device connections...\r\n"
                b"MPU6050 connection successful\r\n")
    for pose in poses:
        found = read(Mpu6050BinaryParser(), greeting + stream(pose))
        np.testing.assert_array_equal(found, pose)


@pytest.mark.parametrize("cut", range(12))
def test_without_the_greeting_the_phase_comes_from_poses_that_show_it(
    poses: np.ndarray, cut: int
) -> None:
    locked = 0
    for pose in poses:
        parser = Mpu6050BinaryParser()
        found = read(parser, stream(pose)[cut:])
        if len(found):  # never a wrong phase: a pose that does not show it yields nothing
            locked += 1
            np.testing.assert_array_equal(found[-50:], pose[-50:])
        else:
            assert "reset button" in parser.advice
    assert locked >= 6


@pytest.mark.parametrize("lost", range(1, 12))
def test_lost_bytes_are_noticed_in_a_pose_that_shows_it(poses: np.ndarray, lost: int) -> None:
    parser = Mpu6050BinaryParser()
    pose = next(p for p in poses if len(read(Mpu6050BinaryParser(), stream(p))))
    whole = stream(pose)
    found = read(parser, whole[:1200] + whole[1200 + lost :])
    assert parser.bad >= 1
    np.testing.assert_array_equal(found[-50:], pose[-50:])
