"""How long one diagnosis takes: 126 rows, every listed effect; and with SciPy as the minimiser.

    OPENBLAS_NUM_THREADS=1 python -m tests.bench.bench_diagnose

Medians of CPU time for sessions with no hidden effect, one, two and three, beside one fit of the
same rows: a diagnosis is a search through refits, and its time over that of a fit is what it costs.
In the same run, alternating, every minimum of the search is found by
``scipy.optimize.least_squares`` on the same rows with the same exact Jacobian, from the same starts
and as far. Printed are the time of a diagnosis with it, the time of all refits of one diagnosis by
either, by how much the stated probabilities differ, and by how much the refits' chi-square.
"""

from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from functools import partial
from unittest import mock

import numpy as np
from scipy.optimize import least_squares

from calib.diagnosis.diagnose import Diagnosis, diagnose
from calib.effects.catalogue import BASE
from calib.effects.effect import EFFECTS
from calib.fit.least_squares.gauss_newton import minimise
from calib.fit.least_squares.solver import Fit, fit
from calib.fit.model import Model
from calib.fit.rows.problem import EXACT, Estimate, Precision, Problem, Solution
from calib.poses.imu_log import FloatArray
from tests.bench.timing import paired_ms
from tests.trials import DESIGNS, drawn, poses_of

Task = tuple[Problem, Estimate, Precision]
Minimiser = Callable[..., Solution]

HIDDEN = (
    (),
    ("quadratic",),
    ("g_sensitivity",),
    ("warm_up",),
    ("quadratic", "bias_drift"),
    ("g_sensitivity", "cubic", "temperature_bias"),
)
SIZE = 5.0
SEED = 2


PLACES = tuple(f"calib.fit.least_squares.{room}.minimise" for room in ("solver", "stack_fits"))
"""Where a diagnosis takes its minimiser from."""


class Rows:
    """Weighted rows of one set and their Jacobian along the unknowns, as SciPy asks for them."""

    def __init__(self, problem: Problem, start: Estimate) -> None:
        self.problem, self.start, self.root = problem, start, np.sqrt(problem.weight[0])
        self.x = np.zeros(problem.directions.shape[2] + len(problem.free))
        self.at = start

    def move(self, x: FloatArray) -> Estimate:
        """The estimate at ``x``, computed once for residual and Jacobian."""
        if not np.array_equal(x, self.x):
            self.x, problem = x.copy(), self.problem
            v, p = problem.directions.shape[2], self.start.theta.shape[1]
            step = problem.directions[0] @ x[:v]
            shapes = dict(self.start.shapes)
            for name, change in zip(problem.free, x[v:], strict=True):
                shapes[name] = shapes[name] * np.exp(change)
            theta, eta = self.start.theta + step[:p], self.start.eta + step[p:]
            self.at = Estimate.of(problem.equations, theta, eta, shapes)
        return self.at

    def residual(self, x: FloatArray) -> FloatArray:
        return np.asarray(self.move(x).rows.residual[0] * self.root)

    def jacobian(self, x: FloatArray) -> FloatArray:
        at = self.move(x)
        linear = at.rows.jacobian[0] @ self.problem.directions[0]
        if self.problem.free:
            by_shape = at.shape_derivatives(self.problem.equations, self.problem.free)
            linear = np.hstack([linear, by_shape.slope[0]])
        return np.asarray(linear * self.root[:, None])


def by_scipy(problem: Problem, start: Estimate, precision: Precision = EXACT) -> Solution:
    """What :func:`calib.fit.least_squares.gauss_newton.minimise` does, by SciPy, set by set."""
    sets = len(start.theta)
    solution = Solution(start, problem.weight, np.zeros(sets, int), np.full(sets, np.inf))
    for i in range(sets):
        one = np.array([i])
        solution = solution.with_sets(one, _one_by_scipy(
            problem.take(one), start.take(one), precision))
    return solution


