"""What a search asks for on its way, so that many searches can be answered together.

A search is a generator: where it comes to an expensive step it yields what it wants to know, and
goes on with the answer. :func:`alone` answers one search, request by request;
:func:`calib.diagnosis.search.together.in_turn` answers those of many at once, as stacked arrays.
Both give the same answers, since one request is a stack of one.
"""

from collections.abc import Generator, Sequence
from typing import Any, TypeVar

from calib.diagnosis.hypotheses.listed import Hypothesis
from calib.diagnosis.search.beside import Beside, BesideSets, besides
from calib.diagnosis.search.refit import Refit, refits
from calib.diagnosis.search.set_densities import SetDensities, set_densities
from calib.diagnosis.search.stacked_tables import TableAt, tables_at
from calib.diagnosis.search.table import Table
from calib.effects.effect import Effect
from calib.fit.batch.extend_many import Extension
from calib.fit.least_squares.result import Fit

Result = TypeVar("Result")


Request = TableAt | Extension | BesideSets | SetDensities
Steps = Generator[Request, Any, Result]
"""A computation that asks on its way and returns a result."""


def table_at(
    fit: Fit, hypotheses: Sequence[Hypothesis], members: Sequence[str] = ()
) -> Steps[Table]:
    """The table of ``hypotheses`` at ``fit``, whose effects ``members`` are on trial."""
    table: Table = yield TableAt(fit, hypotheses, members)
    return table


def densities(table: Table, sets: Sequence[Sequence[int]]) -> Steps[list[float]]:
    """Log density of the residual under each of ``sets``."""
    values: list[float] = yield SetDensities(table, sets)
    return values


def larger(table: Table, sets: Sequence[Sequence[int]]) -> Steps[list[Beside]]:
    """Every hypothesis beside each of ``sets``."""
    weighed: list[Beside] = yield BesideSets(table, sets)
    return weighed


def joint_refit(base: Fit, effects: Sequence[Effect]) -> Steps[Refit | None]:
    """``effects`` added to ``base``; None where the poses cannot carry them."""
    joint: Refit | None = yield Extension(base, tuple(effects))
    return joint


def answers(requests: Sequence[Request]) -> list[object]:
    """The answers to requests of one kind."""
    first = requests[0]
    if isinstance(first, TableAt):
        return [*tables_at([each for each in requests if isinstance(each, TableAt)])]
    if isinstance(first, BesideSets):
        return [*besides([each for each in requests if isinstance(each, BesideSets)])]
    if isinstance(first, SetDensities):
        return [*set_densities([each for each in requests if isinstance(each, SetDensities)])]
    return [*refits([each for each in requests if isinstance(each, Extension)])]


def alone(steps: Steps[Result]) -> Result:
    """The result of one computation."""
    try:
        request = next(steps)
        while True:
            request = steps.send(answers([request])[0])
    except StopIteration as end:
        result: Result = end.value
        return result
