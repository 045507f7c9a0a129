"""The fits that S sets ended in: their covariances, and which of them are refused."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from scipy.special import fdtrc

from calib.errors import FitFailed
from calib.fit.column_scaling import pseudo_inverse_square
from calib.fit.least_squares.identifiability import (
    Refusals,
    misfitting_sizes,
    too_few,
    undetermined_sets,
)
from calib.fit.least_squares.result import Fit
from calib.fit.model import Model
from calib.fit.rows.problem import Estimate, Problem, Solution
from calib.fit.rows.residuals import Equations
from calib.fit.rows.whitened_rows import WhitenedRows
from calib.fit.small_systems import inverse_square
from calib.fit.stacked import Stacked
from calib.poses.imu_log import FloatArray, IntArray
from calib.poses.pose_set import PoseSet

OUTLIER_SD = 4.0
"""Rows beyond are no noise of the stated sd: of normal rows one in 16000 is. Derived."""


@dataclass(frozen=True, eq=False)
class FittedSets(Stacked):
    """The fits of S sets side by side.

    Parameters
    ----------
    problem : Problem
    at : Estimate
        The solution.
    weight : array, shape (S, r)
    cov : array, shape (S, p + q, p + q)
        Covariance of theta and eta, by the stated sds.
    log_shape_sd : mapping of str to array, shape (S,)
    iterations : array of int, shape (S,)
    """

    problem: Problem
    at: Estimate
    weight: FloatArray
    cov: FloatArray
    log_shape_sd: Mapping[str, FloatArray]
    iterations: IntArray

    def __len__(self) -> int:
        return len(self.iterations)

    @property
    def equations(self) -> Equations:
        """The rows of the sets."""
        return self.problem.equations

    @property
    def rows(self) -> WhitenedRows:
        """What they are at the solutions."""
        return self.at.rows

    @property
    def model(self) -> Model:
        """The model of all sets."""
        return self.equations.model

    @property
    def poses(self) -> PoseSet:
        """The poses of the first set."""
        return self.equations.poses

    @property
    def noise_dof(self) -> FloatArray:
        """Degrees of freedom, no unit, behind the sds of the poses, (S,)."""
        return np.array([poses.noise_dof for poses in self.equations.surroundings.sets])

    @property
    def chi2(self) -> FloatArray:
        """Sum of the squared whitened residuals, no unit, (S,)."""
        return self.at.rows.chi2

    @property
    def dof(self) -> IntArray:
        """Data rows less parameters, (S,)."""
        count = self.problem.equations.data_count
        return np.asarray(count - self.problem.moves - len(self.log_shape_sd))

    @property
    def p_value(self) -> FloatArray:
        """Probability of residuals so large if the model and the stated sds hold, no unit, (S,)."""
        return np.asarray(fdtrc(self.dof, self.noise_dof, self.chi2 / self.dof))

    @property
    def sd(self) -> FloatArray:
        """Sds of theta, SI, (S, p)."""
        variance = np.einsum("spp->sp", self.cov)[:, : self.at.theta.shape[1]]
        return np.asarray(np.sqrt(variance))

    def one(self, k: int) -> Fit:
        """The fit of set ``k``: what a session gets, without the leading axis."""
        one = self.take(k)
        equations, at, p = one.problem.equations, one.at, len(one.at.theta)
        return Fit(
            poses=equations.poses,
            model=equations.model,
            theta=at.theta,
            cov=one.cov[:p, :p],
            common_shift=one.cov[:p, p:],
            eta=at.eta,
            shapes={name: float(value) for name, value in at.shapes.items()},
            log_shape_sd={name: float(value) for name, value in one.log_shape_sd.items()},
            equations=equations,
            rows=at.rows,
            weight=one.weight,
            basis=one.problem.basis[:, : int(self.problem.moves[k])],
            iterations=int(one.iterations),
        )


def finish(problem: Problem, solution: Solution) -> tuple[FittedSets, Refusals]:
    """Check that solutions are determined and finite, and give them their covariances.

    Parameters
    ----------
    problem : Problem
    solution : Solution
        Of the problem; shape parameters that are not free in it are known, not unknown.

    Returns
    -------
    fitted : FittedSets
        Of all S sets.
    refusals : dict of int to CalibrationError
        Of those whose poses do not determine the model, or of which no finite parameters are left,
        or whose gains went to nothing.
    """
    equations, at, p = problem.equations, solution.at, problem.equations.model.size
    fitted = FittedSets(problem, at, solution.weight, *_covariance(problem, solution),
                        solution.iterations)
    pull = _pull_of_outliers(at.rows, solution.weight, fitted.cov)
    fitted.cov[:, :p, :p] += pull[:, :p, :p]
    finite = np.isfinite(at.theta).all(axis=1) & np.isfinite(fitted.cov).all(axis=(1, 2))
    refusals = {
        **misfitting_sizes(equations, at.rows),
        **{int(k): _not_finite(equations) for k in np.flatnonzero(~finite)},
        **undetermined_sets(equations, at, problem.basis),
        **too_few(equations, problem.moves + len(problem.free)),
    }
    return fitted, refusals


def _not_finite(equations: Equations) -> FitFailed:
    return FitFailed(
        f"the fit of the {equations.poses.triad} ended without finite parameters. Check the "
        f"log for poses that are not what they should be."
    )


def _covariance(
    problem: Problem, solution: Solution
) -> tuple[FloatArray, dict[str, FloatArray]]:
    """Covariances (S, p + q, p + q) of theta and eta, and the sds (S,) of the shapes' logarithms.

    Free shape parameters are further unknowns. At a bound the value is the bound's, and nothing
    else depends on it; NaN is the sd of one that no row feels.
    """
    no_sd = {name: np.full(len(solution.weight), np.nan)
             for name in problem.tried if name not in problem.free}
    at, root, directions = solution.at, np.sqrt(solution.weight)[..., None], problem.directions
    linear = at.rows.jacobian @ directions
    if not problem.free:
        return directions @ inverse_square(linear * root) @ directions.swapaxes(1, 2), no_sd
    slope, v = at.shape_derivatives(problem).slope, directions.shape[2]
    unknowns = pseudo_inverse_square(np.concatenate([linear, slope], axis=2) * root)
    variance = np.einsum("skk->sk", unknowns)[:, v:]
    sd = np.where(slope.any(axis=1), np.sqrt(variance), np.nan)
    at_bound = np.array([shape.is_at_bound(at.shapes[name])
                         for name, shape in problem.free.items()]).T
    if at_bound.any():
        slope = np.where(at_bound[:, None], 0.0, slope)
        unknowns = pseudo_inverse_square(np.concatenate([linear, slope], axis=2) * root)
    cov = directions @ unknowns[:, :v, :v] @ directions.swapaxes(1, 2)
    return cov, {**no_sd, **dict(zip(problem.free, sd.T, strict=True))}


def _pull_of_outliers(rows: WhitenedRows, weight: FloatArray, cov: FloatArray) -> FloatArray:
    """What rows that are no noise may still move the estimates by, as covariances like ``cov``.

    Huber's loss bounds the pull of a row at ``HUBER_SD``, whatever its residual: it is no noise of
    the row any more, and of either sign.
    """
    bounded = (weight < 1) & (np.abs(rows.residual) > OUTLIER_SD)
    if not bounded.any():
        return np.zeros_like(cov)
    pull = np.where(bounded, weight * rows.residual, 0.0)
    pulled = cov @ (rows.jacobian * pull[..., None]).swapaxes(1, 2)
    return np.asarray(pulled @ pulled.swapaxes(1, 2))