def _one_by_scipy(problem: Problem, start: Estimate, precision: Precision) -> Solution:
    rows = Rows(problem, start)
    low = np.full(len(rows.x), -np.inf)
    high = -low
    for j, (name, shape) in enumerate(problem.free.items(), problem.directions.shape[2]):
        low[j], high[j] = np.log(np.array(shape.bounds) / start.shapes[name][0])
    reached = least_squares(
        rows.residual, rows.x.copy(), rows.jacobian, bounds=(low - 1e-9, high + 1e-9),
        method="trf" if problem.free else "lm", x_scale="jac",
        ftol=precision.step_sd**2, xtol=1e-12, gtol=1e-12,
    )
    return Solution(rows.move(reached.x), problem.weight, np.array([reached.nfev]), np.zeros(1))


@contextmanager
def minimiser(replaced_by: Minimiser) -> Iterator[None]:
    """The same search with another minimiser."""
    with ExitStack() as stack:
        for place in PLACES:
            stack.enter_context(mock.patch(place, replaced_by))
        yield


def diagnose_by_scipy(base: Fit) -> Diagnosis:
    """The same diagnosis with SciPy's minima."""
    with minimiser(by_scipy):
        return diagnose(base)


def minimised(base: Fit) -> list[Task]:
    """Every problem that one diagnosis minimises, with where it starts and how far it goes."""
    tasks: list[Task] = []

    def noting(problem: Problem, start: Estimate, precision: Precision = EXACT) -> Solution:
        tasks.append((problem, start, precision))
        return minimise(problem, start, precision)

    with minimiser(noting):
        diagnose(base)
    return tasks


def all_of(by: Minimiser, tasks: Sequence[Task]) -> FloatArray:
    """Cost of every minimum of every task."""
    return np.concatenate([np.zeros(0), *(by(*task).cost for task in tasks)])


def apart(one: Diagnosis, other: Diagnosis) -> float:
    """Largest difference of a stated probability."""
    a, b = ({i.name: i.probability for i in each.inclusion} for each in (one, other))
    return max((abs(a.get(name, 0.0) - b.get(name, 0.0)) for name in {*a, *b}), default=0.0)


def main() -> None:
    """Print the table."""
    listed = sum("gyroscope" in effect.triads for effect in EFFECTS.values())
    print(f"{listed} listed effects; median ms of one fit, of a whole diagnosis, ratio; by SciPy")
    for name in ("rich", "paper"):
        design = DESIGNS[name]()
        for names in HIDDEN:
            effects = [drawn(n, "gyroscope", SIZE, design, SEED) for n in names]
            poses = poses_of(design, SEED, "gyroscope", [e for e in effects if e is not None])
            base = fit(poses, Model.of(BASE))
            tasks = minimised(base)
            one, whole, scipys, minima, scipy_minima = paired_ms(
                (partial(fit, poses, Model.of(BASE)), partial(diagnose, base),
                 partial(diagnose_by_scipy, base), partial(all_of, minimise, tasks),
                 partial(all_of, by_scipy, tasks)), 15,
            )
            said, also = diagnose(base), diagnose_by_scipy(base)
            more = all_of(by_scipy, tasks) - all_of(minimise, tasks)
            hidden = " + ".join(names) or "nothing"
            print(
                f"{name:6s} {base.equations.data_count:4d} rows, hidden {hidden:42s}: {one:5.1f} "
                f"{whole:6.1f} {whole / one:5.0f} x  {said.verdict} {'/'.join(said.group)}; by "
                f"SciPy {scipys:6.1f}  {also.verdict} {'/'.join(also.group)}, probabilities apart "
                f"by {apart(said, also):.0e}; {len(more)} minima {minima:.1f}, by SciPy "
                f"{scipy_minima:.1f}, whose chi-square is {more.min(initial=0.0):+.0e} to "
                f"{more.max(initial=0.0):+.0e} higher",
                flush=True,
            )


if __name__ == "__main__":
    main()
