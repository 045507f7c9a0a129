"""Comparison of the model with the measurements: residuals and leave-one-out errors."""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from calib.fit.least_squares.gauss_newton import minimise, step_from
from calib.fit.least_squares.result import Fit
from calib.fit.linear import inverse_square, orthonormal_columns
from calib.fit.rows.problem import Estimate, Precision, Problem
from calib.fit.rows.residuals import Equations
from calib.numbers import NO_LENGTH
from calib.poses.imu_log import BoolArray, FloatArray, IntArray

LINEAR_SD = 0.01
"""Error of a linear step, in sds of a row, that leave-one-out errors may have. Numerical."""

LEFT_OUT = Precision(20, LINEAR_SD / 10)
"""Precision of the refit without a pose, which :data:`LINEAR_SD` allows; sets that have not
converged by then crawl along a valley, and their pose keeps the closed form. Numerical."""

LARGEST_LEVERAGE = 0.999
"""Leverage from which a pose has no useful leave-one-out error: the fit passes through it. A
judgement."""


@dataclass(frozen=True, eq=False)
class PoseResidual:
    """Comparison of one pose with the model, SI units.

    Attributes
    ----------
    label, run : str
    residual : float
        The magnitude less the reference's, or the length of what a null pose still reads; of a pose
        with rows of directions and waves the root mean square of all its rows in their sds, times
        ``sd``.
    sd : float
        Of ``residual``.
    left_out : float
        The same residual when the pose takes no part in the fit.
    """

    label: str
    run: str
    residual: float
    sd: float
    left_out: float

    @property
    def in_sd(self) -> float:
        """The residual in units of its sd."""
        return self.residual / self.sd


@dataclass(frozen=True, eq=False)
class Comparison:
    """Comparison of the model with the measurements.

    Attributes
    ----------
    poses : tuple of PoseResidual, length n
    residual_rms, loo_rms : float
        Root mean squares of the residuals, and of the residuals of poses that took no part, SI.
    loo_noise : float
        What ``loo_rms`` is by the noise of the poses alone, SI: where few poses hold a parameter
        up, the prediction of one of them rests on the others' noise, many times enlarged.
    loo_in_sd : float
        The error with every row in its own sd, since the rows of means, waves and poses at rest
        differ in what they can show.
    scatter : float
        Mean square of the errors in the sds of their predictions; one at least.
    log_density : float
        Log density of all poses by the predictions without them, up to a constant.
    """

    poses: tuple[PoseResidual, ...]
    residual_rms: float
    loo_rms: float
    loo_noise: float
    loo_in_sd: float
    scatter: float
    log_density: float

    def predicts_better_than(self, other: "Comparison") -> bool:
        """Whether left-out poses are nearer to this model than to the ``other``, and more probable.

        The distance alone does not compare models: of 14 sound poses the one that alone determines
        a parameter has an error of a hundred sds, and anything added to the model moves it. The
        density counts an error in sds of its prediction.
        """
        return self.loo_in_sd < other.loo_in_sd and self.log_density > other.log_density

    def worst(self, count: int) -> list[PoseResidual]:
        """The poses farthest from the model, in their own sds, the worst first."""
        return sorted(self.poses, key=lambda pose: -abs(pose.in_sd))[:count]


def pose_blocks(
    jacobian: FloatArray, pose: IntArray
) -> Iterator[tuple[IntArray, FloatArray, FloatArray]]:
    """Rows (m, b) of the poses that have b rows each, and their blocks of ``I - H``.

    These as eigenvalues (m, b), ascending, and eigenvectors (m, b, b).

    H is the hat matrix of ``jacobian`` (r, k), ``pose`` (d,) numbers the data rows' poses: the rows
    of a pose need not be adjacent, since its waves come after all means.
    """
    q = orthonormal_columns(jacobian)
    order = np.argsort(pose, kind="stable")
    _, first, count = np.unique(pose[order], return_index=True, return_counts=True)
    for size in np.unique(count):
        rows = order[first[count == size][:, None] + np.arange(size)]
        part = q[rows]
        yield rows, *np.linalg.eigh(np.eye(size) - part @ part.transpose(0, 2, 1))


