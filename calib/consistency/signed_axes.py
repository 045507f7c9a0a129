"""The 48 signed permutations: all ways to exchange and mirror three columns.

``P[k, j] = ±1`` if axis k of the intended log is in column j of the actual log.
"""

from collections.abc import Mapping
from itertools import permutations, product

import numpy as np

from calib.poses.imu_log import AXES, FloatArray

SIGNED_PERMUTATIONS: FloatArray = np.array([
    np.eye(3)[list(order)] * np.array(signs)[:, None]
    for order in permutations(range(3))
    for signs in product((1.0, -1.0), repeat=3)
])
"""All signed permutations, (48, 3, 3), the identity first."""

IDENTITY = 0  #: its index in SIGNED_PERMUTATIONS
CYCLES: Mapping[tuple[int, ...], str] = {
    (1, 2, 0): "x is logged as y, y as z and z as x",
    (2, 0, 1): "x is logged as z, y as x and z as y",
}


def nearest_signed(matrix: FloatArray) -> FloatArray:
    """The signed permutation (3, 3), no unit, nearest to an orthogonal matrix."""
    scores = np.einsum("pij,ij->p", SIGNED_PERMUTATIONS, matrix)
    return np.asarray(SIGNED_PERMUTATIONS[int(np.argmax(scores))])


def permutation_words(matrix: FloatArray) -> str:
    """Description of the exchanged and mirrored axes, as a clause: ``x and y are exchanged``.

    >>> permutation_words(np.array([[0, 1, 0], [1, 0, 0], [0, 0, -1.0]]))
    'x and y are exchanged, and z has the opposite sign'
    """
    order = tuple(int(np.argmax(np.abs(row))) for row in matrix)
    signs = [float(row[j]) for row, j in zip(matrix, order, strict=True)]
    parts = []
    moved = [k for k, j in enumerate(order) if j != k]
    if len(moved) == 2:
        parts.append(f"{AXES[moved[0]]} and {AXES[moved[1]]} are exchanged")
    elif moved:
        parts.append(CYCLES[order])
    mirrored = [AXES[k] for k, sign in enumerate(signs) if sign < 0]
    if len(mirrored) == 3:
        parts.append("all three axes have the opposite sign")
    elif mirrored:
        verb = "has" if len(mirrored) == 1 else "have"
        parts.append(f"{' and '.join(mirrored)} {verb} the opposite sign")
    return ", and ".join(parts) or "the axes are as they should be"
