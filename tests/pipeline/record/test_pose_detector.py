"""The judgement of a guided recording: what is a pose, and what is refused in which words."""

import numpy as np
import pytest

from calib.poses.attitudes import natural_directions
from calib.poses.data_sheet import TriadSpec
from pipeline.record.blocks import Complete, Refused, Task
from pipeline.record.pose_detector import PoseDetector
from pipeline.record.stream import TimedSample

SPECS = {"accelerometer": TriadSpec(19.6, 16, "twos-complement"),
         "gyroscope": TriadSpec(4.36, 16, "twos-complement")}
RATE_HZ = 100.0
WEDGE = natural_directions(corners=False)
PLATE = 1.745


def task(rate: float | None = 0.0, rest: np.ndarray | None = None, seconds: float = 4.0) -> Task:
    return Task(WEDGE, SPECS, seconds, rate, rest)


def rows(up: np.ndarray, seconds: float, rng: np.random.Generator, rate: float | np.ndarray = 0.0,
         acc_sd: float = 0.03, gyr_sd: float = 0.002) -> list[TimedSample]:
    """Readings with ``up`` facing up; ``rate`` of the plate, a number or one for each sample."""
    n = round(seconds * RATE_HZ)
    force = 9.8 * up + acc_sd * rng.standard_normal((n, 3))
    turn = np.broadcast_to(rate, n)[:, None] * up + gyr_sd * rng.standard_normal((n, 3))
    acc, gyr = (v / spec.nominal_scale
                for v, spec in zip((force, turn), SPECS.values(), strict=True))
    return [TimedSample(i, i, i / RATE_HZ, tuple(a), tuple(g), ())
            for i, (a, g) in enumerate(zip(acc.tolist(), gyr.tolist(), strict=True))]


def hand(seconds: float, rng: np.random.Generator) -> list[TimedSample]:
    return rows(WEDGE[0], seconds, rng, acc_sd=2.0, gyr_sd=0.5)


@pytest.fixture
def rng() -> np.random.Generator:
    return np.random.default_rng(1)


def test_a_sensor_that_lies_still_makes_a_pose_of_the_length_asked_for(
    rng: np.random.Generator,
) -> None:
    guide = PoseDetector(task(), RATE_HZ)
    (pose,) = guide.feed(hand(2, rng) + rows(WEDGE[4], 6, rng))
    assert isinstance(pose, Complete)
    assert pose.direction == 4
    assert len(pose.rows) == 400
    readings = [row.accelerometer for row in pose.rows]
    assert np.ptp(readings, axis=0).max() < 500  # nothing of the hand


def test_every_wanted_direction_is_recognised(rng: np.random.Generator) -> None:
    guide = PoseDetector(task(), RATE_HZ)
    for i, up in enumerate(WEDGE):
        tilted = up + 0.15 * rng.standard_normal(3) / np.sqrt(3)
        (pose,) = guide.feed(hand(1.5, rng) + rows(tilted / np.linalg.norm(tilted), 6, rng))
        assert isinstance(pose, Complete)
        assert pose.direction == i
        guide.accept(i)
    assert guide.next_direction is None


def test_a_pose_that_is_moved_is_refused_with_the_time(rng: np.random.Generator) -> None:
    guide = PoseDetector(task(), RATE_HZ)
    (refused,) = guide.feed(rows(WEDGE[2], 3, rng) + hand(1, rng))
    assert isinstance(refused, Refused)
    assert "moved after 2" in refused.message


def test_a_tap_of_a_tenth_of_a_second_is_noticed(rng: np.random.Generator) -> None:
    guide = PoseDetector(task(), RATE_HZ)
    tap = rows(WEDGE[2], 0.1, rng, acc_sd=1.5)
    events = guide.feed([*rows(WEDGE[2], 3, rng), *tap, *rows(WEDGE[2], 1, rng)])
    assert any(isinstance(event, Refused) for event in events)


def test_a_direction_is_not_taken_twice(rng: np.random.Generator) -> None:
    guide = PoseDetector(task(), RATE_HZ, covered=[3])
    assert guide.feed(hand(2, rng) + rows(WEDGE[3], 6, rng)) == []
    assert guide.status.phase == "repeats"
    assert "is taken already; next: " in guide.status.message