def left_out_residual(residual: FloatArray, jacobian: FloatArray, pose: IntArray) -> FloatArray:
    """Whitened residual of every data row when its whole pose is left out of the fit.

    Closed form: ``(I - H_bb)^-1 r_b`` for the rows b of a pose, H the hat matrix.

    Parameters
    ----------
    residual, jacobian : array, shapes (r,) and (r, k)
        Whitened; prior rows may follow the d data rows.
    pose : array of int, shape (d,)
        Number of the pose of every data row.

    Returns
    -------
    array, shape (d,)
        In sds of the rows.
    """
    out = np.empty(len(pose))
    for rows, values, vectors in pose_blocks(jacobian, pose):
        values = np.maximum(values, 1 - LARGEST_LEVERAGE)
        turned = np.einsum("mji,mj->mi", vectors, residual[rows]) / values
        out[rows] = np.einsum("mij,mj->mi", vectors, turned)
    return out


def compare(fit: Fit) -> Comparison:
    """Compare the fitted model with every pose.

    Returns
    -------
    Comparison
        Leave-one-out errors are those of refits without the pose; shape parameters and the weights
        of a robust loss are held.
    """
    equations = fit.equations
    in_sd = refitted_residual(fit)
    left_out = equations.row_sd * in_sd
    values = np.stack([pose_errors(equations, fit.rows.residual), pose_sds(equations),
                       pose_errors(equations, in_sd)])
    poses = (
        PoseResidual(label, run, *of_pose) for label, run, of_pose in zip(
            fit.poses.label, fit.poses.run, values.T.tolist(), strict=True)
    )
    spread, scatter, log_density = _predicted(fit, in_sd)
    return Comparison(
        tuple(poses), fit.residual_rms, _rms(left_out), _rms(equations.row_sd * spread),
        _rms(in_sd), scatter, log_density)


def pose_sds(equations: Equations) -> FloatArray:
    """The sd of the length of every pose, SI, (n,)."""
    pose = equations.whitening.row_pose
    return np.sqrt(np.bincount(pose, equations.row_sd[: len(pose)]**2))


def pose_errors(equations: Equations, in_sd: FloatArray) -> FloatArray:
    """Error of every pose by its rows, :attr:`PoseResidual.residual`, SI, (n,).

    Parameters
    ----------
    equations : Equations
    in_sd : array, shape (r,)
        Errors of the data rows in their sds; prior rows may follow.
    """
    pose, of_means = equations.row_pose, equations.whitening.row_pose
    in_sd = in_sd[: len(pose)]
    error = (in_sd * equations.row_sd)[: len(of_means)]
    value = np.sqrt(np.bincount(of_means, error**2))
    value[equations.magnitude] = error[: len(equations.magnitude)]  # with their signs
    together = pose_sds(equations) * np.sqrt(np.bincount(pose, in_sd**2) / equations.row_count)
    return np.where(equations.row_count > np.bincount(of_means), together, value)


def _predicted(fit: Fit, out: FloatArray) -> tuple[FloatArray, float, float]:
    """Sds (d,) that errors ``out`` (d,) of poses left out have by noise, s², their log density.

    With H_bb of the rows b of a pose the errors have the covariance (I - H_bb)⁻¹ s², s² the scatter
    of all about their predictions, or one where the stated sds explain it and are known.
    """
    root, pose = np.sqrt(fit.weight), fit.equations.row_pose
    spread, square, log_det = np.empty(len(pose)), 0.0, 0.0
    for rows, values, vectors in pose_blocks(fit.weighted_jacobian, pose):
        values = np.maximum(values, 1 - LARGEST_LEVERAGE)
        turned = np.einsum("mji,mj->mi", vectors, out[rows] * root[rows])
        spread[rows] = np.sqrt(np.einsum("mij,mj->mi", vectors**2, 1 / values))
        square += float((values * turned**2).sum())
        log_det += float(np.log(values).sum())
    scatter = max(1.0, square / len(pose))
    return spread, scatter, -0.5 * (len(pose) * np.log(scatter) + square / scatter - log_det)


