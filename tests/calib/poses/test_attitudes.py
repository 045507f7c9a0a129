"""Directions on the sphere, and what they are called."""

import numpy as np
import pytest

from calib.poses.attitudes import direction_name, natural_directions, spread_directions


def test_each_natural_direction_has_a_name_of_its_own() -> None:
    names = [direction_name(direction) for direction in natural_directions()]
    assert len(set(names)) == 26
    assert names[0] == "-x up"
    assert sum(name.startswith("edge") for name in names) == 12
    assert sum(name.startswith("corner") for name in names) == 8


@pytest.mark.parametrize(("direction", "name"), [
    ((0.94, 0.33, 0.05), "+x up"),  # 20° from it, 26° from the edge
    ((0.92, 0.40, 0.0), "edge +x +y up"),
    ((0.72, 0.62, 0.31), "corner +x +y +z up"),  # 17.6° from it, 18.5° from the edge
    ((0.72, 0.63, 0.29), "edge +x +y up"),
])
def test_a_direction_is_called_by_the_nearest_natural_one(
    direction: tuple[float, float, float], name: str
) -> None:
    vector = np.array(direction)
    assert direction_name(vector / np.linalg.norm(vector)) == name


def test_spread_directions_are_unit_vectors_that_favour_no_side() -> None:
    directions = spread_directions(200)
    assert np.linalg.norm(directions, axis=1) == pytest.approx(np.ones(200))
    assert directions.T @ directions / 200 == pytest.approx(np.eye(3) / 3, abs=0.002)
