"""The fits of one stack of sets: some are refused on the way, the others go on."""

from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from typing import Any

import numpy as np

from calib.errors import FitFailed, Remedy
from calib.fit.least_squares.fitted_sets import FittedSets, finish
from calib.fit.least_squares.identifiability import Refusals, too_few, undetermined_sets
from calib.fit.least_squares.result import Fit
from calib.fit.least_squares.visible_basis import visible_bases
from calib.fit.rows.problem import EXACT, Estimate, Problem, Solution
from calib.fit.rows.residuals import Equations
from calib.fit.rows.sensitive_axes import too_large_effects
from calib.fit.stacked import taken
from calib.poses.imu_log import FloatArray, IntArray


@dataclass(frozen=True, eq=False)
class Fits:
    """The fits of one stack out of many sets.

    Parameters
    ----------
    index : array of int, shape (S,)
        Which of all sets they are.
    fitted : FittedSets or None
        Their fits; None where all are refused.
    refusals : dict of int to CalibrationError
        Why other sets of the stack have none: what :func:`fit` raises for them.
    """

    index: IntArray
    fitted: FittedSets | None
    refusals: Refusals


class _NoneLeft(Exception):
    """All sets of a stack are refused."""


class _Stack:
    """Which sets of a stack go on (``index``), and why others have left it."""

    def __init__(self, sets: int) -> None:
        self.index: IntArray = np.arange(sets)
        self.refusals: Refusals = {}

    def without(self, refused: Refusals, *parts: Any) -> Any:
        """Records and arrays of the sets that go on, of ``parts`` of all, without ``refused``."""
        if refused:
            self.refusals |= {int(self.index[k]): error for k, error in refused.items()}
            on = np.array([k for k in range(len(self.index)) if k not in refused], dtype=int)
            self.index, parts = self.index[on], tuple(taken(part, on) for part in parts)
            if not on.size:
                raise _NoneLeft
        return parts


def fits_of_stack(
    equations: Equations, at: Estimate, weight: FloatArray | None,
    minimum: Callable[[Problem, Estimate], Solution], robust: bool = False, exact: bool = False,
) -> Fits:
    """The fits of a stack that start ``at``, by what finds their ``minimum``.

    ``weight`` (S, r) is of the rows; where the fits are ``exact``, they must have come to rest.
    """
    stack, fitted = _Stack(len(at.theta)), None
    with suppress(_NoneLeft):
        wild: Refusals = {int(k): too_large_effects() for k in np.flatnonzero(~at.rows.is_solved)}
        equations, at, weight = stack.without(wild, equations, at, weight)
        basis, blind = visible_bases(equations, at.rows, at.shapes)
        problem, at = stack.without(blind, Problem.of(equations, basis, robust, weight), at)
        few = too_few(problem.equations, problem.moves + len(problem.free))
        problem, at = stack.without(few, problem, at)
        solution = minimum(problem, at)
        if exact:
            problem, solution = stack.without(_restless(problem, solution), problem, solution)
        fitted, refused = finish(problem, solution)
        (fitted,) = stack.without(refused, fitted)
    return Fits(stack.index, fitted if stack.index.size else None, stack.refusals)


def _restless(problem: Problem, solution: Solution) -> Refusals:
    """The sets whose iteration did not come to rest."""
    triad = problem.equations.poses.triad
    restless = np.flatnonzero(~solution.is_converged)
    if not restless.size:
        return {}
    part = problem.take(restless)
    why = undetermined_sets(part.equations, solution.at.take(restless), part.basis)
    failed = FitFailed(
        f"the fit of the {triad} did not converge in {EXACT.steps} steps. The "
        f"data-sheet values may be far off (full scale, bits, encoding), or poses may be spoilt: "
        f"look at the readings of each pose, and check the {triad}'s data sheet.",
        Remedy("data_sheet", triad),
    )
    return {int(k): why.get(i, failed) for i, k in enumerate(restless)}


def only_fit(fits: Fits) -> Fit:
    """The fit of a stack of one; raises why it is refused."""
    if fits.fitted is None:
        raise fits.refusals[0]
    return fits.fitted.one(0)
