"""The rows that are fitted, their exact derivatives, and a start that needs no initial values.

    magnitude row   (|s_i| - m_i - D_i theta - C_i eta) / sd_i
    null row        (s_i - expected_i) / sd_i, three of them
    prior row       eta_j, one for each error that several references have in common

All rows have unit variance when the stated sds hold. ``eta`` are the common errors of the
references in units of their own sd; carrying them as unknowns with a prior puts the sd of a shared
rate into the scale, where it does not average down.

**Start**: readings of one magnitude m satisfy ``(y - b)ᵀ Q (y - b) = m²`` with ``Q = MᵀM``.
Divided by ``m² - bᵀQb`` this is linear in nine unknowns, ``yᵀQ'y - 2 v'ᵀy = 1``: a least squares
gives M (the Cholesky factor of Q, upper triangular) and c = -M b. Where the poses are too few or
too alike for that, the data sheet is the start.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from calib.fit.model import Model, follows_vector, pick, sensor_slope, solve_sensor, stack_columns
from calib.poses.conditions import Conditions
from calib.poses.imu_log import FloatArray, IntArray
from calib.poses.pose_set import PoseSet

UNKNOWNS = 9
SMALLEST_SINGULAR_VALUE = 1e-6
SAME_MAGNITUDE = 0.01
"""Plate rates this close (both directions of one setting) count as one for the start."""

NO_LENGTH = 1e-300
"""A vector of no length has no direction; what a fit makes of it is refused at its end."""


@dataclass(frozen=True, eq=False)
class Start:
    """``matrix`` M (3, 3) and ``offset`` c (3,) of the linear form that the fit starts from."""

    matrix: FloatArray
    offset: FloatArray

    @property
    def bias(self) -> FloatArray:
        """The nominal reading at which the corrected vector is zero, (3,)."""
        return np.asarray(np.linalg.solve(self.matrix, -self.offset))

    def theta(self, model: Model) -> FloatArray:
        """Start values (p,): bias, scale and misalignment of the ellipsoid, 0 elsewhere."""
        upper = self.matrix
        values = {
            "bias": -self.offset,
            "scale": 1 - np.diag(upper),
            "misalignment": -np.array([upper[1, 2], upper[0, 2], upper[0, 1]]),
        }
        theta = np.zeros(model.size)
        for name, where in model.slices().items():
            if name in values:
                theta[where] = values[name]
        return theta


def start_of(poses: PoseSet) -> Start:
    """The ellipsoid of the poses where they span one, else the data sheet."""
    found = _ellipsoid(*_one_magnitude(poses))
    return Start(np.eye(3), np.zeros(3)) if found is None else Start(*found)


def _one_magnitude(poses: PoseSet) -> tuple[FloatArray, float]:
    """Readings of the magnitude that most poses share, and that magnitude."""
    m = poses.reference.magnitude
    turning = m[m > 0]
    if turning.size == 0:
        return np.zeros((0, 3)), 0.0
    alike = np.abs(m[:, None] / turning - 1) < SAME_MAGNITUDE
    chosen = alike[:, int(np.argmax(alike.sum(axis=0)))]
    return poses.reading[chosen], float(m[chosen].mean())


def _ellipsoid(y: FloatArray, m: float) -> tuple[FloatArray, FloatArray] | None:
    """M (3, 3) upper triangular and c (3,) of the ellipsoid through ``y`` (n, 3), or None."""
    if len(y) < UNKNOWNS:
        return None
    x = y / m
    products = 2 * x[:, [0, 0, 1]] * x[:, [1, 2, 2]]
    design = np.concatenate([x**2, products, -2 * x], axis=1)
    solution, _, rank, singular = np.linalg.lstsq(design, np.ones(len(x)), rcond=None)
    if rank < UNKNOWNS or singular[-1] < SMALLEST_SINGULAR_VALUE * singular[0]:
        return None
    xx, yy, zz, xy, xz, yz = solution[:6]
    q = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    try:
        centre = np.linalg.solve(q, solution[6:])
        upper = np.linalg.cholesky(q / (1 + centre @ q @ centre)).T
    except np.linalg.LinAlgError:  # a paraboloid or worse: the poses do not span an ellipsoid
        return None
    return upper, -upper @ centre * m


@dataclass(frozen=True, eq=False)
class Rows:
    """Whitened rows at one estimate.

    ``residual`` (r,), ``jacobian`` (r, p + q) with the q common errors last, ``vector`` (n, 3) the
    corrected vectors. The first rows are the magnitude rows, then the null rows, then the priors.
    """

    residual: FloatArray
    jacobian: FloatArray
    vector: FloatArray

    @property
    def chi2(self) -> float:
        """Sum of the squared whitened residuals."""
        return float(self.residual @ self.residual)


class Equations:
    """The rows of one pose set under one model; holds what does not change between iterations.

    ``pushed`` (n, 3) is what each axis felt in its pose, for the memory of the pose before; the
    start's bias taken off the readings where it is not given.
    """

    def __init__(self, poses: PoseSet, model: Model, pushed: FloatArray | None = None) -> None:
        self.poses, self.model = poses, model
        y = poses.reading
        reference = poses.reference
        self.magnitude = np.flatnonzero(~reference.is_null)
        self.null = np.flatnonzero(reference.is_null)
        self.on_reading = model.acting_on("reading")
        self.on_sensor = model.acting_on("sensor")
        self.on_reference = model.acting_on("reference")
        self.reading_index = pick(model, self.on_reading)
        self.sensor_index = pick(model, self.on_sensor)
        self.reference_index = pick(model, self.on_reference)
        self.is_null = reference.is_null
        self.at_reading = poses.conditions(y)
        self.reading_columns = (
            stack_columns(self.on_reading, self.at_reading, {})
            if self.on_reading
            else np.zeros((*y.shape, 0))
        )
        self.reference_columns = (
            np.concatenate([e.evaluate(self.at_reading) for e in self.on_reference], axis=1)
            if self.on_reference
            else np.zeros((len(y), 0))
        )
        # Sds are known in nominal units, and a data sheet can be a third off: the start's matrix
        # takes them to true units. |s| has the sd of s along its own direction.
        self.start = start_of(poses)
        s = y @ self.start.matrix.T + self.start.offset
        self.at_start = poses.conditions(s, y - self.start.bias if pushed is None else pushed)
        direction = s / np.maximum(np.linalg.norm(s, axis=1, keepdims=True), 1e-300)
        along = (((direction @ self.start.matrix) * poses.sd) ** 2).sum(axis=1)
        across = poses.sd**2 @ (self.start.matrix**2).T
        self.magnitude_sd = np.sqrt(along + reference.sd**2)[self.magnitude]
        self.null_sd = np.sqrt(across + reference.sd[:, None] ** 2)[self.null]
        self.common = reference.common[self.magnitude]
        self.varying = tuple(e for e in self.on_sensor if follows_vector(e, self.at_start))
        self.varying_index = pick(model, self.varying)

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

    def corrected(self, theta: FloatArray, shapes: Mapping[str, float]) -> FloatArray:
        """The corrected vectors s at ``theta``, shape (n, 3)."""
        s = self.at_reading.vector - self.reading_columns @ theta[self.reading_index]
        if self.on_sensor:
            s = solve_sensor(self.on_sensor, theta[self.sensor_index], shapes, self.conditions, s)
        return s

    def _vector_jacobian(
        self, theta: FloatArray, shapes: Mapping[str, float], s: FloatArray
    ) -> FloatArray:
        """ds/dtheta, shape (n, 3, p)."""
        jacobian = np.zeros((*s.shape, self.model.size))
        jacobian[:, :, self.reading_index] = -self.reading_columns
        if self.on_sensor:
            at = self.conditions(s)
            jacobian[:, :, self.sensor_index] = -stack_columns(self.on_sensor, at, shapes)
            if self.varying:
                jacobian = np.linalg.solve(self.slope(theta, shapes, at), jacobian)
        return jacobian

    def slope(
        self, theta: FloatArray, shapes: Mapping[str, float], at: Conditions
    ) -> FloatArray:
        """``I + d(F theta)/ds``, shape (n, 3, 3); null poses are held at what they should read."""
        slope = sensor_slope(self.varying, theta[self.varying_index], shapes, at)
        slope[self.null] = np.eye(3)
        return slope

    def rows(self, theta: FloatArray, eta: FloatArray, shapes: Mapping[str, float]) -> Rows:
        """Whitened residual and exact Jacobian at ``theta`` (p,), ``eta`` (q,)."""
        s = self.corrected(theta, shapes)
        ds = self._vector_jacobian(theta, shapes, s)
        p, q, k = self.model.size, len(eta), len(self.magnitude)
        residual = np.empty(self.data_count + q)
        jacobian = np.zeros((self.data_count + q, p + q))

        s_turning = s[self.magnitude]
        size = np.sqrt((s_turning**2).sum(axis=1))
        n = s_turning / np.maximum(size, NO_LENGTH)[:, None]
        reference = self.poses.reference.magnitude[self.magnitude] + self.common @ eta
        residual[:k] = (size - reference) / self.magnitude_sd
        jacobian[:k, :p] = np.einsum("ni,nip->np", n, ds[self.magnitude])
        if self.on_reference:
            columns = self.reference_columns[self.magnitude]
            residual[:k] -= columns @ theta[self.reference_index] / self.magnitude_sd
            jacobian[:k, self.reference_index] -= columns
        jacobian[:k, p:] = -self.common
        jacobian[:k] /= self.magnitude_sd[:, None]

        if len(self.null):
            rest = s[self.null] - self.poses.expected[self.null]
            residual[k : self.data_count] = (rest / self.null_sd).ravel()
            jacobian[k : self.data_count, :p] = (ds[self.null] / self.null_sd[:, :, None]).reshape(
                -1, p
            )
        residual[self.data_count :] = eta
        jacobian[self.data_count :, p:] = np.eye(q)
        return Rows(residual, jacobian, s)
