"""The plate's rate by gravity's wave in the accelerometer, on logs of a leaning plate."""

import numpy as np
import pytest

from calib.consistency.clock import gravity_wave, require_whole_turns
from calib.errors import Contradiction
from calib.numbers import RPM
from calib.poses.data_sheet import TriadSpec
from calib.poses.imu_log import ImuLog, Triad

G = 9.80665
SPEC = TriadSpec(2 * G, 16, "twos-complement")
GYRO = TriadSpec(np.radians(250.0), 16, "twos-complement")
BOTH: dict[Triad, TriadSpec] = {"accelerometer": SPEC, "gyroscope": GYRO}
STATED = 100 / 3 * RPM
LEAN = np.radians(1.0)


def logs(
    rate: float, *, seconds: float = 20.0, lean: float = LEAN, stretch: float = 1.0, seed: int = 3
) -> list[ImuLog]:
    """Three poses, turned about their x axis, on a plate at ``rate`` rad/s, positive ccw."""
    random = np.random.default_rng(seed)
    time_s = np.arange(0.0, seconds, 0.02)
    made = []
    for i, tilt in enumerate((0.0, 0.6, 2.0)):
        angle = rate * time_s + i  # gravity goes round against the plate
        up = np.stack([np.sin(lean) * np.cos(angle), -np.sin(lean) * np.sin(angle),
                       np.full(len(angle), np.cos(lean))], axis=1)
        c, s = np.cos(tilt), np.sin(tilt)
        turn = np.array([[1.0, 0.0, 0.0], [0.0, c, -s], [0.0, s, c]])
        force = (G * up + 0.02 * random.normal(size=up.shape)) @ turn.T
        spin = np.tile(rate * turn[:, 2], (len(time_s), 1))
        made.append(ImuLog(f"pose_{i}", time_s * stretch, np.round(force / SPEC.nominal_scale),
                           np.round(spin / GYRO.nominal_scale)))
    return made


@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_rate_and_sense_are_those_of_the_plate(sense: float) -> None:
    wave = gravity_wave(logs(sense * STATED), np.full(3, STATED), SPEC)
    assert wave is not None
    assert wave.is_clear
    assert wave.rate == pytest.approx(sense * STATED, rel=0.02)
    assert wave.sense == sense


def test_a_level_plate_and_a_pose_of_one_turn_say_nothing() -> None:
    level = gravity_wave(logs(STATED, lean=0.0), np.full(3, STATED), SPEC)
    assert level is not None
    assert not level.is_clear
    assert gravity_wave(logs(STATED, seconds=2.0), np.full(3, STATED), SPEC) is None


def test_rpm_stated_as_rad_s_are_told() -> None:
    with pytest.raises(Contradiction, match=r"33\.33 rpm are 3\.491 rad/s\. State the rate"):
        require_whole_turns("33rpm", logs(STATED), np.full(3, STATED / RPM), BOTH, {})


@pytest.mark.parametrize(("stretch", "said"), [
    (2.0, r"1\.99 times too fast"), (0.5, r"2(\.0\d)? times too slowly")])
def test_stamps_that_are_not_seconds_are_told_by_the_gyroscope(stretch: float, said: str) -> None:
    with pytest.raises(Contradiction, match=f"do not count seconds: they run {said}"):
        require_whole_turns("17rpm", logs(STATED, stretch=stretch), np.full(3, STATED),
                            BOTH, {})


def test_the_rate_of_another_setting_is_named() -> None:
    slow = np.full(3, STATED / 2)
    with pytest.raises(Contradiction, match="That is the rate of '33rpm'"):
        require_whole_turns("17rpm", logs(STATED), slow, BOTH, {"33rpm": STATED})
    with pytest.raises(Contradiction, match="Either the rate belongs to another run"):
        require_whole_turns("17rpm", logs(STATED), slow, {"accelerometer": SPEC}, {})


def test_the_stated_rate_and_an_oscillator_off_by_three_per_cent_are_no_contradiction() -> None:
    for off in (1.0, 1.03):
        wave = require_whole_turns("33rpm", logs(STATED * off), np.full(3, STATED), BOTH,
                                   {})
        assert wave is not None
