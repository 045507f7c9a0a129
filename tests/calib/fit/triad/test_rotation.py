"""Rotations of numpy alone against SciPy's, also by half a turn and by next to nothing."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from calib.fit.triad.rotation import cross_matrix, nearest_rotation, rotation_vector

AXES = Rotation.random(20, rng=1).apply([0.0, 0.0, 1.0])


@pytest.mark.parametrize("angle", [1e-12, 1e-7, 1e-3, 0.4, 2.0, 3.1, np.pi - 1e-9])
def test_the_vector_of_a_rotation_is_its_axis_times_its_angle(angle: float) -> None:
    for axis in AXES:
        matrix = Rotation.from_rotvec(angle * axis).as_matrix()
        assert rotation_vector(matrix) == pytest.approx(angle * axis, abs=2e-15 + 1e-15 * angle)


def test_half_a_turn_about_an_axis_has_a_vector_along_it() -> None:
    for axis in np.eye(3):
        vector = rotation_vector(2 * np.outer(axis, axis) - np.eye(3))
        assert np.abs(vector) == pytest.approx(np.pi * axis, abs=1e-12)
    assert rotation_vector(np.eye(3)).tolist() == [0, 0, 0]


def test_the_nearest_rotation_of_pairs_of_directions_is_that_of_least_squares() -> None:
    random = np.random.default_rng(2)
    for turn in Rotation.random(10, rng=3):
        n = random.normal(size=(8, 3))
        f = turn.apply(n) + 0.1 * random.normal(size=(8, 3))
        expected, _ = Rotation.align_vectors(f, n)
        assert nearest_rotation(f.T @ n) == pytest.approx(expected.as_matrix(), abs=1e-12)


def test_pairs_in_one_plane_have_a_rotation_and_no_reflection() -> None:
    n = np.array([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.0]])
    turn = Rotation.from_rotvec([0.3, -0.2, 1.0]).as_matrix()
    assert nearest_rotation((n @ turn.T).T @ n) == pytest.approx(turn, abs=1e-12)


def test_the_cross_matrix_is_the_cross_product() -> None:
    a, b = np.random.default_rng(4).normal(size=(2, 3))
    assert cross_matrix(a) @ b == pytest.approx(np.cross(a, b))
