"""Solver ``paper``: the iteration of Angrisano et al., equations (4) to (12).

The unknowns are X = (alpha, b, k) of eq. (3), the start is the data sheet's, eq. (12). Each step
solves eq. (11), ``H dX = l`` with rows ``NᵀA`` and ``½(NᵀN - s²)`` of eq. (10). Two faults of the
printed text are corrected (data/published/errata.md has the evidence):

- the entry of b_x in eq. (6) is +k_x; with the printed -k_x the iteration diverges;
- the stop rule ``(q_{i-1} - q_i)/q_i <= 0.0005`` needs the absolute value, and q must be the
  misclosure itself: the residual of the linear system is at the noise level from the first step.

Equation (11) is weighted with the variance of its right side, ``sd² |N| (|N| + s)/2``. With it the
iteration ends beside the minimum of ``Σ((|N| - s)/sd)²``, where q is flat; from there the other
solver's steps go to that minimum, with the errors that the references have in common.
"""

from dataclasses import dataclass, replace

import numpy as np

from calib.effects.catalogue import BASE
from calib.errors import CalibrationError, FitFailed, Remedy
from calib.fit.least_squares.gauss_newton import minimise
from calib.fit.least_squares.result import Fit
from calib.fit.least_squares.stack_fits import (
    at_ellipsoids,
    fits_of_stack,
    only_fit,
    require_determinable,
)
from calib.fit.linear import unit_columns
from calib.fit.model import Model
from calib.fit.parameters import TriadParameters, theta_of
from calib.fit.rows.residuals import Equations
from calib.poses.data_sheet import TriadSpec
from calib.poses.imu_log import FloatArray
from calib.poses.pose_set import PoseSet

STOP_RULE = 0.0005  #: relative change of q; Angrisano et al.; fact
ITERATIONS = 50  #: numerical limit
NOISE_FREE = 1e-24
"""Misclosure per row below which it is rounding, and the stop rule would divide by it."""


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
    """H, l and P of eq. (11) at one X; for a pose at rest eq. (4) itself, where s is known."""

    design: FloatArray
    misclosure: FloatArray
    root_weight: FloatArray

    @classmethod
    def at(cls, x: FloatArray, equations: Equations, counts: FloatArray) -> "_System":
        """The system at ``x``, in SI units."""
        n, a = corrected_vectors(x, counts), jacobian(x, counts)
        turning, null, poses = equations.magnitude, equations.null, equations.poses
        s, size = poses.reference.magnitude[turning], np.linalg.norm(n[turning], axis=1)
        rows = np.einsum("ni,nij->nj", n[turning], a[turning])  # NᵀA of eq. (10)
        sd2 = equations.magnitude_sd**2 * size * (size + s) / 2
        return cls(
            np.concatenate([rows, a[null].reshape(-1, 9)]),
            np.concatenate([(size**2 - s**2) / 2, (n[null] - poses.expected[null]).ravel()]),
            1 / np.sqrt(np.concatenate([sd2, (equations.whitening.null_sd**2).ravel()])))

    @property
    def q(self) -> float:
        """The weighted misclosure ``lᵀPl``."""
        return float(((self.misclosure * self.root_weight) ** 2).sum())

    def step(self) -> FloatArray:
        """dX of eq. (11)."""
        unit, scale = unit_columns(self.design * self.root_weight[:, None])
        right = self.misclosure * self.root_weight
        return np.asarray(np.linalg.lstsq(unit, right, rcond=None)[0] / scale)


@np.errstate(over="ignore", invalid="ignore")  # an iteration that diverges ends by its q
def iterations_from(
    x: FloatArray, equations: Equations, counts: FloatArray
) -> tuple[list[PaperStep], bool]:
    """The iterations from ``x`` until the stop rule holds or ``ITERATIONS`` are done.

    Returns
    -------
    steps : list of PaperStep
        X and q after each iteration.
    stopped : bool
        Whether the stop rule was met.
    """
    system = _System.at(x, equations, counts)
    steps: list[PaperStep] = []
    for _ in range(ITERATIONS):
        before, x = system.q, x + system.step()
        if not np.isfinite(x).all():
            break
        system = _System.at(x, equations, counts)
        steps.append(PaperStep(x, system.q))
        if not np.isfinite(system.q):
            break
        limit = NOISE_FREE * equations.data_count
        if abs(before - system.q) <= STOP_RULE * system.q or system.q <= limit:
            return steps, True
    return steps, False


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
    require_determinable(poses, model)
    stack = Equations.of_sets((poses,), model)
    counts = poses.reading / spec.nominal_scale + spec.nominal_bias_counts
    steps, stopped = iterations_from(data_sheet_start(spec), stack.take(0), counts)
    if not stopped:
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
    fits = fits_of_stack(stack, at_ellipsoids(stack, theta[None]), None, minimise)
    return replace(only_fit(fits), iterations=len(steps))
