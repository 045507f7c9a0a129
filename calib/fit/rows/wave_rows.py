"""Rows of the waves that poses on a leaning plate show once per turn.

Effects are evaluated at the points of a pose's ring (:mod:`calib.poses.ring`) by what evaluates
them at poses; the harmonic of the corrected vectors s(θ) is the corrected wave, of cosine c and
sine d. A constant error makes no wave: these rows follow no bias, no drift and no step.

Accelerometer, under gravity that goes round with g sin τ:

    |c| - g sin τ,   |d| - g sin τ,   c·d / (√2 g sin τ)

The tilt τ is an error that these rows and the magnitudes of the means have in common, with a prior
so wide that they alone decide. Gyroscope, across the axis n of the plate, where nothing turns in
step but what is fixed in the room:

    t·(c - h_c),   t·(d - h_d),   t the two unit vectors across n

with h the Earth's horizontal rate, of known size and two unknown components for each run, along and
across the way the plate leans. What goes along n is wow, and no row has it.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

import numpy as np

from calib.effects.effect import Effect
from calib.fit.rows.sensitive_axes import ALIGNED, sensor_columns
from calib.fit.rows.vector_derivatives import vector_derivatives
from calib.fit.rows.whitening import Whitening
from calib.poses.imu_log import FloatArray, IntArray
from calib.poses.pose_set import PoseSet
from calib.poses.ring import (
    ANGLES,
    TILT_SD_RAD,
    TO_WAVE,
    Ring,
    room_names,
    tilt_name,
)

if TYPE_CHECKING:
    from calib.fit.rows.residuals import Equations


@dataclass(frozen=True, eq=False)
class WaveRows:
    """The rows of the w rings of a set of poses.

    Attributes
    ----------
    points : Equations
        The k points of every ring as poses, under the same model.
    row_pose : array of int, shape (d',)
        Pose of every row.
    row_sd : array, shape (d',)
        Their sds, SI.
    across : array, shape (w, 2, 3)
        Of a gyroscope the directions t; empty of an accelerometer.
    size : array, shape (w,)
        Of an accelerometer g sin τ, m/s².
    common : array, shape (d', q)
        What an sd of each common error adds to a row's reference, in its sds.
    """

    points: "Equations"
    row_pose: IntArray
    row_sd: FloatArray
    across: FloatArray
    size: FloatArray
    common: FloatArray
    latest: dict[bytes, tuple[FloatArray, FloatArray, FloatArray]] = field(default_factory=dict)

    def rows(
        self, theta: FloatArray, eta: FloatArray, shapes: Mapping[str, float]
    ) -> tuple[FloatArray, FloatArray]:
        """Whitened residual (d',) and its exact Jacobian (d', p + q).

        Parameters
        ----------
        theta, eta : array, shapes (p,) and (q,)
        shapes : mapping of str to float

        Raises
        ------
        FitFailed
            The effects are larger than the readings.
        """
        points = self.points
        axes = points.axes(theta) if points.on_sensor else ALIGNED
        s, columns = points.corrected(theta, shapes, axes)
        errors, slope = vector_derivatives(points, theta, shapes, s, columns, axes)
        if slope is not None:
            errors = np.asarray(np.linalg.solve(slope, errors), float)
        wave = _waves(s)
        value, shown = self._values(wave)
        residual = value / self.row_sd - self.common @ eta
        jacobian = -np.einsum("wrci,wcip->wrp", shown, _waves(errors))
        jacobian = jacobian.reshape(len(residual), -1) / self.row_sd[:, None]
        return residual, np.concatenate([jacobian, -self.common], axis=1)

    def columns(
        self, theta: FloatArray, shapes: Mapping[str, float], effect: Effect,
        shape: float | None = None,
    ) -> FloatArray:
        """What an effect that is not taken off leaves in the rows, whitened.

        Parameters
        ----------
        theta : array, shape (p,)
            Where the fit stands.
        shapes : mapping of str to float
        effect : Effect
            Of k parameters.
        shape : float, optional
            Its shape parameter.

        Returns
        -------
        array, shape (d', k)
            In sds, per unit of its parameters; zero of an effect on the reference.
        """
        if effect.acts_on == "reference":
            return np.zeros((len(self.row_sd), len(effect.parameters)))
        points = self.points
        axes = points.axes(theta) if points.on_sensor or effect.acts_on == "sensor" else ALIGNED
        key = theta.tobytes()
        if key not in self.latest:
            self.latest.clear()
            s, _ = points.corrected(theta, shapes, axes)
            self.latest[key] = (s, *self._values(_waves(s)))
        s, _, shown = self.latest[key]
        if effect.acts_on == "reading":
            errors = effect.evaluate(points.at_reading, shape)
        else:
            of_shape = {} if shape is None else {effect.name: shape}
            errors = sensor_columns((effect,), points.conditions(s), of_shape, axes)
        rows = np.einsum("wrci,wcik->wrk", shown, _waves(errors))
        return np.asarray(rows.reshape(len(self.row_sd), -1) / self.row_sd[:, None])

    def _values(self, wave: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Values (d',) of the rows at the waves (w, 2, 3), SI, and what they show (w, r, 2, 3)."""
        w = len(wave)
        if len(self.across):
            shown = np.zeros((w, 4, 2, 3))
            shown[:, :2, 0] = self.across
            shown[:, 2:, 1] = self.across
            return np.einsum("wrci,wci->wr", shown, wave).ravel(), shown
        shown = np.zeros((w, 3, 2, 3))
        length = np.linalg.norm(wave, axis=2)
        shown[:, [0, 1], [0, 1]] = wave / length[:, :, None]
        twice = np.sqrt(2) * self.size[:, None]
        shown[:, 2] = wave[:, ::-1] / twice[:, :, None]
        mixed = (wave[:, 0] * wave[:, 1]).sum(axis=1) / twice[:, 0]
        values = np.column_stack([length - self.size[:, None], mixed])
        return values.ravel(), shown


def _waves(values: FloatArray) -> FloatArray:
    """Cosine and sine of values (w k, 3, ...) round their rings, (w, 2, 3, ...)."""
    rings = values.reshape(-1, ANGLES, *values.shape[1:])
    return np.asarray(np.moveaxis(np.tensordot(TO_WAVE, rings, axes=(1, 1)), 0, 1))


def wave_rows(equations: "Equations") -> WaveRows:
    """The rows of the waves of the poses of ``equations``, which have rings."""
    ring = equations.poses.ring
    assert ring is not None
    index = np.repeat(ring.place, ANGLES)
    of_points = replace(replace(equations.poses, ring=None).take(index),
                        reading=ring.reading.reshape(-1, 3), force=ring.force.reshape(-1, 3))
    points = type(equations)(of_points, equations.model,
                             whitening=Whitening.of(of_points, equations.start))
    points.at_start = points.at_start.with_previous(equations.at_start.previous[index])
    poses, start = equations.poses, equations.start
    wave = _waves(ring.reading.reshape(-1, 3) @ start.matrix.T)
    if poses.triad == "gyroscope":
        across = _across(poses, ring, start.matrix, start.offset)
        sd = np.sqrt(np.einsum("wij,wj->wi", (across @ start.matrix) ** 2, ring.sd**2))
        row_sd = np.tile(sd, (1, 2))  # cosine, then sine
        size = np.zeros(0)
        common = _room(poses, ring, across) / row_sd.reshape(-1, 1)
    else:
        across = np.zeros((0, 2, 3))
        size = ring.gravity_m_s2 * np.sin(ring.tilt_rad)
        unit = wave / np.linalg.norm(wave, axis=2, keepdims=True)
        sd = np.sqrt(np.einsum("wci,wi->wc", (unit @ start.matrix) ** 2, ring.sd**2))
        row_sd = np.column_stack([sd, np.sqrt((sd**2).mean(axis=1))])
        common = _gravity_and_tilt(poses, ring, size) / row_sd.reshape(-1, 1)
    return WaveRows(points, np.repeat(ring.place, row_sd.shape[1]), row_sd.ravel(), across, size,
                    common)


def _across(poses: PoseSet, ring: Ring, matrix: FloatArray, offset: FloatArray) -> FloatArray:
    """Along and across the way the plate leans where the wave begins, (w, 2, 3)."""
    up = np.sign(poses.spin_rad_s[ring.place])[:, None] * (
        poses.reading[ring.place] @ matrix.T + offset)
    up /= np.linalg.norm(up, axis=1, keepdims=True)
    lean = _waves(ring.force.reshape(-1, 3))[:, 0]
    lean -= (lean * up).sum(axis=1, keepdims=True) * up
    lean /= np.linalg.norm(lean, axis=1, keepdims=True)
    return np.stack([lean, np.cross(up, lean)], axis=1)


def _room(poses: PoseSet, ring: Ring, across: FloatArray) -> FloatArray:
    """What an sd of the Earth's horizontal rate along and across the lean adds to each row, SI."""
    names = poses.reference.common_names
    common = np.zeros((len(ring.place), 4, len(names)))
    sine = _waves(ring.force.reshape(-1, 3))[:, 1]
    turned = np.sign(np.einsum("wi,wi->w", sine, across[:, 1]))  # +1: gravity goes t1 to t2
    for i, place in enumerate(ring.place):
        for j, name in enumerate(room_names(poses.run[place])):
            if name in names:
                rate = ring.room_rad_s[i] * np.eye(2)[j]
                ahead = turned[i] * np.array([-rate[1], rate[0]])
                common[i, :, names.index(name)] = np.concatenate([rate, ahead])
    return common.reshape(-1, len(names))


def _gravity_and_tilt(poses: PoseSet, ring: Ring, size: FloatArray) -> FloatArray:
    """What an sd of the errors of gravity and of the tilt adds to each row, SI, (rows, q)."""
    reference = poses.reference
    relative = reference.common[ring.place] / reference.magnitude[ring.place, None]
    for i, place in enumerate(ring.place):
        name = tilt_name(poses.run[place])
        if name in reference.common_names:
            relative[i, reference.common_names.index(name)] = TILT_SD_RAD / np.tan(ring.tilt_rad[i])
    rows = np.zeros((len(size), 3, len(reference.common_names)))
    rows[:, :2] = (size[:, None] * relative)[:, None]
    return rows.reshape(-1, len(reference.common_names))
