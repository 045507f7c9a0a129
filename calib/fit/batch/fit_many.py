"""Fit one model to many pose sets: :func:`calib.fit.least_squares.solver.fit` for all at once.

Sets with equal numbers of rows are stacked; those of other numbers form stacks of their own. What
the stack does not bring to rest, or might be refused, is fitted by ``fit`` by itself, and put back.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np
from scipy.special import fdtrc

from calib.errors import CalibrationError
from calib.fit.batch.descent import descend
from calib.fit.batch.linear_algebra import inverses, scaled_information
from calib.fit.batch.pose_stack import PoseStack, grouped
from calib.fit.batch.stacked_rows import StackedEquations, StackedRows, columns_on
from calib.fit.batch.start import starts_of
from calib.fit.least_squares.identifiability import (
    CONDITION_LIMIT,
    FEWEST_SPARE_ROWS,
    GAINS,
    LARGEST_REFERENCE_ERROR,
)
from calib.fit.least_squares.result import Fit
from calib.fit.least_squares.solver import fit
from calib.fit.model import Model
from calib.fit.rows.initial_estimate import Start
from calib.fit.rows.residuals import Equations
from calib.fit.rows.whitened_rows import WhitenedRows
from calib.fit.rows.whitening import Whitening
from calib.poses.imu_log import BoolArray, FloatArray, IntArray
from calib.poses.pose_set import PoseSet

SETS_AT_ONCE = 500
"""Sets in one stack, which then stays in a processor's cache. Tuned on ``python -m
tests.bench.bench_batch``: 0.41 s for 10,000 sets, 0.46 s at half, 0.47 s at double.
A limit of memory."""


@dataclass(frozen=True, eq=False)
class FittedStack:
    """The fits of S sets of one shape.

    Parameters
    ----------
    index : array of int, shape (S,)
        Which of all sets they are.
    equations : StackedEquations
    rows : StackedRows
        At the solution.
    theta, eta : array, shapes (S, p) and (S, q)
        Parameters, SI, and common errors in their sds.
    cov : array, shape (S, p + q, p + q)
        Covariance of both from the stated sds.
    iterations : array of int, shape (S,)
    """

    index: IntArray
    equations: StackedEquations
    rows: StackedRows
    theta: FloatArray
    eta: FloatArray
    cov: FloatArray
    iterations: IntArray

    def __len__(self) -> int:
        return len(self.index)

    @property
    def dof(self) -> int:
        """Data rows less parameters."""
        return self.equations.stack.data_count - int(self.theta.shape[1])

    @property
    def common_shift(self) -> FloatArray:
        """How far one sd of each common error of the references moves theta, SI, (S, p, q)."""
        p = self.theta.shape[1]
        return np.asarray(self.cov[:, :p, p:])

    def one(self, k: int, poses: PoseSet, model: Model) -> Fit:
        """Fit number ``k`` of the stack, of ``poses``, by itself."""
        stacked, p = self.equations, model.size
        start = Start(stacked.start_matrix[k], stacked.start_offset[k])
        equations = Equations(poses, model, whitening=Whitening.of(poses, start))
        vector = np.empty_like(poses.reading)
        vector[stacked.stack.order[k]] = self.rows.vector[k]
        rows = WhitenedRows(self.rows.residual[k], self.rows.jacobian[k], vector, None,
                            partial(equations.axes, self.theta[k]))
        return Fit(
            poses=poses, model=model, theta=self.theta[k], cov=self.cov[k, :p, :p],
            common_shift=self.cov[k, :p, p:], eta=self.eta[k], shapes={}, log_shape_sd={},
            equations=equations, rows=rows, weight=np.ones(len(rows.residual)), basis=np.eye(p),
            iterations=int(self.iterations[k]),
        )


@dataclass(frozen=True, eq=False)
class ManyFits:
    """The fits of N pose sets; NaN, and 0 degrees of freedom, where one was refused.

    Parameters
    ----------
    model : Model
        Of p parameters.
    theta, sd : array, shape (N, p)
        Parameters and their sds, SI.
    chi2, p_value : array, shape (N,)
    dof, iterations : array of int, shape (N,)
    refusals : mapping of int to CalibrationError
        Why a set was refused, by its index: what
        :func:`calib.fit.least_squares.solver.fit` raises for it.
    alone : tuple of int
        The sets that were fitted by themselves.
    stacks : tuple of FittedStack
        The fits with their rows and covariances.
    """

    model: Model
    theta: FloatArray
    sd: FloatArray
    chi2: FloatArray
    p_value: FloatArray
    dof: IntArray
    iterations: IntArray
    refusals: Mapping[int, CalibrationError]
    alone: tuple[int, ...]
    stacks: tuple[FittedStack, ...]

    def __len__(self) -> int:
        return len(self.theta)

    def each(self, sets: Sequence[PoseSet]) -> list[Fit | None]:
        """The fits by themselves, as :func:`calib.fit.least_squares.solver.fit` returns them.

        Parameters
        ----------
        sets : sequence of PoseSet
            Those that were fitted.

        Returns
        -------
        list of Fit or None
            None where one was refused.
        """
        fits: list[Fit | None] = [None] * len(self)
        for stack in self.stacks:
            for k, i in enumerate(map(int, stack.index)):
                fits[i] = stack.one(k, sets[i], self.model)
        return fits


def fit_many(sets: Sequence[PoseSet], model: Model) -> ManyFits:
    """Fit ``model`` to each of ``sets``.

    Parameters
    ----------
    sets : sequence of PoseSet
        N sets, of any numbers of poses.
    model : Model
        Effects on the reading alone: bias, scale, misalignment.

    Returns
    -------
    ManyFits
        Estimates, sds, iterations and refusals are those of
        :func:`calib.fit.least_squares.solver.fit`, the numbers within 1e-9 of an sd.

    Raises
    ------
    ValueError
        The model has an effect that acts on the sensor or on the reference.
    """
    if len(model.acting_on("reading")) < len(model.effects):
        raise ValueError(f"fit_many has effects on the reading alone, not {model.names}")
    stacks, alone = [], []
    refusals: dict[int, CalibrationError] = {}
    for index in grouped(sets, SETS_AT_ONCE):
        stack, by_itself, refused = _fit_stack(sets, index, model)
        stacks.append(stack)
        alone += by_itself
        refusals |= refused
    return _collected(sets, model, stacks, sorted(alone), dict(sorted(refusals.items())))


@np.errstate(invalid="ignore", divide="ignore", over="ignore")  # such a set leaves the stack
def _fit_stack(
    sets: Sequence[PoseSet], index: IntArray, model: Model
) -> tuple[FittedStack, list[int], dict[int, CalibrationError]]:
    """The stack of the sets ``index``; which were fitted by themselves, which refused."""
    stack = PoseStack.of([sets[i] for i in index])
    start = starts_of(stack)
    equations = StackedEquations.of(stack, model, start)
    at = descend(equations, start.theta(model))
    rows = equations.rows(at.theta, at.eta)
    sound = at.converged & _is_sound(equations, rows, model)
    kept = np.arange(len(index))
    refusals: dict[int, CalibrationError] = {}
    if not sound.all():
        for j in np.flatnonzero(~sound):
            try:
                each = fit(sets[index[j]], model)
            except CalibrationError as error:
                refusals[int(index[j])] = error
            else:
                at.theta[j], at.eta[j], at.iterations[j] = each.theta, each.eta, each.iterations
                start.matrix[j] = each.equations.start.matrix
                start.offset[j] = each.equations.start.offset
        kept = np.array([j for j in kept if int(index[j]) not in refusals], dtype=int)
        equations = StackedEquations.of(stack, model, start).take(kept)
        rows = equations.rows(at.theta[kept], at.eta[kept])
    information, norm = scaled_information(rows.jacobian)
    cov = inverses(information) / (norm[:, :, None] * norm[:, None, :])
    fitted = FittedStack(index[kept], equations, rows, at.theta[kept], at.eta[kept], cov,
                         at.iterations[kept])
    return fitted, [int(i) for i in index[~sound]], refusals


def _is_sound(equations: StackedEquations, rows: StackedRows, model: Model) -> BoolArray:
    """Which sets (S,) pass every check of a fit beyond doubt."""
    stack = equations.stack
    if not stack.turning and set(model.names) & {*GAINS}:
        return np.zeros(len(stack), dtype=bool)
    if stack.data_count - model.size < FEWEST_SPARE_ROWS:
        return np.zeros(len(stack), dtype=bool)
    data = equations.whitened(columns_on(model, rows.vector), rows.vector)
    inverse = inverses(scaled_information(data)[0])
    # Of unit columns: the largest singular value is at most √p, the smallest at least the other.
    condition = np.sqrt(model.size * np.trace(inverse, axis1=1, axis2=2))
    size = np.linalg.norm(rows.vector[:, : stack.turning], axis=2)
    share = np.median(size / stack.magnitude, axis=1) if stack.turning else np.ones(len(stack))
    near = (share > 1 / LARGEST_REFERENCE_ERROR) & (share < LARGEST_REFERENCE_ERROR)
    return np.asarray((condition < CONDITION_LIMIT) & near & np.isfinite(rows.cost))


def _collected(
    sets: Sequence[PoseSet], model: Model, stacks: Sequence[FittedStack], alone: Sequence[int],
    refusals: Mapping[int, CalibrationError],
) -> ManyFits:
    n, p = len(sets), model.size
    theta, sd = np.full((n, p), np.nan), np.full((n, p), np.nan)
    chi2 = np.full(n, np.nan)
    dof, iterations = np.zeros(n, dtype=int), np.zeros(n, dtype=int)
    for each in stacks:
        theta[each.index] = each.theta
        sd[each.index] = np.sqrt(np.einsum("spp->sp", each.cov)[:, :p])
        chi2[each.index], dof[each.index] = each.rows.cost, each.dof
        iterations[each.index] = each.iterations
    noise_dof = np.array([poses.noise_dof for poses in sets])
    fitted = dof > 0
    p_value = np.full(n, np.nan)
    p_value[fitted] = fdtrc(dof[fitted], noise_dof[fitted], chi2[fitted] / dof[fitted])
    return ManyFits(model, theta, sd, chi2, p_value, dof, iterations, refusals, tuple(alone),
                    tuple(stacks))
