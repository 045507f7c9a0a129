"""Wall time of a task, for the benches."""

import time
from collections.abc import Callable

import numpy as np


def median_ms(task: Callable[[], object], times: int) -> float:
    """Median wall time of ``task`` in milliseconds, after one run to warm up."""
    task()
    taken = []
    for _ in range(times):
        start = time.perf_counter()
        task()
        taken.append(time.perf_counter() - start)
    return 1e3 * float(np.median(taken))
