"""Rows of the waves of poses on a leaning plate, once and twice per turn.

Effects are evaluated at the points of a pose's ring (:mod:`calib.poses.runs.ring`) in the same way
as at poses; the harmonics of the corrected vectors s(θ) are the corrected waves, of cosine c and
sine d. A constant error makes no wave: these rows depend on no bias, no drift, no step.

Accelerometer, under gravity that rotates with g sin τ, once and then twice per turn:

    |c| - g sin τ,   |d| - g sin τ,   c·d / (√2 g sin τ);      c₂,   d₂

The tilt τ is an error that these rows and the magnitudes of the means have in common, with a prior
so wide that they alone decide. Of c to d₂ is taken what the wow of the plate makes of the force f
by the distance from the spindle: where it is p cos hθ + q sin hθ of the rate, and the plate turns
about n,

    2p f - h q n × f,   2q f + h p n × f

Twice per turn nothing but an effect goes round: with these rows the sds of a quadratic effect are
0.81 and 0.52 times as large at 9° and 20°, those of an asymmetry 0.71 and 0.45 times, and those of
a gyroscope's effects 0.98 times at best (``python -m tests.bench.study_tilt --sessions twice --tilt
9 20``), so that a gyroscope has none.

Gyroscope, across the axis n of the plate, where only what is fixed in the room varies in step with
the turning:

    t·(c - h_c),   t·(d - h_d),   t the two unit vectors across n

with h the Earth's rate: of its vertical part sin τ, which is known, and of its horizontal part, of
known size, two unknown components for each run, along and across the way the plate leans. What goes
along n is wow, and no row has it.
"""

from dataclasses import dataclass, replace

import numpy as np

from calib.effects.effect import Effect
from calib.fit.linear import solutions, times
from calib.fit.model import Model
from calib.fit.rows.initial_estimate import Start
from calib.fit.rows.model_terms import Surroundings
from calib.fit.rows.readings import Readings
from calib.fit.rows.ring_terms import RingTerms, waves_round
from calib.fit.rows.sensitive_axes import Shapes, evaluate_for, sensor_columns
from calib.fit.rows.whitened_rows import WhitenedRows
from calib.fit.stacked import Stacked
from calib.poses.conditions import PLACE_COLUMN
from calib.poses.imu_log import FloatArray, IntArray
from calib.poses.pose_set import PoseSet
from calib.poses.runs.ring import ANGLES

TWICE = 6  #: rows of what comes twice per turn: cosine and sine of three axes; definition


