"""The rows that are fitted, and their exact derivatives.

    magnitude row   (|s_i| (1 - R_i eta) - m_i - D_i theta) / sd_i
    null row        (s_i - expected_i) / sd_i, three of them
    wave row        of a plate that leans, :mod:`calib.fit.rows.wave_rows`
    prior row       eta_j, one for each error that several references have in common

All rows have unit variance when the stated sds hold. ``eta`` are the common errors of the
references in units of their own sd; carrying them as unknowns with a prior puts the sd of a shared
rate into the scale, where it does not average down. R is their size relative to the reference, and
it acts on the magnitude of the model, not on the one that was measured: otherwise a gain that
shrinks together with the reference would shrink any misfit too, and gain would be lost to it
(Peelle's puzzle).
"""

from collections.abc import Mapping, Sequence
from copy import copy
from functools import cached_property, partial

import numpy as np

from calib.effects.effect import Effect
from calib.fit.model import Model, stack_columns
from calib.fit.rows.sensitive_axes import (
    ALIGNED,
    Axes,
    axes_of,
    follows_vector,
    probes_of,
    sensor_columns,
    solve_sensor,
)
from calib.fit.rows.vector_derivatives import matrix_slopes, vector_derivatives
from calib.fit.rows.wave_rows import WaveRows, wave_rows
from calib.fit.rows.whitened_rows import WhitenedRows
from calib.fit.rows.whitening import Whitening
from calib.numbers import NO_LENGTH
from calib.poses.conditions import Conditions
from calib.poses.imu_log import FloatArray, IntArray
from calib.poses.pose_set import PoseSet

OF_THE_MODEL = (
    "on_reading", "on_sensor", "on_reference", "reading_index", "sensor_index", "reference_index",
    "follows", "varying", "fixed", "varying_on_axes", "varying_orthogonal", "on_axes_index",
    "on_axes_columns", "varying_index", "fixed_index")
"""What equations of one model share: which effects act where, and where their parameters stand."""


