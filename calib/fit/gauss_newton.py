"""Weighted Gauss-Newton with the exact Jacobian, and its robust variant.

One step solves the column-scaled rows by QR; it is halved while the cost rises. The combinations of
parameters that the poses cannot see stay where they are: steps run along ``basis``.
"""

from collections.abc import Mapping

import numpy as np

from calib.errors import FitFailed
from calib.fit.identifiability import require_determined
from calib.fit.residuals import Equations, Rows
from calib.poses.imu_log import FloatArray

ITERATIONS = 60
STEP_SD = 1e-7
"""Converged once no parameter moves by more than this part of its own sd; Gauss-Newton then is
closer to the minimum by another factor of the relative residual, below 1e-9 in every parameter."""

HALVINGS = 12
HUBER_SD = 1.5
ROBUST_ROUNDS = 30


def with_common(basis: FloatArray, common: int) -> FloatArray:
    """``basis`` (p, v) extended by the ``common`` errors, which are always fitted."""
    p, v = basis.shape
    full = np.zeros((p + common, v + common))
    full[:p, :v] = basis
    full[p:, v:] = np.eye(common)
    return full


def step_of(rows: Rows, weight: FloatArray, basis: FloatArray) -> FloatArray:
    """Gauss-Newton step for theta and eta along ``basis``, column-scaled, by QR."""
    root = np.sqrt(weight)
    jacobian = (rows.jacobian @ basis) * root[:, None]
    scale = np.sqrt((jacobian**2).sum(axis=0))
    scale[scale == 0] = 1.0
    q, r = np.linalg.qr(jacobian / scale)
    diagonal = np.abs(np.diag(r))
    if diagonal.min() < 1e-12 * diagonal.max():
        # Singular here; require_determined says so in words once the iteration has ended.
        step = np.linalg.lstsq(jacobian / scale, -rows.residual * root, rcond=1e-10)[0]
    else:
        step = np.linalg.solve(r, -(q.T @ (rows.residual * root)))
    return np.asarray(basis @ (step / scale))


def iterate(
    equations: Equations,
    theta: FloatArray,
    eta: FloatArray,
    shapes: Mapping[str, float],
    weight: FloatArray,
    basis: FloatArray,
) -> tuple[FloatArray, FloatArray, Rows, int]:
    """Gauss-Newton with step halving from ``theta``, ``eta`` to the minimum along ``basis``.

    Raises
    ------
    FitFailed
        Not converged within ``ITERATIONS``, or no finite value was left.
    Undetermined
        The same, because the poses do not determine the model.
    """
    p = equations.model.size
    parameters, basis = basis, with_common(basis, len(eta))
    rows = equations.rows(theta, eta, shapes)
    cost = float(weight @ rows.residual**2)
    for iteration in range(1, ITERATIONS + 1):
        step = step_of(rows, weight, basis)
        for _ in range(HALVINGS):
            try:
                trial = equations.rows(theta + step[:p], eta + step[p:], shapes)
                trial_cost = float(weight @ trial.residual**2)
            except FitFailed:
                trial_cost = np.inf
            if trial_cost <= cost * (1 + 1e-10) + 1e-12:
                break
            step = step / 2
        else:
            break
        theta, eta, rows, cost = theta + step[:p], eta + step[p:], trial, trial_cost
        if float(np.abs(rows.jacobian @ step).max()) < STEP_SD:
            return theta, eta, rows, iteration
    if np.isfinite(cost) and float(np.abs(rows.jacobian @ step).max()) < 1e-3:
        return theta, eta, rows, iteration
    require_determined(equations, rows, parameters)
    raise FitFailed(
        f"the fit of the {equations.poses.triad} did not converge in {ITERATIONS} steps. The "
        f"data-sheet values may be far off (full scale, bits, encoding), or poses may be spoilt: "
        f"look at the readings of each pose, and check sensor.{equations.poses.triad}."
    )


def huber_weight(residual: FloatArray) -> FloatArray:
    """Weights of Huber's loss: rows beyond ``HUBER_SD`` count in proportion to 1/|residual|."""
    return np.asarray(np.minimum(1.0, HUBER_SD / np.maximum(np.abs(residual), 1e-300)))


def minimise(
    equations: Equations,
    theta: FloatArray,
    shapes: Mapping[str, float],
    basis: FloatArray,
    robust: bool,
) -> tuple[FloatArray, FloatArray, Rows, FloatArray, int]:
    """The minimum at given shape parameters; reweighted until steady with the robust loss."""
    eta = np.zeros(equations.common.shape[1])
    weight = np.ones(equations.data_count + len(eta))
    theta, eta, rows, iterations = iterate(equations, theta, eta, shapes, weight, basis)
    if robust:
        for _ in range(ROBUST_ROUNDS):
            new = huber_weight(rows.residual)
            new[equations.data_count :] = 1.0
            change = float(np.abs(new - weight).max())
            weight = new
            theta, eta, rows, more = iterate(equations, theta, eta, shapes, weight, basis)
            iterations += more
            if change < 1e-6:
                break
    return theta, eta, rows, weight, iterations
