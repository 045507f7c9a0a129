"""Rows of S sets, each at an estimate of its own."""

from dataclasses import dataclass

import numpy as np

from calib.poses.imu_log import BoolArray, FloatArray, IntArray


@dataclass(frozen=True, eq=False)
class JointRows:
    """Whitened rows of S sets at one estimate each.

    Parameters
    ----------
    residual, jacobian : array, shapes (S, r) and (S, r, p + q)
    vector : array, shape (S, n, 3)
        The corrected vectors.
    slope : array, shape (S, n, 3, 3), or None
        ``I + C'``; None where no effect follows the vector.
    to_orthogonal, to_sensed : array, shape (S, 3, 3)
        The sensitive axes.
    is_solved : array of bool, shape (S,)
        Whether the vectors were found.
    """

    residual: FloatArray
    jacobian: FloatArray
    vector: FloatArray
    slope: FloatArray | None
    to_orthogonal: FloatArray
    to_sensed: FloatArray
    is_solved: BoolArray

    @property
    def cost(self) -> FloatArray:
        """Sum of squares of every set, (S,), no unit; infinite where no vectors belong to it."""
        cost = np.einsum("sr,sr->s", self.residual, self.residual)
        return np.asarray(np.where(self.is_solved & np.isfinite(cost), cost, np.inf))

    def where(self, chosen: BoolArray, other: "JointRows") -> "JointRows":
        """These rows in the ``chosen`` sets (S,), the ``other`` ones elsewhere."""
        slope = None
        if self.slope is not None and other.slope is not None:
            slope = either(chosen, self.slope, other.slope)
        return JointRows(
            either(chosen, self.residual, other.residual),
            either(chosen, self.jacobian, other.jacobian),
            either(chosen, self.vector, other.vector),
            slope,
            either(chosen, self.to_orthogonal, other.to_orthogonal),
            either(chosen, self.to_sensed, other.to_sensed),
            np.where(chosen, self.is_solved, other.is_solved),
        )

    def take(self, sets: IntArray) -> "JointRows":
        """The rows of these sets alone."""
        return JointRows(
            self.residual[sets], self.jacobian[sets], self.vector[sets],
            None if self.slope is None else self.slope[sets],
            self.to_orthogonal[sets], self.to_sensed[sets], self.is_solved[sets],
        )


def either(chosen: BoolArray, one: FloatArray, other: FloatArray) -> FloatArray:
    """``one`` (S, ...) in the ``chosen`` sets (S,), the ``other`` elsewhere; any unit."""
    return np.asarray(np.where(chosen.reshape(-1, *(1,) * (one.ndim - 1)), one, other))
