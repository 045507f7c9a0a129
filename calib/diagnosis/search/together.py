"""Many searches at once: what they ask that is alike is answered together.

Every search has one request open. Requests of one kind and one shape are a stack; the largest stack
is answered first, so that rare ones grow meanwhile, and the searches that it belonged to go on to
their next request. They do not know of each other.
"""

from collections.abc import Sequence

from calib.diagnosis.search.beside import BesideSets
from calib.diagnosis.search.set_densities import SetDensities
from calib.diagnosis.search.stacked_tables import TableAt
from calib.diagnosis.search.steps import Request, Result, Steps, answers
from calib.fit.batch.extend_many import Extension

AT_ONCE = 50
"""Requests in one stack: a limit of memory, half and double not measured."""


def together(searches: Sequence[Steps[Result]]) -> list[Result]:
    """The results of many computations, in their order."""
    results: dict[int, Result] = {}
    stacks: dict[object, dict[int, Request]] = {}

    def go_on(i: int, reply: object) -> None:
        try:
            request = searches[i].send(reply)
        except StopIteration as end:
            results[i] = end.value
        else:
            stacks.setdefault(_stack_of(request), {})[i] = request

    for i in range(len(searches)):
        go_on(i, None)
    while stacks:
        stack = stacks.pop(max(stacks, key=lambda shape: len(stacks[shape])))
        which = list(stack)
        for first in range(0, len(which), AT_ONCE):
            some = which[first : first + AT_ONCE]
            replies = answers([stack[i] for i in some])
            for i, reply in zip(some, replies, strict=True):
                go_on(i, reply)
    return [results[i] for i in range(len(searches))]


def _stack_of(request: Request) -> object:
    """What requests share that can be answered as one stack."""
    if isinstance(request, TableAt):
        return (TableAt, request.shape)
    if isinstance(request, BesideSets):
        return (BesideSets, len(request.table.residual))
    if isinstance(request, Extension):
        return (Extension, request.shape)
    return SetDensities
