"""What is minimised, and where a minimiser ended.

A calibration, its leave-one-out refits and the joint refits of a diagnosis are problems of one
kind; they differ in where they start, in what is held, and in how far they go.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from calib.effects.effect import Shape
from calib.fit.rows.residuals import Equations
from calib.fit.rows.shape_derivatives import ShapeDerivatives, shape_derivatives
from calib.fit.rows.whitened_rows import WhitenedRows
from calib.poses.imu_log import FloatArray

CONVERGED_SD = 1e-3
"""Where no row moves by more than this part of its sd, an iteration that stopped has converged.
Numerical."""


@dataclass(frozen=True)
class Precision:
    """How far to go.

    At most ``steps``, or until one has moved no row by more than ``step_sd`` sds. One that would
    move none by more than ``idle_sd`` is not taken.
    """

    steps: int
    step_sd: float
    idle_sd: float = 0.0


EXACT = Precision(60, 1e-7)
"""Of a calibration: Gauss-Newton then is closer to the minimum by another factor of the relative
residual, below 1e-9 in every parameter. Numerical."""


@dataclass(frozen=True, eq=False)
class Problem:
    """What is minimised, ``Σ_i w_i r_i(theta, eta, shapes)²``, over what.

    Parameters
    ----------
    equations : Equations
        The r rows, of p parameters and q common errors.
    basis : array, shape (p, v)
        The combinations of parameters along which theta moves.
    weight : array, shape (r,)
        Of every row; 0 takes no part.
    robust : bool
        Whether Huber's loss takes more weight off rows far from the model.
    free : mapping of effect name to Shape
        The h shape parameters that move; all others are held where the start has them.
    """

    equations: Equations
    basis: FloatArray
    weight: FloatArray
    robust: bool
    free: Mapping[str, Shape]

    @classmethod
    def of(cls, equations: Equations, basis: FloatArray, robust: bool = False) -> "Problem":
        """All rows in full, all shape parameters free."""
        weight = np.ones(equations.data_count + equations.common.shape[1])
        free = {e.name: e.shape for e in equations.model.effects if e.shape is not None}
        return cls(equations, basis, weight, robust, free)

    def with_shapes_held(self) -> "Problem":
        """The same with no shape parameter free."""
        return replace(self, free={})

    @cached_property
    def directions(self) -> FloatArray:
        """What theta and eta move along, (p + q, v + q), in their units: ``basis``, each of eta."""
        return with_common(self.basis, self.equations.common.shape[1])


def with_common(basis: FloatArray, common: int) -> FloatArray:
    """A basis of the parameters extended by the common errors, which are always fitted.

    Parameters
    ----------
    basis : array, shape (p, v)
    common : int
        Their number q.

    Returns
    -------
    array, shape (p + q, v + q)
        In their units.
    """
    p, v = basis.shape
    full = np.zeros((p + common, v + common))
    full[:p, :v] = basis
    full[p:, v:] = np.eye(common)
    return full


@dataclass(frozen=True, eq=False)
class Estimate:
    """A point: ``theta`` (p,), ``eta`` (q,), every shape parameter, and the rows there."""

    theta: FloatArray
    eta: FloatArray
    shapes: dict[str, float]
    rows: WhitenedRows

    @classmethod
    def of(
        cls,
        equations: Equations,
        theta: FloatArray,
        eta: FloatArray,
        shapes: Mapping[str, float],
    ) -> "Estimate":
        """The estimate at these parameters; raises FitFailed where no true vectors belong to it."""
        return cls(theta, eta, dict(shapes), equations.rows(theta, eta, shapes))

    def shape_derivatives(self, problem: Problem) -> ShapeDerivatives:
        """Derivatives of the rows by the logarithms of the free shape parameters."""
        return shape_derivatives(
            problem.equations, self.theta, self.eta, self.shapes, self.rows, tuple(problem.free)
        )

    def cost(self, weight: FloatArray) -> float:
        """Weighted sum of squares."""
        return float(weight @ self.rows.residual**2)


@dataclass(frozen=True, eq=False)
class Solution:
    """Where the minimiser ended.

    ``weight`` (r,) is that of every row, ``last_step_sd`` by how many sds the last step moved the
    row that it moved most.
    """

    at: Estimate
    weight: FloatArray
    iterations: int
    last_step_sd: float

    @property
    def cost(self) -> float:
        """Weighted sum of squares."""
        return self.at.cost(self.weight)

    @property
    def is_converged(self) -> bool:
        """Whether the iteration came to rest."""
        return bool(np.isfinite(self.cost) and self.last_step_sd < CONVERGED_SD)
