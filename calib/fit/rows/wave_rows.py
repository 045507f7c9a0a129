"""Rows of the waves that poses on a leaning plate show once per turn.

Effects are evaluated at the points of a pose's ring (:mod:`calib.poses.runs.ring`) by what
evaluates them at poses; the harmonic of the corrected vectors s(θ) is the corrected wave, of cosine
c and sine d. A constant error makes no wave: these rows follow no bias, no drift and no step.

Accelerometer, under gravity that goes round with g sin τ:

    |c| - g sin τ,   |d| - g sin τ,   c·d / (√2 g sin τ)

The tilt τ is an error that these rows and the magnitudes of the means have in common, with a prior
so wide that they alone decide. Gyroscope, across the axis n of the plate, where nothing turns in
step but what is fixed in the room:

    t·(c - h_c),   t·(d - h_d),   t the two unit vectors across n

with h the Earth's rate: of its vertical part sin τ, which is known, and of its horizontal part, of
known size, two unknown components for each run, along and across the way the plate leans. What goes
along n is wow, and no row has it.
"""

from dataclasses import dataclass, replace

import numpy as np

from calib.effects.effect import Effect
from calib.fit.model import Model
from calib.fit.rows.initial_estimate import Start
from calib.fit.rows.readings import Readings
from calib.fit.rows.sensitive_axes import Shapes, evaluate_for, sensor_columns
from calib.fit.rows.surroundings import Surroundings
from calib.fit.rows.whitened_rows import WhitenedRows
from calib.fit.small_systems import solutions, times
from calib.fit.stacked import Stacked
from calib.poses.imu_log import FloatArray, IntArray
from calib.poses.pose_set import PoseSet
from calib.poses.runs.ring import (
    ANGLES,
    TILT_SD_RAD,
    TO_WAVE,
    Ring,
    room_names,
    tilt_name,
)


