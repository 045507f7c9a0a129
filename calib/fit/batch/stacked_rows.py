"""The rows of :mod:`calib.fit.rows.residuals` for a stack: a model that acts on the reading alone.

    magnitude row   (|s_i| (1 - R_i eta) - m_i) / sd_i,     s = y - E(y) theta
    null row        (s_i - expected_i) / sd_i, three of them
    prior row       eta_j
"""

from dataclasses import dataclass

import numpy as np

from calib.fit.batch.linear_algebra import times
from calib.fit.batch.pose_stack import PoseStack
from calib.fit.model import Model, stack_columns
from calib.fit.rows.initial_estimate import Start
from calib.numbers import NO_LENGTH
from calib.poses.conditions import Conditions
from calib.poses.imu_log import FloatArray, IntArray


@dataclass(frozen=True, eq=False)
class StackedRows:
    """Whitened ``residual`` (S, r), ``jacobian`` (S, r, p + q), corrected ``vector`` (S, n, 3)."""

    residual: FloatArray
    jacobian: FloatArray
    vector: FloatArray

    @property
    def cost(self) -> FloatArray:
        """Sum of squares of every set, (S,), no unit."""
        return np.asarray(np.einsum("sr,sr->s", self.residual, self.residual))


@dataclass(frozen=True, eq=False)
class StackedEquations:
    """What does not change between iterations.

    ``start_matrix`` (S, 3, 3) and ``start_offset`` (S, 3) of the start, ``columns`` (S, n, 3, p) of
    the model on the readings, ``magnitude_sd`` (S, k) and ``null_sd`` (S, m, 3) of the rows, SI,
    ``common_relative`` (S, k, q) the common errors over the reference.
    """

    stack: PoseStack
    start_matrix: FloatArray
    start_offset: FloatArray
    columns: FloatArray
    magnitude_sd: FloatArray
    null_sd: FloatArray
    common_relative: FloatArray

    @classmethod
    def of(cls, stack: PoseStack, model: Model, start: Start) -> "StackedEquations":
        """The equations whitened at ``start``; ``model`` acts on the reading alone."""
        k = stack.turning
        s = _affine(stack.reading, start)
        direction = s[:, :k] / np.maximum(_length(s[:, :k]), NO_LENGTH)[..., None]
        along = (((direction @ start.matrix) * stack.sd[:, :k]) ** 2).sum(axis=2)
        across = stack.sd[:, k:] ** 2 @ np.swapaxes(start.matrix**2, 1, 2)
        return cls(
            stack=stack,
            start_matrix=start.matrix,
            start_offset=start.offset,
            columns=columns_on(model, stack.reading),
            magnitude_sd=np.sqrt(along + stack.reference_sd[:, :k] ** 2),
            null_sd=np.sqrt(across + stack.reference_sd[:, k:, None] ** 2),
            common_relative=stack.common / stack.magnitude[..., None],
        )

    def take(self, sets: IntArray) -> "StackedEquations":
        """The equations of these sets alone."""
        stack = PoseStack(**{name: value[sets] for name, value in vars(self.stack).items()})
        rest = {name: value[sets] for name, value in vars(self).items() if name != "stack"}
        return StackedEquations(stack, **rest)

    def rows(self, theta: FloatArray, eta: FloatArray) -> StackedRows:
        """Residual and exact Jacobian at ``theta`` (S, p), ``eta`` (S, q)."""
        stack, k, d = self.stack, self.stack.turning, self.stack.data_count
        (sets, p), q = theta.shape, eta.shape[1]
        shape = stack.reading.shape
        errors = times(self.columns.reshape(sets, 3 * shape[1], p), theta)
        s = stack.reading - errors.reshape(shape)
        size = _length(s[:, :k])
        share = 1 - times(self.common_relative, eta)
        residual = np.empty((sets, d + q))
        jacobian = np.zeros((sets, d + q, p + q))
        residual[:, :k] = (size * share - stack.magnitude) / self.magnitude_sd
        jacobian[:, :d, :p] = self.whitened(self.columns, s)
        jacobian[:, :k, :p] *= -share[..., None]
        jacobian[:, k:d, :p] *= -1
        jacobian[:, :k, p:] = -self.common_relative * (size / self.magnitude_sd)[..., None]
        residual[:, k:d] = ((s[:, k:] - stack.expected) / self.null_sd).reshape(sets, d - k)
        residual[:, d:] = eta
        jacobian[:, d:, p:] = np.eye(q)
        return StackedRows(residual, jacobian, s)

    def whitened(self, vectors: FloatArray, s: FloatArray) -> FloatArray:
        """Whitened rows (S, d, c) of errors (S, n, 3, c) of corrected vectors (S, n, 3)."""
        k = self.stack.turning
        turning = s[:, :k]
        n = turning / (np.maximum(_length(turning), NO_LENGTH) * self.magnitude_sd)[..., None]
        along = np.einsum("ski,skic->skc", n, vectors[:, :k])
        rest = vectors[:, k:] / self.null_sd[..., None]
        sets, m, axes, columns = rest.shape
        return np.concatenate([along, rest.reshape(sets, m * axes, columns)], axis=1)


def columns_on(model: Model, vector: FloatArray) -> FloatArray:
    """Columns (S, n, 3, p), SI, of a model of the reading on (S, n, 3): one call for all."""
    flat = Conditions.of_vectors(vector.reshape(-1, 3))
    return stack_columns(model.effects, flat, {}).reshape(*vector.shape, model.size)


def _affine(y: FloatArray, start: Start) -> FloatArray:
    return np.asarray(y @ np.swapaxes(start.matrix, 1, 2) + start.offset[:, None])


def _length(vectors: FloatArray) -> FloatArray:
    return np.asarray(np.sqrt(np.einsum("...i,...i->...", vectors, vectors)))
