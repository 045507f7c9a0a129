"""Trials of a study on one process, on several of this machine, or on a Dask cluster."""

from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from typing import TypeVar

from calib.errors import CalibrationError
from pipeline.fleet.cluster import connected

Seed = int
Result = TypeVar("Result")
Trial = Callable[[Seed], Result]
Each = Callable[[Trial[Result], Iterable[Seed]], Iterator[tuple[Seed, Result | CalibrationError]]]
"""From a trial and its seeds to pairs of seed and result, in the order of the seeds; a session
that is refused has its refusal as result."""

BLOCKS_PER_WORKER = 8
"""Parts that the seeds of a study are cut into for each worker, so that all end together; derived:
the last part then keeps one worker busy for an eighth of its time at most."""


@contextmanager
def trials_on(workers: int, scheduler: str | None) -> Iterator[Each[Result]]:
    """How to map trials: in this process for one worker and no scheduler."""
    if workers == 1 and scheduler is None:
        yield lambda trial, seeds: iter(_block(trial, list(seeds)))
        return
    with connected(scheduler, workers) as client:
        def each(
            trial: Trial[Result], seeds: Iterable[Seed]
        ) -> Iterator[tuple[Seed, Result | CalibrationError]]:
            every = list(seeds)
            size = max(1, len(every) // (BLOCKS_PER_WORKER * workers))
            blocks = [every[i : i + size] for i in range(0, len(every), size)]
            for future in [client.submit(_block, trial, block, pure=False) for block in blocks]:
                yield from future.result()

        yield each


def _block(
    trial: Trial[Result], seeds: list[Seed]
) -> list[tuple[Seed, Result | CalibrationError]]:
    results: list[tuple[Seed, Result | CalibrationError]] = []
    for seed in seeds:
        try:
            results.append((seed, trial(seed)))
        except CalibrationError as refusal:
            results.append((seed, refusal))
    return results
