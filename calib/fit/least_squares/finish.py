"""End of the fits of S sets: covariances and refusals."""


import numpy as np

from calib.errors import FitFailed
from calib.fit.least_squares.identifiability import (
    Refusals,
    misfitting_sizes,
    too_few,
    undetermined_sets,
)
from calib.fit.least_squares.result import Fit
from calib.fit.linear import inverse_square, pseudo_inverse_square
from calib.fit.rows.problem import Problem, Solution
from calib.fit.rows.whitened_rows import WhitenedRows
from calib.poses.imu_log import FloatArray, Triad

OUTLIER_SD = 4.0
"""Residual, sds, that noise of the stated sd does not reach: of normal rows one in 16000 does.
Derived."""


def finish(problem: Problem, solution: Solution) -> tuple[Fit, Refusals]:
    """Check that solutions are determined and finite, and give them their covariances.

    Parameters
    ----------
    problem : Problem
    solution : Solution
        Of the problem; shape parameters that are not free in it are known, not unknown.

    Returns
    -------
    fitted : Fit
        Of all S sets.
    refusals : dict of int to CalibrationError
        Of those whose poses do not determine the model, or of which no finite parameters are left,
        or whose gains went to nothing.
    """
    equations, at, p = problem.equations, solution.at, problem.equations.model.size
    cov, log_shape_sd = _covariance(problem, solution)
    pull = _pull_of_outliers(at.rows, solution.weight, cov)
    fitted = Fit(equations, at, solution.weight, problem.basis, cov[:, :p, :p] + pull[:, :p, :p],
                 cov[:, :p, p:], log_shape_sd, solution.iterations)
    finite = np.isfinite(at.theta).all(axis=1) & np.isfinite(cov).all(axis=(1, 2))
    refusals = {
        **misfitting_sizes(equations, at.rows),
        **{int(k): _not_finite(equations.poses.triad) for k in np.flatnonzero(~finite)},
        **undetermined_sets(equations, at, problem.basis),
        **too_few(equations, problem.moves + len(problem.free)),
    }
    return fitted, refusals


def _not_finite(triad: Triad) -> FitFailed:
    return FitFailed(
        f"the fit of the {triad} ended without finite parameters. Check the "
        f"log for poses that are not what they should be."
    )


def _covariance(
    problem: Problem, solution: Solution
) -> tuple[FloatArray, dict[str, FloatArray]]:
    """Covariances (S, p + q, p + q) of theta and eta, and the sds (S,) of the shapes' logarithms.

    Free shape parameters are further unknowns. At a bound the value is fixed, and nothing else
    depends on it; the sd is NaN if no row depends on the parameter.
    """
    no_sd = {name: np.full(len(solution.weight), np.nan)
             for name in problem.tried if name not in problem.free}
    at, root, directions = solution.at, np.sqrt(solution.weight)[..., None], problem.directions
    linear = at.rows.jacobian @ directions
    if not problem.free:
        return directions @ inverse_square(linear * root) @ directions.swapaxes(1, 2), no_sd
    slope = at.shape_derivatives(problem.equations, problem.free).slope
    v = directions.shape[2]
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
    """Covariances like ``cov`` of what outlying rows may still move the estimates by.

    Huber's loss bounds the influence of a row at ``HUBER_SD``, whatever its residual: such a
    residual is not the row's noise, and may have either sign.
    """
    bounded = (weight < 1) & (np.abs(rows.residual) > OUTLIER_SD)
    if not bounded.any():
        return np.zeros_like(cov)
    pull = np.where(bounded, weight * rows.residual, 0.0)
    pulled = cov @ (rows.jacobian * pull[..., None]).swapaxes(1, 2)
    return np.asarray(pulled @ pulled.swapaxes(1, 2))