class Equations:
    """The rows of one pose set under one model; holds what does not change between iterations.

    Parameters
    ----------
    poses : PoseSet
        n poses.
    model : Model
    whitening : Whitening, optional
        That of ``poses``, where it is known already.
    """

    def __init__(
        self,
        poses: PoseSet,
        model: Model,
        whitening: Whitening | None = None,
    ) -> None:
        self.poses = poses
        self.whitening = whitening or Whitening.of(poses)
        self.start = self.whitening.start
        self.magnitude, self.null = self.whitening.magnitude, self.whitening.null
        self.magnitude_sd, self.null_sd = self.whitening.magnitude_sd, self.whitening.null_sd
        self.common_relative = self.whitening.common_relative
        self.common = poses.reference.common[self.magnitude]
        self.is_null = poses.reference.is_null
        self.at_reading = poses.conditions(poses.reading)
        sensed = axes_of(self.start.matrix).sensed(self.whitening.vector)
        self.at_start = poses.conditions(self.whitening.vector, sensed)
        self.follows: dict[str, bool] = {}
        self._hold(model)

    def extended(self, effects: Sequence[Effect]) -> "Equations":
        """The rows of the same poses under the model with more ``effects``."""
        larger = copy(self)
        for name in ("matrix_slopes", "waves"):
            larger.__dict__.pop(name, None)
        larger.probes = self.probes
        larger._hold(Model((*self.model.effects, *effects)))
        return larger

    def extended_as(self, other: "Equations", effects: Sequence[Effect]) -> "Equations":
        """:meth:`extended` where it was made for other poses: what the model decides is theirs.

        Parameters
        ----------
        other : Equations
            Of poses with the same rows and columns, :meth:`extended` by the same ``effects``,
            which may begin at other shapes.
        effects : sequence of Effect
        """
        larger = copy(self)
        for name in (*OF_THE_MODEL, "matrix_slopes"):
            setattr(larger, name, getattr(other, name))
        larger.model = Model((*self.model.effects, *effects))
        if len(other.on_reading) > len(self.on_reading):
            larger.reading_columns = stack_columns(other.on_reading, self.at_reading, {})
        return larger

    def after(self, sensed: FloatArray) -> "Equations":
        """The same rows where the axes ``sensed`` (n, 3) in the poses, SI: what they remember."""
        later = copy(self)
        for name in ("probes", "waves"):
            later.__dict__.pop(name, None)
        previous = self.poses.conditions(self.whitening.vector, sensed).previous
        later.at_start = self.at_start.with_previous(previous)
        return later

    def _hold(self, model: Model) -> None:
        """What depends on the model and not on its parameters."""
        self.model = model
        self.on_reading = model.acting_on("reading")
        self.on_sensor = model.acting_on("sensor")
        self.on_reference = model.acting_on("reference")
        self.reading_index = model.positions(self.on_reading)
        self.sensor_index = model.positions(self.on_sensor)
        self.reference_index = model.positions(self.on_reference)
        self.reading_columns = stack_columns(self.on_reading, self.at_reading, {})
        for e in self.on_sensor:
            if e.name not in self.follows:
                self.follows = {**self.follows, e.name: follows_vector(e, self.at_start)}
        self.varying = tuple(e for e in self.on_sensor if self.follows[e.name])
        self.fixed = tuple(e for e in self.on_sensor if not self.follows[e.name])
        self.varying_on_axes = tuple(e for e in self.varying if not e.orthogonal)
        self.varying_orthogonal = tuple(e for e in self.varying if e.orthogonal)
        on_axes = tuple(e for e in self.on_sensor if not e.orthogonal)
        self.on_axes_index = model.positions(on_axes)
        self.on_axes_columns = [self.sensor_index.index(i) for i in self.on_axes_index]
        self.varying_index = model.positions(self.varying)
        self.fixed_index = model.positions(self.fixed)

    @cached_property
    def probes(self) -> Conditions:
        """The poses six times, for the differences by which slopes are computed."""
        return probes_of(self.at_start)

    @cached_property
    def matrix_slopes(self) -> FloatArray:
        """dM/dtheta for the p' parameters of the reading, per unit of each, (p', 3, 3)."""
        return matrix_slopes(self.on_reading)

    @cached_property
    def typical_sd(self) -> float:
        """Median of :attr:`row_sd`, SI."""
        return float(np.median(self.row_sd))

    @cached_property
    def waves(self) -> WaveRows | None:
        """The rows of the waves; None on a level plate."""
        return None if self.poses.ring is None else wave_rows(self)

    @cached_property
    def row_pose(self) -> IntArray:
        """Pose of every data row (the prior rows left out), shape (r - q,)."""
        last = [self.waves.row_pose] if self.waves else []
        return np.concatenate([self.magnitude, np.repeat(self.null, 3), *last])

    @property
    def row_sd(self) -> FloatArray:
        """Sd of every data row in SI units, shape (r - q,)."""
        last = [self.waves.row_sd] if self.waves else []
        return np.concatenate([self.magnitude_sd, self.null_sd.ravel(), *last])

    @property
    def wave_count(self) -> int:
        """Number of rows of waves, the last of the data rows."""
        return len(self.waves.row_sd) if self.waves else 0

    @property
    def data_count(self) -> int:
        """Number of data rows."""
        return len(self.magnitude) + 3 * len(self.null) + self.wave_count

    def conditions(self, vector: FloatArray) -> Conditions:
        """What effects are evaluated on at the corrected vectors ``vector`` (n, 3), SI.

        In a null pose that is what it should read, not what it reads: scaled by an effect, its
        noise would look like a signal. The pose before stays as the start has it, so that rows
        are independent and a sign that flips with noise cannot make the iteration jump.
        """
        held = np.where(self.is_null[:, None], self.poses.expected, vector)
        return self.at_start.with_vector(held)

    def whitened(self, vectors: FloatArray, s: FloatArray) -> FloatArray:
        """What errors of the corrected vectors make of the data rows, in their sds, (d, k).

        Parameters
        ----------
        vectors : array, shape (n, 3, k)
            k errors of every vector, SI.
        s : array, shape (n, 3)
            The corrected vectors, SI.
        """
        return np.asarray(np.einsum("di,dik->dk", self.directions(s), vectors[self.row_pose]))

    def axes(self, theta: FloatArray) -> Axes:
        """The sensitive axes at ``theta`` (p,)."""
        if not len(self.reading_index):
            return ALIGNED
        return axes_of(np.eye(3) + np.tensordot(theta[self.reading_index], self.matrix_slopes, 1))

    def corrected(
        self, theta: FloatArray, shapes: Mapping[str, float], axes: Axes
    ) -> tuple[FloatArray, FloatArray]:
        """The corrected vectors s (n, 3), SI, at ``theta`` (p,), and the sensor's columns there."""
        s = self.at_reading.vector - self.reading_columns @ theta[self.reading_index]
        columns = np.zeros((len(s), 3, self.model.size))
        if self.fixed:
            fixed = sensor_columns(self.fixed, self.conditions(s), shapes, axes)
            columns[:, :, self.fixed_index] = fixed
            s = s - fixed @ theta[self.fixed_index]
        if self.varying:
            sizes = theta[self.varying_index]
            s = solve_sensor(self.varying, sizes, shapes, self.conditions, s, axes)
            columns[:, :, self.varying_index] = sensor_columns(
                self.varying, self.conditions(s), shapes, axes
            )
        return s, columns[:, :, self.sensor_index]

    def directions(self, s: FloatArray, slope: FloatArray | None = None) -> FloatArray:
        """What every data row shows of an error of its pose's vector, (d, 3), per SI unit.

        Parameters
        ----------
        s : array, shape (n, 3)
            The corrected vectors.
        slope : array, shape (n, 3, 3), optional
            ``I + C'``; with it the error is that ahead of the effects that follow the vector.
        """
        turning = s[self.magnitude]
        size = np.sqrt((turning**2).sum(axis=1))
        along = turning / (np.maximum(size, NO_LENGTH) * self.magnitude_sd)[:, None]
        if slope is not None:
            transposed = slope[self.magnitude].transpose(0, 2, 1)
            along = np.linalg.solve(transposed, along[:, :, None])[:, :, 0]
        at_rest = np.eye(3) / self.null_sd[:, :, None]
        return np.concatenate([along, at_rest.reshape(-1, 3), np.zeros((self.wave_count, 3))])

    def reference_columns(self, shapes: Mapping[str, float]) -> FloatArray:
        """Errors (k, p'') of the magnitude rows' references, SI, per unit of their parameters."""
        each = [e.evaluate(self.at_reading, shapes.get(e.name)) for e in self.on_reference]
        return np.concatenate(each, axis=1)[self.magnitude]

    def rows(self, theta: FloatArray, eta: FloatArray, shapes: Mapping[str, float]) -> WhitenedRows:
        """Whitened residual and exact Jacobian.

        Parameters
        ----------
        theta, eta : array, shapes (p,) and (q,)
            Parameters of the model, SI, and common errors in their sds.
        shapes : mapping of str to float
            Value of every shape parameter, by its effect.

        Raises
        ------
        FitFailed
            By the fixed point of the sensor's effects: they are larger than the readings.
        """
        axes = self.axes(theta) if self.on_sensor else ALIGNED  # which nothing else depends on
        s, columns = self.corrected(theta, shapes, axes)
        errors, slope = vector_derivatives(self, theta, shapes, s, columns, axes)
        directions = self.directions(s, slope)
        p, q, k = self.model.size, len(eta), len(self.magnitude)
        residual = np.empty(self.data_count + q)
        jacobian = np.zeros((self.data_count + q, p + q))

        s_turning = s[self.magnitude]
        size = np.sqrt((s_turning**2).sum(axis=1))
        true_share = 1 - self.common_relative @ eta
        stated = self.poses.reference.magnitude[self.magnitude]
        residual[:k] = (size * true_share - stated) / self.magnitude_sd
        rest = s[self.null] - self.poses.expected[self.null]
        first_wave = self.data_count - self.wave_count
        residual[k:first_wave] = (rest / self.null_sd).ravel()
        directions[:k] *= -true_share[:, None]
        directions[k:] *= -1
        shown = np.einsum("di,dip->dp", directions, errors[self.row_pose])
        jacobian[: self.data_count, :p] = shown
        if self.waves:
            last = slice(first_wave, self.data_count)
            residual[last], jacobian[last] = self.waves.rows(theta, eta, shapes)
        if self.on_reference:
            of_reference = self.reference_columns(shapes) / self.magnitude_sd[:, None]
            residual[:k] -= of_reference @ theta[self.reference_index]
            jacobian[:k, self.reference_index] -= of_reference
        jacobian[:k, p:] = -self.common_relative * (size / self.magnitude_sd)[:, None]
        residual[self.data_count :] = eta
        jacobian[self.data_count :, p:] = np.eye(q)
        return WhitenedRows(residual, jacobian, s, slope, partial(self.axes, theta))
