"""Weighted least squares of the magnitude, null and prior rows: the fit of both triads.

Two ways to the same minimum, one contract. ``default`` starts from the ellipsoid and takes
Gauss-Newton steps with the exact Jacobian of the linear form; ``paper`` (:mod:`calib.paper`) walks
the equations of Angrisano et al. in (alpha, b, k). Both end in :func:`finish`, which judges
whether the poses determine the model at all.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from calib.equations import Equations, Rows
from calib.errors import FitFailed
from calib.identifiability import require_determined, require_enough, visible_basis
from calib.imu_log import FloatArray
from calib.model import Model
from calib.poses import PoseSet

ITERATIONS = 60
STEP_SD = 1e-7
"""Converged once no parameter moves by more than this part of its own sd; Gauss-Newton then is
closer to the minimum by another factor of the relative residual, below 1e-9 in every parameter."""

HALVINGS = 12
HUBER_SD = 1.5
ROBUST_ROUNDS = 30


@dataclass(frozen=True, eq=False)
class Fit:
    """A fitted model, with everything that comparison and diagnosis need.

    ``theta`` (p,), ``cov`` (p, p) from the stated sds, ``eta`` (q,) common errors of the
    references, ``shapes`` fitted shape parameters with their sd, ``rows`` at the solution,
    ``weight`` (r,) what the robust loss left of each row (1 without it), ``basis`` (p, v) the
    combinations of parameters that these poses see and that were fitted.
    """

    poses: PoseSet
    model: Model
    theta: FloatArray
    cov: FloatArray
    eta: FloatArray
    shapes: Mapping[str, float]
    shape_sd: Mapping[str, float]
    equations: Equations
    rows: Rows
    weight: FloatArray
    basis: FloatArray
    iterations: int

    @property
    def chi2(self) -> float:
        """Sum of the squared whitened residuals."""
        return self.rows.chi2

    @property
    def dof(self) -> int:
        """Data rows less parameters; the prior rows pay for the common errors."""
        return int(self.equations.data_count - self.basis.shape[1] - len(self.shapes))

    @property
    def residual_si(self) -> FloatArray:
        """Residual of every data row in SI units, (r - q,)."""
        return np.asarray(self.rows.residual[: self.equations.data_count] * self.equations.row_sd)

    @property
    def residual_rms(self) -> float:
        """Root mean square of the data rows' residuals, SI."""
        return float(np.sqrt(np.mean(self.residual_si**2)))


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


def fit_shapes_fixed(
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


def fit(poses: PoseSet, model: Model, *, robust: bool = False) -> Fit:
    """Fit ``model`` to ``poses`` from the ellipsoid start.

    Parameters
    ----------
    poses : PoseSet
        All runs of the triad.
    model : Model
        Effects to fit jointly.
    robust : bool
        Huber's loss instead of plain squares, so that a few bad poses pull less.

    Raises
    ------
    Undetermined
        The poses do not determine the model; the message says which directions are missing.
    FitFailed
        The iteration did not converge.
    """
    from calib.shapes import fit_with_shapes  # only models with a shape parameter need it

    equations = Equations(poses, model)
    if any(effect.shape for effect in model.effects):
        return fit_with_shapes(equations, robust)
    start = equations.start.theta(model)
    basis = basis_at(equations, start)
    require_enough(equations, basis.shape[1])
    theta, eta, rows, weight, iterations = fit_shapes_fixed(equations, start, {}, basis, robust)
    return finish(equations, theta, eta, rows, weight, basis, iterations)


def basis_at(equations: Equations, theta: FloatArray) -> FloatArray:
    """The combinations of parameters that the poses can see, judged at ``theta``, (p, v)."""
    if len(equations.reading_index) == equations.model.size:
        return np.eye(equations.model.size)
    at_start = equations.rows(theta, np.zeros(equations.common.shape[1]), {})
    return visible_basis(equations, at_start)


def finish(
    equations: Equations,
    theta: FloatArray,
    eta: FloatArray,
    rows: Rows,
    weight: FloatArray,
    basis: FloatArray,
    iterations: int,
    shapes: Mapping[str, float] | None = None,
) -> Fit:
    """Check that the solution is determined and finite, and give it its covariance."""
    require_enough(equations, basis.shape[1] + len(shapes or {}))
    require_determined(equations, rows, basis)
    p = equations.model.size
    full = with_common(basis, len(eta))
    jacobian = (rows.jacobian @ full) * np.sqrt(weight)[:, None]
    scale = np.sqrt((jacobian**2).sum(axis=0))
    scale[scale == 0] = 1.0
    r = np.linalg.qr(jacobian / scale, mode="r")
    inverse = np.linalg.inv(r) / scale[:, None]
    cov = (full @ (inverse @ inverse.T) @ full.T)[:p, :p]
    if not (np.isfinite(theta).all() and np.isfinite(cov).all()):
        raise FitFailed(
            f"the fit of the {equations.poses.triad} ended without finite parameters. Check the "
            f"log for poses that are not what they should be."
        )
    return Fit(
        poses=equations.poses,
        model=equations.model,
        theta=theta,
        cov=cov,
        eta=eta,
        shapes=dict(shapes or {}),
        shape_sd={},
        equations=equations,
        rows=rows,
        weight=weight,
        basis=basis,
        iterations=iterations,
    )


def with_shape_sd(found: Fit, cov: FloatArray, shape_sd: Mapping[str, float]) -> Fit:
    """``found`` with the covariance widened by its fitted shape parameters."""
    return replace(found, cov=cov, shape_sd=dict(shape_sd))