@dataclass(frozen=True, eq=False)
class WaveRows(Stacked):
    """The rows of the w rings of each of S sets of poses.

    Attributes
    ----------
    points : Readings
        Those of the k points of every ring.
    places : tuple of int, length w
        Which poses have rings, in every set.
    row_sd : array, shape (..., d')
        The sds of the rows, SI.
    across : array, shape (..., w, 2, 3)
        Of a gyroscope the directions t; (..., 0, 2, 3) of an accelerometer.
    stated : array, shape (..., d')
        What the rows should show, SI.
    common : array, shape (..., d', q)
        What an sd of each common error adds to a row's reference, in its sds.
    """

    points: Readings
    places: tuple[int, ...]
    row_sd: FloatArray
    across: FloatArray
    stated: FloatArray
    common: FloatArray

    @classmethod
    def of(cls, surroundings: Surroundings, start: Start, model: Model) -> "WaveRows | None":
        """The rows of the waves of poses that start at ``start``; None on a level plate."""
        rings = [poses.ring for poses in surroundings.sets if poses.ring is not None]
        if not rings:
            return None
        place = rings[0].place
        parts = [_of_set(poses, start.take(k)) for k, poses in enumerate(surroundings.sets)]
        sets = tuple(part[0] for part in parts)
        row_sd, across, stated, common = (np.array(values) for values in
                                        zip(*(part[1:] for part in parts), strict=True))
        reading = np.array([poses.reading for poses in sets])
        vector = start.corrected(reading).reshape(-1, 3)
        of_points = Surroundings(sets, vector, vector, _previous(surroundings, place))
        return cls(Readings.of(reading, of_points, model), tuple(map(int, place)), row_sd, across,
                   stated, common)

    def after(self, surroundings: Surroundings) -> "WaveRows":
        """The same after other poses before, those of the poses in ``surroundings``."""
        previous = _previous(surroundings, np.array(self.places))
        return replace(self, points=self.points.within(
            replace(self.points.surroundings, previous=previous)))

    @property
    def count(self) -> int:
        """Number d' of rows of a set."""
        return int(self.row_sd.shape[-1])

    @property
    def row_pose(self) -> list[int]:
        """Pose of every row, d' of them."""
        return [place for place in self.places for _ in range(self.count // len(self.places))]

    def rows(
        self, theta: FloatArray, eta: FloatArray, shapes: Shapes
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Whitened residual, its exact Jacobian, and the corrected points.

        Parameters
        ----------
        theta, eta : array, shapes (..., p) and (..., q)
        shapes : mapping of effect name to shape parameter

        Returns
        -------
        residual, jacobian : array, shapes (..., d') and (..., d', p + q)
        points : array, shape (..., w k, 3)
            SI.

        Raises
        ------
        FitFailed
            The effects of the only set are larger than the readings.
        """
        s, errors, slope = self.points.corrected(theta, shapes)
        if slope is not None:
            errors = solutions(slope, errors)
        value, shown = self._values(_waves(s, -2))
        residual = (value - self.stated) / self.row_sd - times(self.common, eta)
        jacobian = -np.einsum("...wrci,...wcip->...wrp", shown, _waves(errors, -3))
        jacobian = jacobian.reshape(*residual.shape, -1) / self.row_sd[..., None]
        return residual, np.concatenate([jacobian, -self.common], axis=-1), s

    def columns(
        self, rows: WhitenedRows, effect: Effect, shape: float | None = None
    ) -> FloatArray:
        """What an effect that is not taken off leaves in the rows, whitened.

        Parameters
        ----------
        rows : WhitenedRows
            Where the fit stands.
        effect : Effect
            Of k parameters.
        shape : float, optional
            Its shape parameter.

        Returns
        -------
        array, shape (..., d', k)
            In sds, per unit of its parameters; zero of an effect on the reference.
        """
        surroundings, s = self.points.surroundings, rows.points
        if effect.acts_on == "reference" or s is None:
            return np.zeros((*self.row_sd.shape, len(effect.parameters)))
        lead = s.shape[:-2]
        of_shape = {} if shape is None else {effect.name: np.full(lead, shape)}
        if effect.acts_on == "reading":
            errors = evaluate_for(lead, effect, surroundings.at_reading, of_shape)
        else:
            errors = sensor_columns((effect,), surroundings.conditions(s), of_shape, rows.axes)
        _, shown = self._values(_waves(s, -2))
        seen = np.einsum("...wrci,...wcik->...wrk", shown, _waves(errors, -3))
        return np.asarray(seen.reshape(*self.row_sd.shape, -1) / self.row_sd[..., None])

    def _values(self, wave: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Values (..., d') of the rows at the waves (..., w, 2, 3), SI, and what they show.

        The latter (..., w, r, 2, 3).
        """
        *lead, w, _, _ = wave.shape
        if self.across.shape[-3]:
            shown = np.zeros((*lead, w, 4, 2, 3))
            shown[..., :2, 0, :] = self.across
            shown[..., 2:, 1, :] = self.across
            values = np.einsum("...wrci,...wci->...wr", shown, wave)
            return values.reshape(*lead, 4 * w), shown
        shown = np.zeros((*lead, w, 3, 2, 3))
        length = np.linalg.norm(wave, axis=-1)
        shown[..., [0, 1], [0, 1], :] = wave / length[..., None]
        twice = np.sqrt(2) * self.stated[..., ::3, None]  # g sin τ
        shown[..., 2, :, :] = wave[..., ::-1, :] / twice[..., None]
        mixed = (wave[..., 0, :] * wave[..., 1, :]).sum(axis=-1, keepdims=True) / twice
        values = np.concatenate([length, mixed], axis=-1)
        return values.reshape(*lead, 3 * w), shown


def _waves(values: FloatArray, axis: int) -> FloatArray:
    """Cosine and sine of values round their rings, whose w k points lie along an axis.

    That axis becomes (w, 2).
    """
    at = values.ndim + axis
    rings = values.reshape(*values.shape[:at], -1, ANGLES, *values.shape[at + 1 :])
    return np.asarray(np.moveaxis(np.tensordot(rings, TO_WAVE, axes=(at + 1, 1)), -1, at + 1))


def _previous(surroundings: Surroundings, place: IntArray) -> FloatArray:
    """What the axes sensed before the poses at ``place`` of every set, for their points."""
    sets = len(surroundings.sets)
    of_sets = surroundings.at_start.previous.reshape(sets, -1, 3)
    return of_sets[:, np.repeat(place, ANGLES)].reshape(-1, 3)


def _of_set(
    poses: PoseSet, start: Start
) -> tuple[PoseSet, FloatArray, FloatArray, FloatArray, FloatArray]:
    """The points of the rings of one set as poses; row_sd, across, stated, common of its rows."""
    ring = poses.ring
    assert ring is not None
    index = np.repeat(ring.place, ANGLES)
    of_points = replace(replace(poses, ring=None).take(index),
                        reading=ring.reading.reshape(-1, 3), force=ring.force.reshape(-1, 3))
    if poses.triad == "gyroscope":
        across = _across(poses, ring, start.matrix, start.offset)
        sd = np.sqrt(np.einsum("wij,wj->wi", (across @ start.matrix) ** 2, ring.sd**2))
        row_sd = np.tile(sd, (1, 2))  # cosine, then sine
        along, ahead = _of_the_room(ring, across).transpose(1, 0, 2)  # (w, 4)
        stated = (ring.vertical_rad_s * np.sin(ring.tilt_rad))[:, None] * along
        shown = np.stack([along * np.cos(ring.tilt_rad)[:, None], ahead])
        common = _room(poses, ring, shown) / row_sd.reshape(-1, 1)
    else:
        wave = _waves(ring.reading.reshape(-1, 3) @ start.matrix.T, -2)
        across = np.zeros((0, 2, 3))
        size = ring.gravity_m_s2 * np.sin(ring.tilt_rad)
        unit = wave / np.linalg.norm(wave, axis=2, keepdims=True)
        sd = np.sqrt(np.einsum("wci,wi->wc", (unit @ start.matrix) ** 2, ring.sd**2))
        row_sd = np.column_stack([sd, np.sqrt((sd**2).mean(axis=1))])
        stated = np.column_stack([size, size, np.zeros(len(size))])
        common = _gravity_and_tilt(poses, ring, size) / row_sd.reshape(-1, 1)
    return of_points, row_sd.ravel(), across, stated.ravel(), common


def _across(poses: PoseSet, ring: Ring, matrix: FloatArray, offset: FloatArray) -> FloatArray:
    """Along and across the way the plate leans where the wave begins, (w, 2, 3)."""
    up = np.sign(poses.spin_rad_s[ring.place])[:, None] * (
        poses.reading[ring.place] @ matrix.T + offset)
    up /= np.linalg.norm(up, axis=1, keepdims=True)
    lean = _waves(ring.force.reshape(-1, 3), -2)[:, 0]
    lean -= (lean * up).sum(axis=1, keepdims=True) * up
    lean /= np.linalg.norm(lean, axis=1, keepdims=True)
    return np.stack([lean, np.cross(up, lean)], axis=1)


def _of_the_room(ring: Ring, across: FloatArray) -> FloatArray:
    """What vectors fixed in the room along t1 and t2 where the wave begins show, (w, 2, 4)."""
    sine = _waves(ring.force.reshape(-1, 3), -2)[:, 1]
    turned = np.sign(np.einsum("wi,wi->w", sine, across[:, 1]))  # +1: gravity goes t1 to t2
    quarter = np.array([[0.0, 1.0], [-1.0, 0.0]])
    begin = np.broadcast_to(np.eye(2), (len(turned), 2, 2))
    return np.concatenate([begin, turned[:, None, None] * quarter], axis=2)


def _room(poses: PoseSet, ring: Ring, shown: FloatArray) -> FloatArray:
    """What an sd of the Earth's horizontal rate along and across the lean adds to each row, SI.

    ``shown`` (2, w, 4) is what a unit of each adds.
    """
    names = poses.reference.common_names
    common = np.zeros((len(ring.place), 4, len(names)))
    for i, place in enumerate(ring.place):
        for j, name in enumerate(room_names(poses.run[place])):
            if name in names:
                common[i, :, names.index(name)] = ring.room_rad_s[i] * shown[j, i]
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
