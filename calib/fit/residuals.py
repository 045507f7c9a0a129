"""The rows that are fitted, and their exact derivatives.

    magnitude row   (|s_i| (1 - R_i eta) - m_i - D_i theta) / sd_i
    null row        (s_i - expected_i) / sd_i, three of them
    prior row       eta_j, one for each error that several references have in common

All rows have unit variance when the stated sds hold. ``eta`` are the common errors of the
references in units of their own sd; carrying them as unknowns with a prior puts the sd of a shared
rate into the scale, where it does not average down. R is their size relative to the reference, and
it acts on the magnitude of the model, not on the one that was measured: otherwise a gain that
shrinks together with the reference would shrink any misfit too, and gain would be lost to it
(Peelle's puzzle).
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial

import numpy as np

from calib.effects.effect import Effect
from calib.fit.model import Model, stack_columns
from calib.fit.sensitive_axes import (
    ALIGNED,
    NO_GAIN,
    Axes,
    axes_of,
    follows_vector,
    sensor_columns,
    sensor_slope,
    solve_sensor,
)
from calib.fit.whitening import NO_LENGTH, Whitening
from calib.poses.conditions import Conditions
from calib.poses.imu_log import FloatArray, IntArray
from calib.poses.pose_set import PoseSet


@dataclass(frozen=True, eq=False)
class WhitenedRows:
    """Whitened rows at one estimate.

    ``residual`` (r,), ``jacobian`` (r, p + q) with the q common errors last, ``vector`` (n, 3) the
    corrected vectors, ``axes_there`` gives the sensitive axes. The first rows are the magnitude
    rows, then the null rows, then the priors.
    """

    residual: FloatArray
    jacobian: FloatArray
    vector: FloatArray
    axes_there: Callable[[], Axes]

    @cached_property
    def axes(self) -> Axes:
        """The sensitive axes at the estimate."""
        return self.axes_there()

    @property
    def chi2(self) -> float:
        """Sum of the squared whitened residuals."""
        return float(self.residual @ self.residual)


class Equations:
    """The rows of one pose set under one model; holds what does not change between iterations.

    Parameters
    ----------
    poses : PoseSet
        n poses.
    model : Model
    sensed : array, shape (n, 3), optional
        What each sensitive axis felt in its pose, SI, for the memory of the pose before; by the
        start where it is not given.
    whitening : Whitening, optional
        That of ``poses``, where it is known already.
    """

    def __init__(
        self,
        poses: PoseSet,
        model: Model,
        sensed: FloatArray | None = None,
        whitening: Whitening | None = None,
    ) -> None:
        self.poses, self.model = poses, model
        self.whitening = whitening or Whitening.of(poses)
        self.start = self.whitening.start
        self.magnitude, self.null = self.whitening.magnitude, self.whitening.null
        self.magnitude_sd, self.null_sd = self.whitening.magnitude_sd, self.whitening.null_sd
        self.common_relative = self.whitening.common_relative
        self.common = poses.reference.common[self.magnitude]
        self.is_null = poses.reference.is_null
        self.on_reading = model.acting_on("reading")
        self.on_sensor = model.acting_on("sensor")
        self.on_reference = model.acting_on("reference")
        self.reading_index = model.positions(self.on_reading)
        self.sensor_index = model.positions(self.on_sensor)
        self.reference_index = model.positions(self.on_reference)
        self.at_reading = poses.conditions(poses.reading)
        self.reading_columns = (
            stack_columns(self.on_reading, self.at_reading, {})
            if self.on_reading
            else np.zeros((*poses.reading.shape, 0))
        )
        if sensed is None:
            sensed = axes_of(self.start.matrix).sensed(self.whitening.vector)
        self.at_start = poses.conditions(self.whitening.vector, sensed)
        self.varying = tuple(e for e in self.on_sensor if follows_vector(e, self.at_start))
        self.varying_on_axes = tuple(e for e in self.varying if not e.orthogonal)
        self.varying_orthogonal = tuple(e for e in self.varying if e.orthogonal)
        on_axes = tuple(e for e in self.on_sensor if not e.orthogonal)
        self.on_axes_index = model.positions(on_axes)
        self.on_axes_columns = [self.sensor_index.index(i) for i in self.on_axes_index]

    @cached_property
    def matrix_slopes(self) -> FloatArray:
        """dM/dtheta of the linear form for the parameters of the reading, (p', 3, 3)."""
        return _matrix_slopes(self.on_reading)

    @cached_property
    def typical_sd(self) -> float:
        """Median of :attr:`row_sd`, SI."""
        return float(np.median(self.row_sd))

    @property
    def row_pose(self) -> IntArray:
        """Pose of every data row (the prior rows left out), shape (r - q,)."""
        return np.concatenate([self.magnitude, np.repeat(self.null, 3)])

    @property
    def row_sd(self) -> FloatArray:
        """Sd of every data row in SI units, shape (r - q,)."""
        return np.concatenate([self.magnitude_sd, self.null_sd.ravel()])

    @property
    def data_count(self) -> int:
        """Number of data rows."""
        return len(self.magnitude) + 3 * len(self.null)

    def conditions(self, vector: FloatArray) -> Conditions:
        """What effects are evaluated on at ``vector``.

        In a null pose that is what it should read, not what it reads: scaled by an effect, its
        noise would look like a signal. The pose before stays as the start has it, so that rows
        are independent and a sign that flips with noise cannot make the iteration jump.
        """
        held = np.where(self.is_null[:, None], self.poses.expected, vector)
        return replace(self.at_start, vector=held)

    def whitened(self, vectors: FloatArray, s: FloatArray) -> FloatArray:
        """Data rows (d, k) of errors ``vectors`` (n, 3, k) of the corrected vectors s (n, 3)."""
        size = np.linalg.norm(s[self.magnitude], axis=1, keepdims=True)
        n = s[self.magnitude] / np.maximum(size, NO_LENGTH)
        along = np.einsum("ni,nik->nk", n, vectors[self.magnitude]) / self.magnitude_sd[:, None]
        rest = vectors[self.null] / self.null_sd[:, :, None]
        return np.concatenate([along, rest.reshape(-1, vectors.shape[2])])

    def axes(self, theta: FloatArray) -> Axes:
        """The sensitive axes at ``theta``."""
        if not len(self.reading_index):
            return ALIGNED
        return axes_of(np.eye(3) + np.tensordot(theta[self.reading_index], self.matrix_slopes, 1))

    def corrected(self, theta: FloatArray, shapes: Mapping[str, float], axes: Axes) -> FloatArray:
        """The corrected vectors s at ``theta``, shape (n, 3)."""
        s = self.at_reading.vector - self.reading_columns @ theta[self.reading_index]
        if not self.on_sensor:
            return s
        of_sensor = theta[self.sensor_index]
        return solve_sensor(self.on_sensor, of_sensor, shapes, self.conditions, s, axes)

    def _vector_jacobian(
        self, theta: FloatArray, shapes: Mapping[str, float], s: FloatArray, axes: Axes
    ) -> FloatArray:
        """ds/dtheta, shape (n, 3, p).

        From ``s + C(s; T) theta = M y + c``: ``(I + C') ds = dv - C dtheta - (dC/dT) dT``, where
        at fixed s ``(dC/dT) dT = dT F theta - T F' T⁻¹ dT u``.
        """
        jacobian = np.zeros((*s.shape, self.model.size))
        jacobian[:, :, self.reading_index] = -self.reading_columns
        if not self.on_sensor:
            return jacobian
        at = self.conditions(s)
        columns = sensor_columns(self.on_sensor, at, shapes, axes)
        jacobian[:, :, self.sensor_index] = -columns
        slope = self._slope_of(self.varying_on_axes, theta, shapes, at, axes)
        if len(self.reading_index):
            error = columns[:, :, self.on_axes_columns] @ theta[self.on_axes_index]
            moved = self._axes_slopes(theta, axes)  # (p', 3, 3)
            by_error = np.einsum("pij,nj->nip", moved, axes.sensed(error))
            jacobian[:, :, self.reading_index] -= by_error
            if self.varying_on_axes:
                by_turn = np.einsum("pij,nj->nip", moved, axes.sensed(at.vector))
                jacobian[:, :, self.reading_index] += slope @ by_turn
        if self.varying:
            whole = (
                np.eye(3) + slope + self._slope_of(self.varying_orthogonal, theta, shapes, at, axes)
            )
            whole[self.null] = np.eye(3)
            jacobian = np.linalg.solve(whole, jacobian)
        return jacobian

    def _axes_slopes(self, theta: FloatArray, axes: Axes) -> FloatArray:
        """dT/dtheta for the parameters of the reading, (p', 3, 3)."""
        diagonal = 1 + theta[self.reading_index] @ np.einsum("pii->pi", self.matrix_slopes)
        if (np.abs(diagonal) < NO_GAIN).any():  # the axes are held there, see ``axes_of``
            return np.zeros_like(self.matrix_slopes)
        diagonal_slopes = np.einsum("pii->pi", self.matrix_slopes)[:, None, :]
        return np.asarray((self.matrix_slopes - axes.to_orthogonal * diagonal_slopes) / diagonal)

    def _slope_of(
        self,
        effects: Sequence[Effect],
        theta: FloatArray,
        shapes: Mapping[str, float],
        at: Conditions,
        axes: Axes,
    ) -> FloatArray:
        if not effects:
            return np.zeros((1, 3, 3))
        return sensor_slope(effects, theta[self.model.positions(effects)], shapes, at, axes)

    def slope(
        self, theta: FloatArray, shapes: Mapping[str, float], at: Conditions, axes: Axes
    ) -> FloatArray:
        """``I + d(C theta)/ds``, shape (n, 3, 3); null poses are held at what they should read."""
        slope = np.eye(3) + self._slope_of(self.varying, theta, shapes, at, axes)
        slope = np.array(np.broadcast_to(slope, (len(at), 3, 3)))
        slope[self.null] = np.eye(3)
        return np.asarray(slope)

    def reference_columns(self, shapes: Mapping[str, float]) -> FloatArray:
        """Errors (k, p'') of the magnitude rows' references, SI, per unit of their parameters."""
        each = [e.evaluate(self.at_reading, shapes.get(e.name)) for e in self.on_reference]
        return np.concatenate(each, axis=1)[self.magnitude]

    def rows(self, theta: FloatArray, eta: FloatArray, shapes: Mapping[str, float]) -> WhitenedRows:
        """Whitened residual and exact Jacobian at ``theta`` (p,), ``eta`` (q,)."""
        axes = self.axes(theta) if self.on_sensor else ALIGNED  # which nothing else depends on
        s = self.corrected(theta, shapes, axes)
        ds = self._vector_jacobian(theta, shapes, s, axes)
        p, q, k = self.model.size, len(eta), len(self.magnitude)
        residual = np.empty(self.data_count + q)
        jacobian = np.zeros((self.data_count + q, p + q))

        s_turning = s[self.magnitude]
        size = np.sqrt((s_turning**2).sum(axis=1))
        n = s_turning / np.maximum(size, NO_LENGTH)[:, None]
        true_share = 1 - self.common_relative @ eta
        stated = self.poses.reference.magnitude[self.magnitude]
        residual[:k] = (size * true_share - stated) / self.magnitude_sd
        jacobian[:k, :p] = np.einsum("ni,nip->np", n * true_share[:, None], ds[self.magnitude])
        if self.on_reference:
            columns = self.reference_columns(shapes)
            residual[:k] -= columns @ theta[self.reference_index] / self.magnitude_sd
            jacobian[:k, self.reference_index] -= columns
        jacobian[:k, p:] = -self.common_relative * size[:, None]
        jacobian[:k] /= self.magnitude_sd[:, None]

        if len(self.null):
            rest = s[self.null] - self.poses.expected[self.null]
            residual[k : self.data_count] = (rest / self.null_sd).ravel()
            jacobian[k : self.data_count, :p] = (ds[self.null] / self.null_sd[:, :, None]).reshape(
                -1, p
            )
        residual[self.data_count :] = eta
        jacobian[self.data_count :, p:] = np.eye(q)
        return WhitenedRows(residual, jacobian, s, partial(self.axes, theta))


def _matrix_slopes(on_reading: Sequence[Effect]) -> FloatArray:
    """dM/dtheta of the linear form ``M y + c`` for every parameter of the reading, (p', 3, 3)."""
    if not on_reading:
        return np.zeros((0, 3, 3))
    probes = np.vstack([np.zeros(3), np.eye(3)])
    columns = stack_columns(on_reading, Conditions.of_vectors(probes), {})
    return np.asarray((columns[0] - columns[1:]).transpose(2, 1, 0))
