"""Time that tasks take, for the benches."""

import time
from collections.abc import Callable, Sequence

import numpy as np


def median_ms(task: Callable[[], object], times: int) -> float:
    """Median wall time of ``task`` in milliseconds, after one run to warm up."""
    return paired_ms([task], times, time.perf_counter)[0]


def paired_ms(
    tasks: Sequence[Callable[[], object]],
    times: int,
    clock: Callable[[], float] = time.process_time,
) -> list[float]:
    """Median time of each task in milliseconds, alternating, after one run to warm up.

    The default clock counts what this process computes, so that other work on the machine does not
    count; on a quiet machine with one thread it is the wall time.
    """
    taken: list[list[float]] = [[] for _ in tasks]
    for task in tasks:
        task()
    for _ in range(times):
        for task, durations in zip(tasks, taken, strict=True):
            start = clock()
            task()
            durations.append(clock() - start)
    return [1e3 * float(np.median(durations)) for durations in taken]
