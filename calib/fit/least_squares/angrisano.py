"""Solver ``paper``: the iteration of Angrisano et al., equations (4) to (12).

The unknowns are X = (alpha, b, k) of eq. (3), the start is the data sheet's, eq. (12). Each step
solves eq. (11), ``H dX = l`` with rows ``NᵀA`` and ``½(NᵀN - s²)`` of eq. (10). Two faults of the
printed text are corrected (data/published/errata.md has the evidence):

- the entry of b_x in eq. (6) is +k_x; with the printed -k_x the iteration diverges;
- the stop rule ``(q_{i-1} - q_i)/q_i <= 0.0005`` needs the absolute value, and q must be the
  misclosure itself: the residual of the linear system is at the noise level from the first step.

Equation (11) is weighted with the variance of its right side, ``sd² |N| (|N| + s)/2``. With it the
iteration ends in the very minimum of ``Σ((|N| - s)/sd)²`` that the other solver finds.
"""

from dataclasses import dataclass, replace

import numpy as np

from calib.effects.catalogue import BASE
from calib.errors import CalibrationError, FitFailed, Remedy
from calib.fit.column_scaling import unit_columns
from calib.fit.least_squares.fitted_sets import finish
from calib.fit.least_squares.gauss_newton import minimise
from calib.fit.least_squares.identifiability import too_few, undetermined_sets
from calib.fit.least_squares.result import Fit
from calib.fit.model import Model
from calib.fit.parameters import TriadParameters, theta_of
from calib.fit.rows.problem import Estimate, Problem
from calib.fit.rows.residuals import Equations
from calib.poses.data_sheet import TriadSpec
from calib.poses.imu_log import FloatArray
from calib.poses.pose_set import PoseSet

STOP_RULE = 0.0005  #: relative change of q; Angrisano et al.; fact
ITERATIONS = 50  #: numerical limit
NOISE_FREE = 1e-24
"""Below this, per row, the misclosure is rounding, and the rule would divide by it."""


@dataclass(frozen=True, eq=False)
class PaperStep:
    """One iteration: X (9,) after it and the misclosure q there."""

    x: FloatArray
    q: float


def data_sheet_start(spec: TriadSpec) -> FloatArray:
    """X_s of eq. (12), shape (9,): α (rad), b (counts) and k (SI units per count)."""
    return np.concatenate(
        [np.zeros(3), np.full(3, spec.nominal_bias_counts), np.full(3, spec.nominal_scale)]
    )


def corrected_vectors(x: FloatArray, counts: FloatArray) -> FloatArray:
    """N of eq. (5), SI, shape (n, 3)."""
    (ax, ay, az), b, k = x[:3], x[3:6], x[6:]
    w = k * (counts - b)
    return np.stack(
        [w[:, 0] + az * w[:, 1] + ay * w[:, 2], w[:, 1] + ax * w[:, 2], w[:, 2]], axis=1
    )


def jacobian(x: FloatArray, counts: FloatArray) -> FloatArray:
    """A of eq. (6), ``-dN/dX``, SI per rad, count, and SI per count, shape (n, 3, 9)."""
    (ax, ay, az), b, k = x[:3], x[3:6], x[6:]
    u = counts - b
    w = k * u
    a = np.zeros((len(counts), 3, 9))
    a[:, 1, 0] = -w[:, 2]
    a[:, 0, 1] = -w[:, 2]
    a[:, 0, 2] = -w[:, 1]
    a[:, 0, 3] = k[0]
    a[:, 0, 4], a[:, 1, 4] = az * k[1], k[1]
    a[:, 0, 5], a[:, 1, 5], a[:, 2, 5] = ay * k[2], ax * k[2], k[2]
    a[:, 0, 6] = -u[:, 0]
    a[:, 0, 7], a[:, 1, 7] = -az * u[:, 1], -u[:, 1]
    a[:, 0, 8], a[:, 1, 8], a[:, 2, 8] = -ay * u[:, 2], -ax * u[:, 2], -u[:, 2]
    return a


@dataclass(frozen=True, eq=False)
class _System:
    """H, l and P of eq. (11) at one X, common errors of the reference included."""

    design: FloatArray
    misclosure: FloatArray
    root_weight: FloatArray

    @property
    def q(self) -> float:
        """The weighted misclosure ``lᵀPl``."""
        return float(((self.misclosure * self.root_weight) ** 2).sum())

    def step(self) -> FloatArray:
        """dX of eq. (11), followed by the change of the common errors."""
        design = self.design * self.root_weight[:, None]
        unit, scale = unit_columns(design)
        right = self.misclosure * self.root_weight
        return np.asarray(np.linalg.lstsq(unit, right, rcond=None)[0] / scale)


