"""The 26 natural directions: which of them the poses cover, and their names.

A direction is the one in which the measured vector points in the sensor's own axes: for a still
accelerometer the side that faces up, for a gyro on the plate the side that faces up when the plate
turns counter-clockwise. The 6 faces and 12 edges are the wedge poses of Angrisano et al.; the 8
corners complete them.
"""

from collections.abc import Iterable
from itertools import product

import numpy as np

from calib.poses.imu_log import AXES, FloatArray, Triad
from calib.poses.triad_kind import TRIAD_KINDS

NEAR_COSINE = float(np.cos(np.radians(25.0)))
"""Largest angle, 25°, to a direction that a pose covers. Derived: the neighbours are 35 to 45°
apart, so that no pose covers two opposite ones, and every pose covers one.
"""

WEDGE_DIRECTIONS = 18  #: the 6 faces and 12 edges, the first of the natural ones; definition


def natural_directions(corners: bool = True) -> FloatArray:
    """The unit vectors of 6 faces, 12 edges and (``corners``) 8 corners, in this order.

    Parameters
    ----------
    corners : bool
        Whether the corners are among them.

    Returns
    -------
    array, shape (26, 3) or (18, 3)
    """
    signs = np.array([s for s in product((-1, 0, 1), repeat=3) if any(s)], dtype=float)
    count = np.abs(signs).sum(axis=1)
    chosen = signs[np.argsort(count, kind="stable")]
    if not corners:
        chosen = chosen[np.abs(chosen).sum(axis=1) < 3]
    return np.asarray(chosen / np.linalg.norm(chosen, axis=1, keepdims=True))


def spread_directions(count: int) -> FloatArray:
    """Unit vectors spread evenly over the sphere (Fibonacci's spiral).

    Returns
    -------
    array, shape (count, 3)
    """
    i = np.arange(count) + 0.5
    z = 1 - 2 * i / count
    azimuth = np.pi * (1 + np.sqrt(5)) * i
    radius = np.sqrt(1 - z**2)
    return np.stack([radius * np.cos(azimuth), radius * np.sin(azimuth), z], axis=1)


def two_across(directions: FloatArray) -> FloatArray:
    """Two unit vectors across each of ``directions`` (n, 3), and across each other, (n, 2, 3)."""
    first = np.cross(directions, np.eye(3)[np.argmin(np.abs(directions), axis=1)])
    first /= np.linalg.norm(first, axis=1, keepdims=True)
    return np.stack([first, np.cross(directions, first)], axis=1)


def nearest_faces(directions: FloatArray) -> tuple[FloatArray, FloatArray]:
    """The faces and edges of a cube nearest to ``directions`` (n, 3), and the angles to them.

    Returns
    -------
    nearest : array, shape (n, 3)
        Unit vectors.
    angle_rad : array, shape (n,)
        Between each direction and the nearest.
    """
    unit = directions / np.linalg.norm(directions, axis=1, keepdims=True)
    cosines = unit @ natural_directions(corners=False).T
    nearest = natural_directions(corners=False)[cosines.argmax(axis=1)]
    return nearest, np.arccos(np.clip(cosines.max(axis=1), -1.0, 1.0))


def direction_name(direction: FloatArray, triad: Triad = "accelerometer") -> str:
    """Name of a direction: ``+x up``, ``edge +x -z up``, ``corner +x -y +z up``.

    Parameters
    ----------
    direction : array, shape (3,)
        Unit vector; the nearest of :func:`natural_directions` gives the name.
    triad : str
        Which one's vector it is: those of the first two stand upright, on a level plate.
    """
    natural = natural_directions()
    nearest = natural[int(np.argmax(natural @ direction))]
    parts = [
        f"{'+' if value > 0 else '-'}{axis}"
        for axis, value in zip(AXES, nearest, strict=True)
        if value
    ]
    kind = ("", "edge ", "corner ")[len(parts) - 1]
    return f"{kind}{' '.join(parts)} {TRIAD_KINDS[triad].along}"


def uncovered(directions: FloatArray, wanted: FloatArray) -> FloatArray:
    """The ``wanted`` directions with no pose near them.

    Parameters
    ----------
    directions : array, shape (n, 3)
        Vectors of any length, those of the poses.
    wanted : array, shape (m, 3)
        Unit vectors.

    Returns
    -------
    array, shape (k, 3)
        Unit vectors in the order of ``wanted``.
    """
    unit = directions / np.linalg.norm(directions, axis=1, keepdims=True)
    return np.asarray(wanted[(wanted @ unit.T).max(axis=1, initial=-1.0) < NEAR_COSINE])


def list_directions(
    directions: Iterable[FloatArray], most: int = 6, triad: Triad = "accelerometer"
) -> str:
    """The names of ``directions`` as one phrase, cut after ``most``.

    Parameters
    ----------
    directions : iterable of array, shape (3,)
        Unit vectors.
    most : int
        How many are named; of the others only the number is.
    triad : str
        As of :func:`direction_name`.
    """
    names = [direction_name(direction, triad) for direction in directions]
    if len(names) <= most:
        return ", ".join(names)
    return ", ".join(names[:most]) + f" and {len(names) - most} more"