def test_one_pose_is_taken_once_however_long_it_lies_there(rng: np.random.Generator) -> None:
    guide = PoseDetector(task(), RATE_HZ)
    (pose,) = guide.feed(rows(WEDGE[5], 30, rng))
    assert isinstance(pose, Complete)
    guide.accept(pose.direction)
    assert guide.feed(rows(WEDGE[5], 5, rng)) == []
    assert guide.status.phase == "taken"


def test_a_pose_rejected_as_a_whole_may_be_tried_again_at_once(rng: np.random.Generator) -> None:
    guide = PoseDetector(task(), RATE_HZ)
    guide.feed(rows(WEDGE[5], 6, rng))
    guide.reject()
    (again,) = guide.feed(rows(WEDGE[5], 6, rng))
    assert isinstance(again, Complete)


def test_a_careful_hand_that_is_never_seen_to_move_still_makes_the_next_pose(
    rng: np.random.Generator,
) -> None:
    guide = PoseDetector(task(), RATE_HZ)
    (first,) = guide.feed(rows(WEDGE[0], 6, rng))
    assert isinstance(first, Complete)
    guide.accept(first.direction)
    (second,) = guide.feed(rows(WEDGE[1], 8, rng))
    assert isinstance(second, Complete)
    assert second.direction == 1


def test_between_two_directions_the_angle_is_told(rng: np.random.Generator) -> None:
    corner = np.ones(3) / np.sqrt(3)
    guide = PoseDetector(task(), RATE_HZ)
    assert guide.feed(rows(corner, 6, rng)) == []
    assert guide.status.phase == "between"
    assert "35° from the nearest" in guide.status.message


@pytest.mark.parametrize(("rate", "message"), [
    (0.0, "does not turn"), (np.linspace(1.4, PLATE, 600), "speeds up"),
    (np.linspace(PLATE, 1.4, 600), "slows down"), (2 * PLATE, "the configuration says 16.7"),
])
def test_a_plate_that_is_not_steady_is_told(
    rng: np.random.Generator, rate: float | np.ndarray, message: str
) -> None:
    guide = PoseDetector(task(PLATE, np.zeros(3)), RATE_HZ)
    assert guide.feed(rows(WEDGE[0], 6, rng, rate)) == []
    assert guide.status.phase == "unsteady"
    assert message in guide.status.message


def test_a_steady_plate_makes_a_pose(rng: np.random.Generator) -> None:
    guide = PoseDetector(task(PLATE), RATE_HZ)
    (pose,) = guide.feed(rows(WEDGE[0], 8, rng, PLATE))
    assert isinstance(pose, Complete)


def test_a_tilted_plate_that_was_at_rest_before_makes_a_pose(rng: np.random.Generator) -> None:
    """Its readings swing with every turn, and are noisier than those at rest were."""
    guide = PoseDetector(task(PLATE), RATE_HZ)
    at_rest = rows(WEDGE[0], 20, rng, acc_sd=0.01, gyr_sd=0.001)
    seconds = np.arange(800) / RATE_HZ
    swing = 0.15 * np.cos(PLATE * seconds)[:, None] * WEDGE[2]
    swing /= SPECS["accelerometer"].nominal_scale
    turning = [
        TimedSample(row.index, row.ticks, row.heard_s, tuple(np.add(row.accelerometer, extra)),
            row.gyroscope, ())
        for row, extra in zip(rows(WEDGE[0], 8, rng, PLATE), swing, strict=True)
    ]
    assert guide.feed(at_rest) == []
    (pose,) = guide.feed(hand(1, rng) + turning)
    assert isinstance(pose, Complete)


def test_at_rest_a_turning_plate_is_told(rng: np.random.Generator) -> None:
    guide = PoseDetector(task(0.0, np.zeros(3)), RATE_HZ)
    assert guide.feed(rows(WEDGE[0], 6, rng, PLATE)) == []
    assert "stop it" in guide.status.message


def test_readings_of_another_sensor_are_told(rng: np.random.Generator) -> None:
    guide = PoseDetector(task(), RATE_HZ)
    assert guide.feed(rows(WEDGE[0] / 5, 6, rng)) == []
    assert "check sensor.accelerometer" in guide.status.message


def test_a_gyro_alone_tells_the_direction_on_the_plate(rng: np.random.Generator) -> None:
    alone = Task(WEDGE, {"gyroscope": SPECS["gyroscope"]}, 4.0, PLATE, None)
    guide = PoseDetector(alone, RATE_HZ)
    (pose,) = guide.feed(rows(WEDGE[7], 8, rng, PLATE))
    assert isinstance(pose, Complete)
    assert pose.direction == 7
