"""The minimisation problem and its solution.

A calibration, its leave-one-out refits and the joint refits of a diagnosis are problems of one
kind; they differ in their start, in what is held, and in their precision. All records have a
leading axis for S sets, which are minimised side by side.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from calib.effects.effect import Shape
from calib.fit.rows.residuals import Equations
from calib.fit.rows.whitened_rows import WhitenedRows
from calib.fit.stacked import Stacked
from calib.poses.imu_log import BoolArray, FloatArray, IntArray

CONVERGED_SD = 1e-3
"""Largest move of a row, in sds, at which an iteration that stopped has converged. Numerical."""


@dataclass(frozen=True)
class Precision:
    """Precision of a minimisation.

    At most ``steps``, or until one has moved no row by more than ``step_sd`` sds. A step that would
    move none by more than ``idle_sd`` is not taken.
    """

    steps: int
    step_sd: float
    idle_sd: float = 0.0


EXACT = Precision(60, 1e-7)
"""Precision of a calibration: Gauss-Newton then is closer to the minimum by another factor of the
relative residual, below 1e-9 in every parameter. Numerical."""


@dataclass(frozen=True, eq=False)
class Problem(Stacked):
    """Objective ``Σ_i w_i r_i(theta, eta, shapes)²`` and its unknowns.

    Parameters
    ----------
    equations : Equations
        The r rows of S sets, of p parameters and q common errors.
    basis : array, shape (S, p, v)
        The combinations of parameters along which theta moves; the last columns are zero in a set
        that moves along fewer than others.
    weight : array, shape (S, r)
        Of every row; 0 takes no part.
    robust : bool
        Whether Huber's loss takes more weight off rows far from the model.
    free : mapping of effect name to Shape
        The h shape parameters that move; all others are held at their start.
    tried : mapping of effect name to Shape
        Those and the ones of which only the starts are tried: a time between two poses.
    """

    equations: Equations
    basis: FloatArray
    weight: FloatArray
    robust: bool
    free: Mapping[str, Shape]
    tried: Mapping[str, Shape]

    @classmethod
    def of(
        cls,
        equations: Equations,
        basis: FloatArray,
        robust: bool = False,
        weight: FloatArray | None = None,
    ) -> "Problem":
        """All rows in full or with a ``weight`` (S, r), all shape parameters free.

        ``basis`` (S, p, v) is in the parameters' units.
        """
        if weight is None:
            weight = np.ones((len(basis), equations.data_count + equations.common_count))
        shapes = {e.name: e.shape for e in equations.model.effects
                  if e.shape is not None and not e.drawn}
        free = {name: shape for name, shape in shapes.items() if shape.is_fitted}
        tried = {name: shape for name, shape in shapes.items()
                 if shape.is_fitted or len(shape.starts) > 1}
        return cls(equations, basis, weight, robust, free, tried)

    def with_shapes_held(self) -> "Problem":
        """The same with no shape parameter free."""
        return replace(self, free={}, tried={})

    @property
    def moves(self) -> IntArray:
        """Number of combinations along which theta moves, (S,)."""
        return np.asarray(self.basis.any(axis=1).sum(axis=1))

    @cached_property
    def directions(self) -> FloatArray:
        """Directions of theta and eta, (S, p + q, v + q), in their units: ``basis``, each eta."""
        return with_common(self.basis, self.equations.common_count)


def with_common(basis: FloatArray, common: int) -> FloatArray:
    """A basis of the parameters extended by the common errors, which are always fitted.

    Parameters
    ----------
    basis : array, shape (..., p, v)
    common : int
        Their number q.

    Returns
    -------
    array, shape (..., p + q, q + v)
        In their units; the common errors first.
    """
    *lead, p, v = basis.shape
    full = np.zeros((*lead, p + common, v + common))
    full[..., :p, common:] = basis
    full[..., p:, :common] = np.eye(common)
    return full


DIFFERENCE_STEP = 1e-3
"""Step of the logarithm of a shape parameter: central differences are exact to 1e-6 of themselves.
Numerical."""


@dataclass(frozen=True, eq=False)
class ShapeDerivatives:
    """Derivatives of the r whitened rows by the logarithms of h shape parameters.

    ``slope`` (..., r, h) the first, ``curvature`` (..., r, h) the second, ``mixed`` (..., r, p, h)
    the second by theta and the shape.
    """

    slope: FloatArray
    curvature: FloatArray
    mixed: FloatArray


@dataclass(frozen=True, eq=False)
class Estimate(Stacked):
    """A point of each set: ``theta`` (S, p), ``eta`` (S, q), the ``shapes`` (S,), and the rows."""

    theta: FloatArray
    eta: FloatArray
    shapes: Mapping[str, FloatArray]
    rows: WhitenedRows

    @classmethod
    def of(
        cls,
        equations: Equations,
        theta: FloatArray,
        eta: FloatArray,
        shapes: Mapping[str, FloatArray],
    ) -> "Estimate":
        """The estimates at these parameters; their rows are NaN where they have no true vectors."""
        with np.errstate(all="ignore"):
            return cls(theta, eta, shapes, equations.rows(theta, eta, shapes))

    def shape_derivatives(self, equations: Equations, names: Iterable[str]) -> ShapeDerivatives:
        """Derivatives of the rows by the logarithms of the shapes of effects, by differences."""
        step, p, shapes = DIFFERENCE_STEP, self.theta.shape[-1], self.shapes
        pairs = [[equations.rows(self.theta, self.eta,
                                 {**shapes, name: shapes[name] * np.exp(change)})
                  for change in (-step, step)] for name in names]
        down, up = (np.stack([pair[k].residual for pair in pairs], axis=-1) for k in (0, 1))
        mixed = np.stack([(high.jacobian - low.jacobian)[..., :p] for low, high in pairs], axis=-1)
        bent = up + down - 2 * self.rows.residual[..., None]
        return ShapeDerivatives((up - down) / (2 * step), bent / step**2, mixed / (2 * step))

    def cost(self, weight: FloatArray) -> FloatArray:
        """Weighted sum of squares, no unit, (S,); infinite where there are no true vectors."""
        cost = (weight * self.rows.residual**2).sum(axis=-1)
        return np.asarray(np.where(np.isfinite(cost), cost, np.inf))


@dataclass(frozen=True, eq=False)
class Solution(Stacked):
    """End point of the minimiser in each of S sets.

    ``weight`` (S, r) is that of every row, ``iterations`` (S,) how many steps it took,
    ``last_step_sd`` (S,) by how many sds the last one moved the row that it moved most.
    """

    at: Estimate
    weight: FloatArray
    iterations: IntArray
    last_step_sd: FloatArray

    @property
    def cost(self) -> FloatArray:
        """Weighted sum of squares, no unit, (S,)."""
        return self.at.cost(self.weight)

    @property
    def is_converged(self) -> BoolArray:
        """Whether the iteration converged, (S,)."""
        return np.isfinite(self.cost) & (self.last_step_sd < CONVERGED_SD)