def _system(
    equations: Equations, counts: FloatArray, x: FloatArray, eta: FloatArray
) -> _System:
    n = corrected_vectors(x, counts)
    a = jacobian(x, counts)
    turning, null = equations.magnitude, equations.null
    s = equations.poses.reference.magnitude[turning]
    shares = 1 - equations.row_common @ eta  # the common errors, on |N| itself
    size = np.linalg.norm(n[turning], axis=1)
    magnitude_rows = np.einsum("ni,nij->nj", n[turning], a[turning])  # NᵀA of eq. (10)
    design = np.zeros((equations.data_count + len(eta), 9 + len(eta)))
    rows, rest = len(turning), equations.data_count
    share, of_null = shares[:rows], shares[rows:]
    null_rows = (n[null] - equations.poses.expected[null]).ravel()
    design[:rows, :9] = magnitude_rows * share[:, None] ** 2
    design[:rows, 9:] = equations.common_relative * (share * size**2)[:, None]
    # eq. (4) itself, where s is known: at rest
    design[rows:rest, :9] = a[null].reshape(-1, 9) * of_null[:, None]
    design[rows:rest, 9:] = equations.row_common[rows:] * null_rows[:, None]
    design[rest:, 9:] = np.eye(len(eta))
    misclosure = np.concatenate(
        [
            ((share * size) ** 2 - s**2) / 2,
            null_rows * of_null,
            -eta,
        ]
    )
    variance = np.concatenate(
        [
            equations.magnitude_sd**2 * share * size * (share * size + s) / 2,
            (equations.null_sd**2).ravel(),
            np.ones(len(eta)),
        ]
    )
    return _System(design, misclosure, 1 / np.sqrt(variance))


@np.errstate(over="ignore", invalid="ignore")  # an iteration that diverges ends by its q
def iterations_from(
    start: FloatArray, equations: Equations, counts: FloatArray
) -> tuple[list[PaperStep], FloatArray, bool]:
    """The iterations from ``start`` until the stop rule holds or ``ITERATIONS`` are done.

    Returns
    -------
    steps : list of PaperStep
        X and q after each iteration.
    eta : array, shape (q,)
        Common errors of the references at the end.
    stopped : bool
        Whether the stop rule was met.
    """
    x, eta = start.copy(), np.zeros(equations.common_count)
    system = _system(equations, counts, x, eta)
    steps: list[PaperStep] = []
    q = system.q
    for _ in range(ITERATIONS):
        change = system.step()
        x, eta = x + change[:9], eta + change[9:]
        if not np.isfinite(x).all():
            break
        system = _system(equations, counts, x, eta)
        before, q = q, system.q
        steps.append(PaperStep(x, q))
        if not np.isfinite(q):
            break
        if abs(before - q) <= STOP_RULE * q or q <= NOISE_FREE * equations.data_count:
            return steps, eta, True
    return steps, eta, False


def fit_paper(poses: PoseSet, model: Model, spec: TriadSpec) -> Fit:
    """Fit bias, scale and misalignment as the paper does: Angrisano et al., eqs. (4) to (12).

    Parameters
    ----------
    poses : PoseSet
        All runs of the triad.
    model : Model
        Bias, scale and misalignment, in any order.
    spec : TriadSpec
        The data sheet; the iteration starts from its values.

    Raises
    ------
    CalibrationError
        The model has other effects than the paper's nine parameters.
    Undetermined, FitFailed
        As for :func:`calib.fit.least_squares.solver.fit`.
    """
    if set(model.names) != set(BASE):
        raise CalibrationError(
            f"solver 'paper' knows the nine parameters of the paper only, but the model is "
            f"[{', '.join(model.names)}]. Use the default solver with any other model.",
            Remedy("default_solver"),
        )
    stack = Equations.of_sets((poses,), model)
    equations, basis = stack.take(0), np.eye(model.size)[None]
    for error in too_few(stack, np.array([model.size])).values():
        raise error
    counts = poses.reading / spec.nominal_scale + spec.nominal_bias_counts
    steps, eta, stopped = iterations_from(data_sheet_start(spec), equations, counts)
    if not stopped:
        start = Estimate.of(stack, stack.start.theta(model), np.zeros_like(eta)[None], {})
        for error in undetermined_sets(stack, start, basis).values():
            raise error
        raise FitFailed(
            f"solver 'paper' did not converge for the {poses.triad} from the data-sheet values in "
            f"{ITERATIONS} iterations: they lie outside its convergence interval. Check the full "
            f"scale, or use the default solver, which needs no start.",
            Remedy("default_solver"),
        )
    x = steps[-1].x
    parameters = TriadParameters(x[:3], x[3:6], 1 / x[6:], np.full((9, 9), np.nan))
    linear = theta_of(parameters, spec)
    theta = np.empty(model.size)
    for i, name in enumerate(BASE):
        theta[model.slices()[name]] = linear[3 * i : 3 * i + 3]
    problem = Problem.of(stack, basis)
    # The stop rule looks at q, which is flat at the minimum: the last thousandths of an sd remain.
    ended = minimise(problem, Estimate.of(stack, theta[None], eta[None], {}))
    fitted, refusals = finish(problem, replace(ended, iterations=np.array([len(steps)])))
    for error in refusals.values():
        raise error
    return fitted.one(0)
