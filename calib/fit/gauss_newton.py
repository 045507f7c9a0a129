"""Weighted Gauss-Newton with the exact Jacobian, and its robust variant.

One step solves the column-scaled rows by QR; it is halved while the cost rises. The combinations of
parameters that the poses cannot see stay where they are: steps run along ``basis``. The robust
loss (Huber) reweights the rows until the weights are steady.
"""

from collections.abc import Mapping

import numpy as np

from calib.errors import FitFailed, Remedy
from calib.fit.column_scaling import unit_columns
from calib.fit.identifiability import require_determined
from calib.fit.residuals import Equations, WhitenedRows
from calib.fit.result import HUBER_SD, Solution, with_common
from calib.poses.imu_log import FloatArray

ITERATIONS = 60
STEP_SD = 1e-7
"""Converged once no parameter moves by more than this part of its own sd; Gauss-Newton then is
closer to the minimum by another factor of the relative residual, below 1e-9 in every parameter."""
HALVINGS = 12
ROBUST_ROUNDS = 30


def minimise(
    equations: Equations,
    theta: FloatArray,
    shapes: Mapping[str, float],
    basis: FloatArray,
    robust: bool,
    used: FloatArray | None = None,
) -> Solution:
    """The minimum at given shape parameters; reweighted until steady with the robust loss.

    ``used`` (r,) is 0 for rows that take no part, else 1.
    """
    eta = np.zeros(equations.common.shape[1])
    used = np.ones(equations.data_count + len(eta)) if used is None else used
    solution = iterate(equations, theta, eta, shapes, used, basis)
    iterations = solution.iterations
    if robust:
        for _ in range(ROBUST_ROUNDS):
            new = huber_weight(solution.rows.residual)
            new[equations.data_count :] = 1.0
            new *= used
            change = float(np.abs(new - solution.weight).max())
            solution = iterate(equations, solution.theta, solution.eta, shapes, new, basis)
            iterations += solution.iterations
            if change < 1e-6:
                break
    return Solution(solution.theta, solution.eta, solution.rows, solution.weight, iterations)


def iterate(
    equations: Equations,
    theta: FloatArray,
    eta: FloatArray,
    shapes: Mapping[str, float],
    weight: FloatArray,
    basis: FloatArray,
) -> Solution:
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
            return Solution(theta, eta, rows, weight, iteration)
    if np.isfinite(cost) and float(np.abs(rows.jacobian @ step).max()) < 1e-3:
        return Solution(theta, eta, rows, weight, iteration)
    require_determined(equations, rows, parameters)
    raise FitFailed(
        f"the fit of the {equations.poses.triad} did not converge in {ITERATIONS} steps. The "
        f"data-sheet values may be far off (full scale, bits, encoding), or poses may be spoilt: "
        f"look at the readings of each pose, and check the {equations.poses.triad}'s data sheet.",
        Remedy("data_sheet", equations.poses.triad),
    )


def step_of(rows: WhitenedRows, weight: FloatArray, basis: FloatArray) -> FloatArray:
    """Gauss-Newton step for theta and eta along ``basis``, column-scaled, by QR."""
    root = np.sqrt(weight)
    unit, scale = unit_columns((rows.jacobian @ basis) * root[:, None])
    q, r = np.linalg.qr(unit)
    diagonal = np.abs(np.diag(r))
    if diagonal.min() < 1e-12 * diagonal.max():
        # Singular here; require_determined says so in words once the iteration has ended.
        step = np.linalg.lstsq(unit, -rows.residual * root, rcond=1e-10)[0]
    else:
        step = np.linalg.solve(r, -(q.T @ (rows.residual * root)))
    return np.asarray(basis @ (step / scale))


def huber_weight(residual: FloatArray) -> FloatArray:
    """Weights of Huber's loss: rows beyond ``HUBER_SD`` count in proportion to 1/|residual|."""
    return np.asarray(np.minimum(1.0, HUBER_SD / np.maximum(np.abs(residual), 1e-300)))
