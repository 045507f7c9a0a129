"""Many searches at once: in every round all of them ask, and what is alike is answered together.

A round takes the next request of every search that is not at its end. Requests of one kind and one
shape are one stack; those that are like no other form stacks of one. The searches do not know of
each other.
"""

from collections.abc import Sequence

from calib.diagnosis.search.beside import BesideSets
from calib.diagnosis.search.set_densities import SetDensities
from calib.diagnosis.search.stacked_tables import TableAt
from calib.diagnosis.search.steps import Request, Result, Steps, answers
from calib.fit.batch.extend_many import Extension

AT_ONCE = 50
"""Requests in one stack, which then stays in a processor's cache. Tuned on ``python -m
tests.bench.bench_find``."""


def together(searches: Sequence[Steps[Result]]) -> list[Result]:
    """The results of many computations, in their order."""
    results: dict[int, Result] = {}
    replies: dict[int, object] = dict.fromkeys(range(len(searches)))
    while replies:
        requests: dict[int, Request] = {}
        for i, reply in replies.items():
            try:
                requests[i] = searches[i].send(reply)
            except StopIteration as end:
                results[i] = end.value
        replies = _replies(requests)
    return [results[i] for i in range(len(searches))]


def _replies(requests: dict[int, Request]) -> dict[int, object]:
    """The answers to requests, each under the number of its search."""
    alike: dict[object, list[int]] = {}
    for i, request in requests.items():
        alike.setdefault(_stack_of(request), []).append(i)
    replies: dict[int, object] = {}
    for which in alike.values():
        for first in range(0, len(which), AT_ONCE):
            some = which[first : first + AT_ONCE]
            replies.update(zip(some, answers([requests[i] for i in some]), strict=True))
    return replies


def _stack_of(request: Request) -> object:
    """What requests share that can be answered as one stack."""
    if isinstance(request, TableAt):
        return (TableAt, request.shape)
    if isinstance(request, BesideSets):
        return (BesideSets, len(request.table.residual))
    if isinstance(request, Extension):
        return (Extension, request.shape)
    return SetDensities