@dataclass(frozen=True, eq=False)
class WaveRows(Stacked):
    """The rows of the w rings of each of S sets of poses.

    Attributes
    ----------
    points : Readings
        Those of the k points of every ring.
    places : tuple of int, length w
        Which poses have rings, in every set.
    twice : tuple of int
        Which rings have the six rows of what comes twice per turn; they stand behind the others.
    of_rings : RingTerms
    """

    points: Readings
    places: tuple[int, ...]
    twice: tuple[int, ...]
    of_rings: RingTerms

    @classmethod
    def of(cls, surroundings: Surroundings, start: Start, model: Model) -> "WaveRows | None":
        """The rows of the waves of poses that start at ``start``; None on a level plate."""
        rings = [poses.ring for poses in surroundings.sets if poses.ring is not None]
        if not rings:
            return None
        place, twice = rings[0].place, rings[0].twice
        sets = tuple(map(_points_of, surroundings.sets))
        reading = np.array([poses.reading for poses in sets])
        vector = start.corrected(reading).reshape(-1, 3)
        of_points = Surroundings(sets, vector, vector, _previous(surroundings, place))
        return cls(Readings.of(reading, of_points, model), tuple(map(int, place)),
                   tuple(map(int, twice)), RingTerms.of(surroundings.sets, start))

    def after(self, surroundings: Surroundings) -> "WaveRows":
        """The same rows after other previous poses, those of ``surroundings``."""
        previous = _previous(surroundings, np.array(self.places))
        return replace(self, points=self.points.within(
            replace(self.points.surroundings, previous=previous)))

    @property
    def of_gravity(self) -> bool:
        """Whether gravity rotates in the readings, as in an accelerometer."""
        return bool(self.of_rings.across.shape[-3] == 0)

    @property
    def row_sd(self) -> FloatArray:
        """The sds of the rows, SI, (..., d')."""
        return self.of_rings.row_sd

    @property
    def common(self) -> FloatArray:
        """Shift of a row's reference by an sd of each common error, in its sds, (..., d', q)."""
        return self.of_rings.common

    @property
    def count(self) -> int:
        """Number d' of rows of a set."""
        return int(self.row_sd.shape[-1])

    @property
    def row_pose(self) -> IntArray:
        """Pose of every row, (d',)."""
        places = np.array(self.places)
        return np.concatenate([np.repeat(places, self.once_count // len(places)),
                               np.repeat(places[[*self.twice]], TWICE)])

    @property
    def once_count(self) -> int:
        """Number of rows of the waves once per turn, the first ones."""
        return self.count - TWICE * len(self.twice)

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
        value, shown = self._values(waves_round(s, -2) - self.of_rings.by_wow)
        residual = (value - self.of_rings.stated) / self.row_sd - times(self.common, eta)
        jacobian = -self._seen(shown, errors)
        return residual, np.concatenate([jacobian, -self.common], axis=-1), s

    def columns(
        self, rows: WhitenedRows, effect: Effect, shape: float | None = None
    ) -> FloatArray:
        """Whitened rows of an effect that is not corrected.

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
        return self._seen(self._values(waves_round(s, -2) - self.of_rings.by_wow)[1], errors)

    def _seen(self, shown: FloatArray, errors: FloatArray) -> FloatArray:
        """Whitened errors (..., d', k) of the rows by errors (..., w k', 3, k) of the points.

        The rows once per turn show ``shown`` (..., w, r, 2, 3) of their waves.
        """
        wave = waves_round(errors, -3)
        lead, k = self.row_sd.shape[:-1], errors.shape[-1]
        once = np.einsum("...wrci,...wcik->...wrk", shown, wave[..., :2, :, :])
        twice = wave[..., [*self.twice], 2:, :, :]
        both = [once.reshape(*lead, -1, k), twice.reshape(*lead, -1, k)]
        return np.asarray(np.concatenate(both, axis=-2) / self.row_sd[..., None])

    def _values(self, waves: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Values (..., d') of the rows at the waves (..., w, 4, 3), SI.

        And what those of the waves once per turn show of them, (..., w, r, 2, 3).
        """
        wave, twice = waves[..., :2, :], waves[..., [*self.twice], 2:, :]
        *lead, w, _, _ = wave.shape
        if not self.of_gravity:
            shown = np.zeros((*lead, w, 4, 2, 3))
            shown[..., :2, 0, :] = self.of_rings.across
            shown[..., 2:, 1, :] = self.of_rings.across
            values = np.einsum("...wrci,...wci->...wr", shown, wave)
            return values.reshape(*lead, 4 * w), shown
        shown = np.zeros((*lead, w, 3, 2, 3))
        length = np.linalg.norm(wave, axis=-1)
        shown[..., [0, 1], [0, 1], :] = wave / length[..., None]
        size = np.sqrt(2) * self.of_rings.stated[..., : 3 * w : 3, None]  # g sin τ
        shown[..., 2, :, :] = wave[..., ::-1, :] / size[..., None]
        mixed = (wave[..., 0, :] * wave[..., 1, :]).sum(axis=-1, keepdims=True) / size
        once = np.concatenate([length, mixed], axis=-1).reshape(*lead, 3 * w)
        return np.concatenate([once, twice.reshape(*lead, -1)], axis=-1), shown


def _previous(surroundings: Surroundings, place: IntArray) -> FloatArray:
    """Vectors sensed before the poses at ``place`` of each set, for their points."""
    sets = len(surroundings.sets)
    of_sets = surroundings.at_start.previous.reshape(sets, -1, 3)
    return of_sets[:, np.repeat(place, ANGLES)].reshape(-1, 3)


def _points_of(poses: PoseSet) -> PoseSet:
    """The points of the rings of one set as poses."""
    ring = poses.ring
    assert ring is not None
    place = np.repeat(ring.place, ANGLES)
    points = replace(poses, ring=None).take(place)
    return replace(points, reading=ring.reading.reshape(-1, 3), force=ring.force.reshape(-1, 3),
                   columns={**points.columns, PLACE_COLUMN: place.astype(float)})
