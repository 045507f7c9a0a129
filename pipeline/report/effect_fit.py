"""One effect beside a fit: its whitened columns, its least squares, and the errors that remain.

With y the whitened residual, J the Jacobian of the model, C the columns of the effect and h_a the
change of every row per unit error of axis a,

    θ      least squares of y on C, with J projected out of both
    after  residual of the model with the effect
    error of axis a in pose p      Σ h after / Σ h²,    sd  1 / sqrt(Σ h²)

the sums over the rows of the pose.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from scipy.special import fdtrc

from calib.effects.effect import Effect
from calib.effects.variation import about_mean
from calib.fit.column_scaling import unit_columns
from calib.fit.least_squares.identifiability import VISIBLE_SHARE
from calib.fit.least_squares.result import MISFIT_P_VALUE, Fit
from calib.fit.rows.sensitive_axes import ALIGNED
from calib.poses.conditions import Conditions
from calib.poses.imu_log import FloatArray
from pipeline.report.drivers import NOTHING

Rows = tuple[FloatArray, FloatArray]


def whitened_columns(fit: Fit, effect: Effect, shape: float | None = None) -> FloatArray:
    """What one unit of every parameter adds to the whitened data rows, (d, k)."""
    equations, value = fit.equations, fit.shapes.get(effect.name, shape)
    if effect.acts_on == "reference":
        varying = about_mean(effect, fit.model.names)
        columns = varying.evaluate(equations.conditions(fit.rows.vector), value)
        return reference_rows(fit) * columns[equations.row_pose]
    turn, at = sensed_conditions(fit, effect)
    return equations.whitened(turn @ errors_of(fit, effect, at, value), fit.rows.vector)


def errors_of(
    fit: Fit, effect: Effect, at: Conditions, shape: float | None = None
) -> FloatArray:
    """Errors of the axes per unit of every parameter, (n, 3, k).

    Of an effect that is a bias or a gain where nothing varies, about their mean, as the solver
    judges what is seen of it.
    """
    return about_mean(effect, fit.model.names).evaluate(at, shape)


def sensed_conditions(fit: Fit, effect: Effect) -> tuple[FloatArray, Conditions]:
    """T (3, 3), no unit, from the axes that the effect acts on; the conditions that they felt."""
    axes = ALIGNED if effect.orthogonal else fit.rows.axes
    at = fit.equations.conditions(fit.rows.vector)
    return axes.to_orthogonal, replace(at, vector=axes.sensed(at.vector))


def reference_rows(fit: Fit) -> FloatArray:
    """Change of every whitened data row per unit error of the reference, (d, 1)."""
    weight = np.zeros((fit.equations.data_count, 1))
    weight[: len(fit.equations.magnitude), 0] = 1 / fit.equations.magnitude_sd
    return weight


def solve_effect(
    fit: Fit, effect: Effect, columns: FloatArray, beside: Sequence[FloatArray]
) -> tuple[FloatArray, FloatArray, FloatArray] | None:
    """θ (k,), its sd (k,), and the residual with the effect (d,), in sds.

    None where these poses do not determine it. The sd has the Birge ratio in it where noise does
    not explain the residual with the effect. ``columns`` (d, k) and each array of ``beside`` are
    whitened data rows per unit of a parameter.
    """
    d = fit.equations.data_count
    if effect.name in fit.model.names:
        where = fit.model.slices()[effect.name]
        return fit.theta[where], np.sqrt(np.diag(fit.cov)[where]), fit.rows.residual[:d]
    root = np.sqrt(fit.weight)
    norm = np.sqrt((columns**2).sum(axis=0))
    if not (np.isfinite(norm).all() and (norm > 0).all()):
        return None
    full = over_all_rows(columns / norm, len(root))
    known = [fit.rows.jacobian, *(over_all_rows(other, len(root)) for other in beside)]
    jacobian = np.hstack(known) * root[:, None]
    q, r = np.linalg.qr(unit_columns(jacobian)[0])
    q = q[:, np.abs(np.diag(r)) > NOTHING]
    rest = full * root[:, None]
    rest = rest - q @ (q.T @ rest)
    u, size, vt = np.linalg.svd(rest, full_matrices=False)
    if size[-1] < VISIBLE_SHARE:
        return None
    y = fit.rows.residual * root
    y = y - q @ (q.T @ y)
    theta = vt.T @ ((u.T @ y) / size)
    sd = np.sqrt(((vt.T / size) ** 2).sum(axis=1))
    remainder = y - rest @ theta
    dof = max(fit.dof - len(theta) - sum(other.shape[1] for other in beside), 1)
    ratio = float(remainder @ remainder) / dof
    if fdtrc(dof, fit.poses.noise_dof, ratio) < MISFIT_P_VALUE:
        sd = sd * np.sqrt(ratio)
    return theta / norm, sd / norm, remainder[:d] / np.maximum(root[:d], NOTHING)


def error_per_pose(fit: Fit, h: FloatArray, after: FloatArray) -> Rows:
    """Error of one axis that remains in every pose, and its sd, SI (n,); infinite where unseen."""
    pose, n = fit.equations.row_pose, len(fit.poses)
    weight = np.bincount(pose, h**2, n)
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.bincount(pose, h * after, n) / weight, 1 / np.sqrt(weight)


def over_all_rows(columns: FloatArray, rows: int) -> FloatArray:
    """``columns`` (d, k) over all ``rows``, (rows, k), in their unit: effects leave the prior
    rows alone.
    """
    return np.vstack([columns, np.zeros((rows - len(columns), columns.shape[1]))])