def _rms(values: FloatArray) -> float:
    return float(np.sqrt(np.mean(values**2)))


def refitted_residual(fit: Fit) -> FloatArray:
    """Whitened residual of every data row when its pose is left out of the fit, (d,).

    Each refit starts from the closed form of :func:`left_out_residual`, which is exact for a linear
    model and plain squares; where the step is too small for the nonlinearity of lengths, that is
    the refit. A pose without which the model is not determined, by its leverage or by a refit that
    does not converge, keeps the closed form, too. The
    refits are a stack, in which the rows of another pose have zero weight in each set. Weights of a
    robust loss are held: the influence of a pose on those of others is of second order, and its own
    is zero.
    """
    equations, root = fit.equations, np.sqrt(fit.weight)
    problem = Problem.of(equations.take(None), fit.basis[None], weight=fit.weight[None])
    problem = problem.with_shapes_held()
    pose, jacobian = equations.row_pose, fit.weighted_jacobian
    closed = left_out_residual(fit.rows.residual * root, jacobian, pose)
    out = closed / np.maximum(root[: len(pose)], NO_LENGTH)
    moved = np.zeros((len(fit.poses), jacobian.shape[1]))
    np.add.at(moved, pose, closed[:, None] * jacobian[: len(pose)])
    step = moved @ inverse_square(jacobian)
    # The bend of a length is |ds|²/2|s|: half the square of the move in sds, times sd/|s|.
    relative_sd = np.max(equations.magnitude_sd / equations.whitening.stated, initial=0.0)
    bend = np.abs(step @ jacobian.T).max(axis=1, initial=0.0) ** 2 * relative_sd / 2
    far = np.flatnonzero((bend >= LINEAR_SD) & (free_shares(fit) > 1 - LARGEST_LEVERAGE))
    if far.size:
        mine = pose == far[:, None]
        rows, known = _refitted(fit, problem, mine, step[far] @ fit.directions.T)
        chosen = mine & known[:, None]
        out[np.nonzero(chosen)[1]] = rows[:, : len(pose)][chosen]
    return out


def free_shares(fit: Fit) -> FloatArray:
    """Share of its error in its worst direction that the residual of each pose shows, (n,)."""
    pose, shares = fit.equations.row_pose, np.ones(len(fit.poses))
    for rows, values, _ in pose_blocks(fit.weighted_jacobian, pose):
        shares[pose[rows[:, 0]]] = values[:, 0]
    return shares


def _refitted(
    fit: Fit, problem: Problem, without: BoolArray, move: FloatArray
) -> tuple[FloatArray, BoolArray]:
    """Residuals (m, r) of m refits, and which of them exist, (m,).

    Each is ``without`` its rows (m, d) and begins a ``move`` (m, p + q) from the fit.
    """
    stack, p = problem.take(np.zeros(len(move), dtype=int)), fit.model.size
    weight = stack.weight.copy()
    weight[:, : without.shape[1]][without] = 0.0
    stack = replace(stack, weight=weight)
    shapes = {name: np.full(len(move), value) for name, value in fit.shapes.items()}
    at = Estimate.of(stack.equations, fit.theta + move[:, :p], fit.eta + move[:, p:], shapes)
    residual, known = at.rows.residual.copy(), at.rows.is_solved
    far = np.flatnonzero(known)
    if far.size:
        _, row_step = step_from(stack.take(far), at.take(far))
        residual[far] += row_step
        far = far[np.abs(row_step).max(axis=1) >= LINEAR_SD**0.5]
    if far.size:
        solution = minimise(stack.take(far), at.take(far), LEFT_OUT)
        residual[far] = solution.at.rows.residual
        known[far] = solution.is_converged
    return residual, known
