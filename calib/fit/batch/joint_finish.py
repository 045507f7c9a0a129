"""The fits that a stack ended in: :func:`calib.fit.least_squares.result.finish` for all at once."""

from functools import partial

import numpy as np

from calib.errors import CalibrationError
from calib.fit.batch.joint_descent import JointEstimate, JointProblem, joint_shape_derivatives
from calib.fit.batch.joint_equations import JointEquations
from calib.fit.batch.joint_rows import JointRows
from calib.fit.batch.linear_algebra import inverses
from calib.fit.column_scaling import RANK_TOLERANCE, pseudo_inverse_square, unit_columns
from calib.fit.least_squares.identifiability import (
    CONDITION_LIMIT,
    LARGEST_REFERENCE_ERROR,
    require_enough,
)
from calib.fit.least_squares.result import Fit
from calib.fit.model import stack_columns
from calib.fit.rows.sensitive_axes import Axes
from calib.fit.rows.whitened_rows import WhitenedRows
from calib.poses.imu_log import BoolArray, FloatArray, IntArray


def finish_jointly(
    problem: JointProblem, at: JointEstimate, iterations: IntArray
) -> list[Fit | None]:
    """The fits of S sets that went straight to their minimum.

    Parameters
    ----------
    problem : JointProblem
    at : JointEstimate
        Their minima.
    iterations : array of int, shape (S,)

    Returns
    -------
    list of Fit or None
        None where the poses do not determine the model, or the fit failed its own checks.
    """
    equations, q = problem.equations, at.eta.shape[1]
    p, v = at.theta.shape[1], problem.directions.shape[2] - q
    try:
        require_enough(equations.one, v + len(problem.free))
    except CalibrationError:
        return [None] * len(equations)
    basis = problem.directions[:, :p, :v]
    cov, log_shape_sd = _covariances(problem, at)
    sound = _is_determined(equations, at.rows, basis) & _is_of_size(equations, at.rows)
    sound &= np.isfinite(at.theta).all(axis=1) & np.isfinite(cov).all(axis=(1, 2))
    fits: list[Fit | None] = [None] * len(equations)
    for k in map(int, np.flatnonzero(sound)):
        each = equations.each[k]
        rows = rows_of(equations, at, k)
        fits[k] = Fit(
            poses=each.poses,
            model=each.model,
            theta=at.theta[k],
            cov=cov[k, :p, :p],
            common_shift=cov[k, :p, p:],
            eta=at.eta[k],
            shapes={name: float(value[k]) for name, value in at.shapes.items()},
            log_shape_sd={name: float(value[k]) for name, value in log_shape_sd.items()},
            equations=each,
            rows=rows,
            weight=np.ones(len(rows.residual)),
            basis=basis[k],
            iterations=int(iterations[k]),
        )
    return fits


def rows_of(equations: JointEquations, at: JointEstimate, k: int) -> WhitenedRows:
    """The rows of set ``k`` by itself."""
    rows, each = at.rows, equations.each[k]
    slope = None if rows.slope is None else rows.slope[k]
    axes = partial(Axes, rows.to_orthogonal[k], rows.to_sensed[k])
    if not equations.one.on_sensor:
        axes = partial(each.axes, at.theta[k])
    return WhitenedRows(rows.residual[k], rows.jacobian[k], rows.vector[k], slope, axes)


def _covariances(
    problem: JointProblem, at: JointEstimate
) -> tuple[FloatArray, dict[str, FloatArray]]:
    """Covariances (S, p + q, p + q), and the sds (S,) of the logarithms of the shapes.

    As of :func:`calib.fit.least_squares.result.finish`; NaN where a matrix has no inverse.
    """
    directions = problem.directions
    turned = directions.swapaxes(1, 2)
    linear = at.rows.jacobian @ directions
    if not problem.free:
        unit, norm = unit_columns(linear)
        inverse = inverses(np.asarray(np.linalg.qr(unit, mode="r"))) / norm[:, :, None]
        return directions @ (inverse @ inverse.swapaxes(1, 2)) @ turned, {}
    slope, _, _ = joint_shape_derivatives(problem.equations, at, list(problem.free))
    v = directions.shape[2]
    unknowns = pseudo_inverse_square(np.concatenate([linear, slope], axis=2))
    variance = np.einsum("skk->sk", unknowns)[:, v:]
    sd = np.where(slope.any(axis=1), np.sqrt(variance), np.nan)
    bound = np.array([shape.is_at_bound(at.shapes[name])
                      for name, shape in problem.free.items()]).T
    some = bound.any(axis=1)
    if some.any():
        held = np.where(bound[some][:, None], 0.0, slope[some])
        unknowns[some] = pseudo_inverse_square(np.concatenate([linear[some], held], axis=2))
    cov = directions @ unknowns[:, :v, :v] @ turned
    return cov, dict(zip(problem.free, sd.T, strict=True))


def _is_determined(
    equations: JointEquations, rows: JointRows, basis: FloatArray
) -> BoolArray:
    """Which sets (S,) pass :func:`..least_squares.identifiability.require_determined`."""
    one = equations.one
    p = one.model.size
    data = rows.jacobian[:, : one.data_count, :p].copy()
    if one.on_reading:
        at = equations.at_start.with_vector(rows.vector.reshape(-1, 3))
        columns = stack_columns(one.on_reading, at, {}).reshape(*rows.vector.shape, -1)
        data[:, :, one.reading_index] = equations.whitened(columns, rows.vector)
    combined = data @ basis
    singular = np.linalg.svd(unit_columns(combined)[0], compute_uv=False)
    limit = CONDITION_LIMIT if len(one.reading_index) == p else CONDITION_LIMIT**2
    least = np.maximum(1 / limit, RANK_TOLERANCE) * singular[:, 0]
    return np.asarray((singular[:, -1] >= least) & (combined != 0).any(axis=1).all(axis=1))


def _is_of_size(equations: JointEquations, rows: JointRows) -> BoolArray:
    """Which sets (S,) pass :func:`..least_squares.identifiability.require_size`."""
    turning = equations.one.magnitude
    if not len(turning):
        return np.ones(len(equations), dtype=bool)
    size = np.linalg.norm(rows.vector[:, turning], axis=2)
    share = np.median(size / equations.stated, axis=1)
    return np.asarray((share > 1 / LARGEST_REFERENCE_ERROR) & (share < LARGEST_REFERENCE_ERROR))
