"""The rows that are fitted, and their exact derivatives.

    magnitude row   (|s_i| (1 - R_i eta) - m_i - D_i theta) / sd_i
    null row        (s_i - expected_i) (1 - R eta) / sd_i, three of them, R the mean of the R_i
    axis row, wave row    of a plate that leans, :mod:`calib.fit.rows.axis_rows`, ``wave_rows``
    prior row       eta_j, one for each error that several references have in common

All rows have unit variance when the stated sds hold. ``eta`` are the common errors of the
references in units of their own sd; carrying them as unknowns with a prior puts the sd of a shared
rate into the scale, where it does not average down. R is their size relative to the reference, and
it acts on the magnitude of the model, not on the one that was measured, and on the rows of a
gyroscope that have no reference as on the others: otherwise a gain that shrinks together with the
reference would shrink any misfit too, and gain would be lost to it (Peelle's puzzle).

Arrays have a leading axis for the S sets of a stack, and none for one set: (..., n, 3).
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from calib.effects.effect import Effect
from calib.fit.linear import combined, times
from calib.fit.model import Model
from calib.fit.rows.axis_rows import AxisRows, whitened_references
from calib.fit.rows.initial_estimate import Start
from calib.fit.rows.model_terms import ModelTerms, Surroundings
from calib.fit.rows.readings import Readings
from calib.fit.rows.sensitive_axes import Shapes, axes_of, evaluate_for
from calib.fit.rows.wave_rows import WaveRows
from calib.fit.rows.whitened_rows import WhitenedRows, Whitening, lengths
from calib.fit.stacked import Stacked
from calib.poses.conditions import Conditions
from calib.poses.imu_log import FloatArray, IntArray
from calib.poses.pose_set import PoseSet


@dataclass(frozen=True, eq=False)
class Equations(Stacked):
    """The rows of pose sets under one model: the part that iterations do not change.

    Parameters
    ----------
    whitening : Whitening
        What the poses decide: order and sds of the magnitude rows and the null rows.
    readings : Readings
        What the model makes of the readings.
    axis : AxisRows or None
        The rows of the axis of a leaning plate, which stand behind those.
    waves : WaveRows or None
        The rows of its waves, which stand behind those.
    """

    whitening: Whitening
    readings: Readings
    axis: AxisRows | None
    waves: WaveRows | None

    @classmethod
    def of_sets(
        cls, sets: Sequence[PoseSet], model: Model, start: Start | None = None
    ) -> "Equations":
        """The rows of S sets, with a leading axis.

        Parameters
        ----------
        sets : sequence of PoseSet
            With rest and rings in the same poses, as many common errors and the same columns.
        model : Model
        start : Start, optional
            Their ellipsoids, where they are known already.
        """
        whitening = Whitening.of(sets, start)
        reading = np.array([poses.reading for poses in sets])
        vector = whitening.start.corrected(reading)
        sensed = axes_of(whitening.start.matrix).sensed(vector)
        surroundings = Surroundings(tuple(sets), vector.reshape(-1, 3), sensed.reshape(-1, 3))
        return cls(whitening, Readings.of(reading, surroundings, model),
                   AxisRows.of(sets, whitening.start),
                   WaveRows.of(surroundings, whitening.start, model))

    @classmethod
    def of(cls, poses: PoseSet, model: Model) -> "Equations":
        """The rows of one set of poses, without a leading axis."""
        return cls.of_sets((poses,), model).take(0)

    def extended(self, effects: Sequence[Effect]) -> "Equations":
        """The rows of the same poses under the model with more ``effects``."""
        waves = self.waves and replace(self.waves, points=self.waves.points.extended(effects))
        return Equations(self.whitening, self.readings.extended(effects), self.axis, waves)

    def after(self, sensed: FloatArray) -> "Equations":
        """The same rows after the ``sensed`` vectors (..., n, 3) of the poses before, SI."""
        later = replace(self.surroundings, sensed=sensed.reshape(-1, 3))
        waves = self.waves and self.waves.after(later)
        return Equations(self.whitening, self.readings.within(later), self.axis, waves)

    @property
    def terms(self) -> ModelTerms:
        """Terms of the model."""
        return self.readings.terms

    @property
    def surroundings(self) -> Surroundings:
        """Conditions at which effects are evaluated."""
        return self.readings.surroundings

    @property
    def model(self) -> Model:
        """The model."""
        return self.terms.model

    @property
    def poses(self) -> PoseSet:
        """The poses of the only set, or of the first."""
        return self.surroundings.sets[0]

    @property
    def at_reading(self) -> Conditions:
        """The conditions of all sets with the nominal readings."""
        return self.surroundings.at_reading

    @property
    def at_start(self) -> Conditions:
        """The conditions of all sets with the vectors of the start."""
        return self.surroundings.at_start

    @property
    def start(self) -> Start:
        """The ellipsoids of the poses."""
        return self.whitening.start

    @property
    def magnitude(self) -> IntArray:
        """Indices of the poses with a magnitude row, (k,)."""
        return self.whitening.magnitude

    @property
    def null(self) -> IntArray:
        """Indices of the poses with three null rows, (m,)."""
        return self.whitening.null

    @property
    def wave_count(self) -> int:
        """Number of wave rows, the last of the data rows."""
        return self.waves.count if self.waves else 0

    @cached_property
    def row_pose(self) -> IntArray:
        """Pose of every data row (the prior rows left out), shape (d,)."""
        more = [each.row_pose for each in (self.axis, self.waves) if each]
        return np.concatenate([self.whitening.row_pose, *more])

    @cached_property
    def row_count(self) -> IntArray:
        """Number of data rows of every pose, shape (n,): 1 where its length is all that counts."""
        return np.bincount(self.row_pose)

    @property
    def data_count(self) -> int:
        """Number d of data rows."""
        return len(self.row_pose)

    @property
    def common_count(self) -> int:
        """Number q of errors that several references have in common."""
        return int(self.whitening.common_relative.shape[-1])

    @cached_property
    def row_common(self) -> FloatArray:
        """Sds of the common errors over the gain of each data row, no unit, (..., d, q)."""
        return self.whitening.common_of_rows(self.data_count, self.poses.triad)

    @property
    def magnitude_sd(self) -> FloatArray:
        """Sds of the magnitude rows, SI, (..., k)."""
        return self.whitening.magnitude_sd

    @property
    def row_sd(self) -> FloatArray:
        """Sd of every data row in SI units, shape (..., d)."""
        more = [each.row_sd for each in (self.axis, self.waves) if each]
        return np.concatenate([self.whitening.row_sd, *more], axis=-1)

    def conditions(self, vector: FloatArray) -> Conditions:
        """Conditions of the effects at the corrected vectors (..., n, 3), SI."""
        return self.surroundings.conditions(vector)

    def directions(self, s: FloatArray, slope: FloatArray | None = None) -> FloatArray:
        """Sensitivity of each data row to an error of its pose's vector, (..., d, 3), per SI unit.

        See :meth:`calib.fit.rows.whitened_rows.Whitening.directions`; a constant makes no wave.
        """
        shown = [self.whitening.directions(s, slope)]
        if self.axis:
            shown.append(self.axis.directions(slope))
        if self.waves:
            shown.append(np.zeros((*s.shape[:-2], self.wave_count, 3)))
        return np.concatenate(shown, axis=-2)

    def whitened(self, vectors: FloatArray, s: FloatArray) -> FloatArray:
        """Data rows that errors (..., n, 3, k) of the corrected vectors s (..., n, 3) cause.

        Shape (..., d, k), in sds of the rows; the errors and the vectors are in SI units.
        """
        return self._shown(self.directions(s), vectors)

    def _shown(self, directions: FloatArray, vectors: FloatArray) -> FloatArray:
        """Data rows (..., d, 3) times errors (..., n, 3, k) of the vectors, (..., d, k)."""
        of_rows = vectors[..., self.row_pose, :, :]
        return np.asarray(np.einsum("...di,...dik->...dk", directions, of_rows))

    def of_reference(self, errors: FloatArray) -> FloatArray:
        """Data rows that errors (..., n, k) of the references cause, whitened, (..., d, k)."""
        return whitened_references(self.whitening, self.waves, self.data_count,
                                   self.at_reading.magnitude, errors)

    def rows(self, theta: FloatArray, eta: FloatArray, shapes: Shapes) -> WhitenedRows:
        """Whitened residual and exact Jacobian.

        Parameters
        ----------
        theta, eta : array, shapes (..., p) and (..., q)
            Parameters of the model, SI, and common errors in their sds.
        shapes : mapping of effect name to shape parameter
            Of each set.

        Returns
        -------
        WhitenedRows
            NaN in a set of a stack where the effects of the sensor are larger than the readings.

        Raises
        ------
        FitFailed
            Those of the only set are larger than the readings.
        """
        whitening, terms = self.whitening, self.terms
        s, errors, slope = self.readings.corrected(theta, shapes)
        drawn = whitening.on_vector
        if drawn is not None:
            s = s - combined(drawn, eta)
        directions, points = self.directions(s, slope), None
        k, d, p, q = len(whitening.magnitude), self.data_count, theta.shape[-1], eta.shape[-1]
        size = lengths(s[..., whitening.magnitude, :])
        share = 1 - times(self.row_common, eta)  # of the true magnitude

        magnitude_rows = (size * share[..., :k] - whitening.stated) / self.magnitude_sd
        expected = self.surroundings.expected.reshape(s.shape)
        rest = (s - expected)[..., whitening.null, :] / whitening.null_sd
        parts = [magnitude_rows, rest.reshape(*rest.shape[:-2], 3 * len(whitening.null))]
        directions[..., :k, :] *= share[..., :k, None]
        jacobian = np.zeros((*eta.shape[:-1], d + q, p + q))
        jacobian[..., :d, :p] = -self._shown(directions, errors)
        jacobian[..., :k, p:] = -whitening.common_relative * (size / self.magnitude_sd)[..., None]
        jacobian[..., d:, p:] = np.eye(q)
        if drawn is not None:
            jacobian[..., :d, p:] -= self._shown(self.directions(s), drawn)
        if self.axis:
            jacobian[..., k + 3 * len(whitening.null) : d - self.wave_count, p:] = -self.axis.common
            parts.append(self.axis.residual(s, eta))
        if self.waves:
            waves, jacobian[..., d - self.wave_count : d, :], points = self.waves.rows(
                theta, eta, shapes)
            parts.append(waves)
        residual = np.concatenate([*parts, eta], axis=-1)
        jacobian[..., k:d, :] *= share[..., k:, None]
        jacobian[..., k:d, p:] -= self.row_common[..., k:, :] * residual[..., k:d, None]
        residual[..., k:d] *= share[..., k:]
        if terms.reference:
            of_reference = self.of_reference(np.concatenate([
                evaluate_for(eta.shape[:-1], effect, self.at_reading, shapes)
                for effect in terms.reference.effects], axis=-1))
            where = terms.reference.index
            residual[..., :d] -= times(of_reference, theta[..., where])
            jacobian[..., :d, where] -= of_reference
        return WhitenedRows(residual, jacobian, s, slope, theta[..., terms.reading.index], terms,
                            points)
