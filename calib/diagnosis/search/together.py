"""Many searches at once: what they ask that is alike is answered together.

Every search has one request open. Requests of one kind and one shape are a stack; the largest stack
is answered first, so that rare ones grow meanwhile, and the searches that it belonged to go on to
their next request. They do not know of each other. Where one ends the next begins, so that as many
are open all the time as memory holds, and stacks stay large.
"""

from collections.abc import Iterable, Iterator
from itertools import islice

from calib.diagnosis.search.beside import BesideSets
from calib.diagnosis.search.set_densities import SetDensities
from calib.diagnosis.search.stacked_tables import TableAt
from calib.diagnosis.search.steps import Request, Result, Steps, answers
from calib.fit.batch.extend_many import Extension

AT_ONCE = 200
"""Requests in one stack: a limit of memory. Half and twice of it change no finding
(``tests.calib.diagnosis.test_finding``) and the time of 96 findings by less than it scatters."""

OPEN = 6000
"""Searches that are open at once: a limit of memory, 0.13 MB each, 0.8 GB in all."""


def in_turn(searches: Iterable[Steps[Result]]) -> Iterator[tuple[int, Result]]:
    """The number and the result of each computation as it ends; none is kept."""
    waiting = enumerate(searches)
    running: dict[int, Steps[Result]] = {}
    stacks: dict[object, dict[int, Request]] = {}
    ended: list[tuple[int, Result]] = []

    def go_on(i: int, reply: object) -> None:
        try:
            request = running[i].send(reply)
        except StopIteration as end:
            del running[i]
            ended.append((i, end.value))
        else:
            stacks.setdefault(_stack_of(request), {})[i] = request

    while True:
        begun = dict(islice(waiting, OPEN - len(running)))
        running.update(begun)
        for i in begun:
            go_on(i, None)
        yield from ended
        ended.clear()
        if not stacks:
            if not begun:
                return
            continue  # all that began have ended without a request
        stack = stacks.pop(max(stacks, key=lambda shape: len(stacks[shape])))
        which = list(stack)
        for first in range(0, len(which), AT_ONCE):
            some = which[first : first + AT_ONCE]
            replies = answers([stack.pop(i) for i in some])
            for i, reply in zip(some, replies, strict=True):
                go_on(i, reply)


def _stack_of(request: Request) -> object:
    """What requests share that can be answered as one stack."""
    if isinstance(request, TableAt):
        return (TableAt, request.shape)
    if isinstance(request, BesideSets):
        return (BesideSets, len(request.table.residual))
    if isinstance(request, Extension):
        return (Extension, request.shape)
    return SetDensities
