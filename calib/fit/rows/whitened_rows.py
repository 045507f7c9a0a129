"""The rows at one estimate, each divided by its sd, common errors included."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from calib.fit.linear import solutions
from calib.fit.rows.initial_estimate import Start, starts_of
from calib.fit.rows.model_terms import ModelTerms
from calib.fit.rows.sensitive_axes import Axes, axes_of
from calib.fit.stacked import Stacked
from calib.numbers import NO_LENGTH
from calib.poses.imu_log import BoolArray, FloatArray, IntArray, Triad
from calib.poses.pose_set import PoseSet


@dataclass(frozen=True, eq=False)
class WhitenedRows(Stacked):
    """Whitened rows at one estimate for each set, or for one set without the leading axis.

    ``residual`` (..., r), ``jacobian`` (..., r, p + q) with the q common errors last, ``vector``
    (..., n, 3) the corrected vectors, ``slope`` (..., n, 3, 3) what effects that follow the vector
    make of its changes (None without such effects), ``of_reading`` (..., p') the parameters of the
    reading there, ``points`` (..., w k, 3) the corrected points of the rings of a leaning plate
    (None on a level one). The first rows are the magnitude rows, then the null rows, the wave rows
    and the priors. All are NaN where no true vectors belong to the estimate.
    """

    residual: FloatArray
    jacobian: FloatArray
    vector: FloatArray
    slope: FloatArray | None
    of_reading: FloatArray
    terms: ModelTerms
    points: FloatArray | None = None

    @cached_property
    def axes(self) -> Axes:
        """The sensitive axes at the estimate."""
        return axes_of(self.terms.matrix(self.of_reading))

    @property
    def is_solved(self) -> BoolArray:
        """Whether true vectors belong to the estimate, (...,)."""
        return np.asarray(np.isfinite(self.residual).all(axis=-1))

    @property
    def chi2(self) -> FloatArray:
        """Sum of the squared whitened residuals, (...,)."""
        return np.asarray((self.residual**2).sum(axis=-1))


@dataclass(frozen=True, eq=False)
class Whitening(Stacked):
    """References and sds of the rows of S sets of n poses.

    Parameters
    ----------
    is_null : tuple of bool, length n
        The m poses with three null rows, in every set; the k others have a magnitude row.
    start : Start
        The ellipsoids of the poses.
    stated : array, shape (S, k)
        Reference magnitudes, SI.
    magnitude_sd, null_sd : array, shapes (S, k) and (S, m, 3)
        Sds of the rows, SI, that of the reference included.
    common_relative : array, shape (S, k, q)
        The common errors relative to the reference.
    on_vector : array, shape (S, n, 3, q), or None
        What they add to the vectors, SI.
    """

    is_null: tuple[bool, ...]
    start: Start
    stated: FloatArray
    magnitude_sd: FloatArray
    null_sd: FloatArray
    common_relative: FloatArray
    on_vector: FloatArray | None = None

    @classmethod
    def of(cls, sets: Sequence[PoseSet], start: Start | None = None) -> "Whitening":
        """The whitening of ``sets``; ``start`` are their ellipsoids where they are known already.

        Sds are known in nominal units, and a data sheet can be a third off: the start's matrix
        converts them to true units. |s| has the sd of s along its own direction.
        """
        is_null = sets[0].reference.is_null
        turning, null = np.flatnonzero(~is_null), np.flatnonzero(is_null)
        sd = np.array([poses.sd for poses in sets])
        stated = np.array([poses.reference.magnitude for poses in sets])[:, turning]
        reference_sd = np.array([poses.reference.sd for poses in sets])
        common = np.array([poses.reference.common for poses in sets])[:, turning]
        start = start or starts_of(*_of_known_size(sets, turning))
        s = start.corrected(np.array([poses.reading for poses in sets])[:, turning])
        direction = s / np.maximum(lengths(s)[..., None], NO_LENGTH)
        along = (((direction @ start.matrix) * sd[:, turning]) ** 2).sum(axis=2)
        across = sd[:, null] ** 2 @ (start.matrix**2).swapaxes(1, 2)
        return cls(
            is_null=tuple(is_null.tolist()),
            start=start,
            stated=stated,
            magnitude_sd=np.sqrt(along + reference_sd[:, turning] ** 2),
            null_sd=np.sqrt(across + reference_sd[:, null, None] ** 2),
            common_relative=common / stated[..., None],
            on_vector=None if sets[0].reference.on_vector is None else
            np.array([poses.reference.on_vector for poses in sets]),
        )

    @cached_property
    def magnitude(self) -> IntArray:
        """Indices of the poses with a magnitude row, (k,)."""
        return np.flatnonzero(~np.array(self.is_null, bool))

    @cached_property
    def null(self) -> IntArray:
        """Indices of the poses with null rows, (m,)."""
        return np.flatnonzero(self.is_null)

    @cached_property
    def row_pose(self) -> IntArray:
        """Pose of every magnitude and null row, shape (d,)."""
        return np.concatenate([self.magnitude, np.repeat(self.null, 3)])

    @property
    def row_sd(self) -> FloatArray:
        """Sd of every row in SI units, shape (..., d)."""
        *lead, m, _ = self.null_sd.shape
        return np.concatenate([self.magnitude_sd, self.null_sd.reshape(*lead, 3 * m)], axis=-1)

    def common_of_rows(self, count: int, triad: Triad) -> FloatArray:
        """The common errors over the gain of each data row, no unit, (..., count, q).

        Rows without a reference, those of a gyroscope at rest, across its axis and of its waves,
        depend on the gain by all references: their noise is that of the counts.
        """
        *lead, k, q = self.common_relative.shape
        rows = np.zeros((*lead, count, q))
        rows[..., :k, :] = self.common_relative
        if k and triad == "gyroscope":
            rows[..., k:, :] = self.common_relative.mean(axis=-2, keepdims=True)
        return rows

    def directions(self, s: FloatArray, slope: FloatArray | None = None) -> FloatArray:
        """Sensitivity of each row to an error of its pose's vector, (..., d, 3), per SI unit.

        Parameters
        ----------
        s : array, shape (..., n, 3)
            The corrected vectors.
        slope : array, shape (..., n, 3, 3), optional
            ``I + C'``; with it the error is that ahead of the effects that follow the vector.
        """
        turning = s[..., self.magnitude, :]
        along = turning / (np.maximum(lengths(turning), NO_LENGTH) * self.magnitude_sd)[..., None]
        if slope is not None:
            transposed = slope[..., self.magnitude, :, :].swapaxes(-1, -2)
            along = solutions(transposed, along[..., None])[..., 0]
        if not len(self.null):
            return np.asarray(along)
        at_rest = np.eye(3) / self.null_sd[..., None]
        *lead, m, _, _ = at_rest.shape
        return np.concatenate([along, at_rest.reshape(*lead, 3 * m, 3)], axis=-2)


def _of_known_size(sets: Sequence[PoseSet], turning: IntArray) -> tuple[FloatArray, FloatArray]:
    """Readings (S, k, 3) and the magnitudes (S, k) that they show, SI.

    Over its ring, a pose of an accelerometer on a leaning plate shows the whole of gravity.
    """
    reading = [poses.reading[turning] for poses in sets]
    size = [poses.reference.magnitude[turning] for poses in sets]
    for i, poses in enumerate(sets):
        if (ring := poses.ring) is not None and np.isfinite(ring.gravity_m_s2).all():
            kept = ~np.isin(turning, ring.place)
            points = ring.reading.reshape(-1, 3)
            gravity = np.repeat(ring.gravity_m_s2, ring.reading.shape[1])
            reading[i] = np.concatenate([reading[i][kept], points])
            size[i] = np.concatenate([size[i][kept], gravity])
    return np.array(reading), np.array(size)


def lengths(vectors: FloatArray) -> FloatArray:
    """Lengths (...,) of vectors (..., 3), in their unit."""
    return np.asarray(np.sqrt((vectors**2).sum(axis=-1)))
