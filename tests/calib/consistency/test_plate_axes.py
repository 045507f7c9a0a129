"""The axes of both triads on the plate, on arrays of directions."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from calib.consistency.plate_axes import require_common_axes
from calib.errors import Contradiction
from calib.poses.imu_log import BoolArray, FloatArray
from calib.poses.pose_set import PoseSet
from tests.calib.made_poses import FAST, SLOW, made_poses

MISALIGNED = np.array([[1.0, -0.02, 0.01], [0.02, 1.0, -0.03], [-0.01, 0.03, 1.0]])
NOISE = 0.01


def turning() -> PoseSet:
    """Poses at two speeds, each in both directions."""
    return made_poses("gyroscope", (SLOW, -SLOW, FAST))


def rates(poses: PoseSet, matrix: FloatArray, member: BoolArray | None = None) -> FloatArray:
    """The calibrated rates, with noise, of some poses in other axes."""
    random = np.random.default_rng(5)
    seen = poses.reading @ MISALIGNED.T
    seen += NOISE * np.linalg.norm(seen, axis=1, keepdims=True) * random.normal(size=seen.shape)
    where = np.ones(len(poses), bool) if member is None else member
    seen[where] = seen[where] @ matrix.T
    return seen


def test_a_rotation_by_a_degree_and_noise_are_no_contradiction() -> None:
    poses = turning()
    require_common_axes(poses, rates(poses, np.eye(3)), {})
    require_common_axes(poses, rates(poses, np.eye(3)), {"run 0": 1.0, "run 1": -1.0})


@pytest.mark.parametrize(("matrix", "words"), [
    (np.eye(3)[[1, 0, 2]], "x and y are exchanged"),
    (np.eye(3)[[1, 2, 0]], "is logged as"),
    (np.diag([1.0, 1.0, -1.0]), "z has the opposite sign"),
])
def test_exchanged_and_mirrored_axes_are_named(matrix: FloatArray, words: str) -> None:
    poses = turning()
    with pytest.raises(Contradiction, match=words):
        require_common_axes(poses, rates(poses, matrix), {"run 0": 1.0})


def test_an_exchange_in_the_accelerometer_is_named_first_though_it_mirrors_the_turning() -> None:
    poses = turning()
    seen = rates(poses, np.eye(3)[[1, 0, 2]])
    with pytest.raises(Contradiction, match="accelerometer's, x and y are exchanged \\(in the"):
        require_common_axes(poses, seen, {"run 0": -1.0, "run 1": 1.0, "run 2": -1.0})


def test_all_axes_mirrored_show_only_where_the_accelerometer_shows_the_sense() -> None:
    poses = turning()
    mirrored = rates(poses, -np.eye(3))
    require_common_axes(poses, mirrored, {})  # the plate may have turned the other way
    with pytest.raises(Contradiction, match="all three axes have the opposite sign"):
        require_common_axes(poses, mirrored, {"run 0": 1.0, "run 1": -1.0, "run 2": 1.0})


def test_one_run_and_one_pose_are_named() -> None:
    poses = turning()
    swap = np.eye(3)[[1, 0, 2]]
    with pytest.raises(Contradiction, match=r"run 2: .*x and y are exchanged.*unlike"):
        require_common_axes(poses, rates(poses, swap, np.array(poses.run) == "run 2"), {})
    with pytest.raises(Contradiction, match=r"pose 8: .*It fits if in its .* axes all"):
        require_common_axes(poses, rates(poses, -np.eye(3), np.arange(len(poses)) == 7), {})


def test_a_constant_in_one_pose_is_no_exchange_of_axes() -> None:
    """Whatever its size and direction: turned by it, the pose fits in no other axes."""
    poses, wrong = turning(), 0
    for seed in range(100):
        random = np.random.default_rng(seed)
        seen, i = rates(poses, np.eye(3)), int(random.integers(len(poses)))
        seen[i] += random.uniform(0.5, 4) * np.linalg.norm(seen[i]) * random.standard_normal(3)
        try:
            require_common_axes(poses, seen, {})
        except Contradiction as error:
            wrong += "not readings of one pose" not in str(error)
    assert wrong <= 6


def test_directions_of_other_poses_fit_no_rotation() -> None:
    poses = turning()
    turns = Rotation.from_rotvec(np.random.default_rng(1).normal(size=(len(poses), 3)))
    elsewhere = replace(poses, force=turns.apply(poses.force))
    with pytest.raises(Contradiction, match="no rotation joins"):
        require_common_axes(elsewhere, rates(poses, np.eye(3)), {})


def test_too_few_poses_or_directions_say_nothing() -> None:
    poses = turning()
    few, swap = poses.take(range(5)), np.eye(3)[[1, 0, 2]]
    require_common_axes(few, rates(few, swap), {})
    flat = poses.take([0] * 10)
    require_common_axes(flat, rates(flat, swap), {})
