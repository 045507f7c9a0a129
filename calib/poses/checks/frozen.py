"""Blocks of rows that a logger repeated instead of measuring.

Noise alone repeats a reading on all axes of a triad now and then. Of independent samples that take
the i-th reading with probability q_i, the share Σ q_i² repeats the one before, and a run of k
repetitions begins at a given sample with a probability of at most (max q_i)^k ≤ (Σ q_i²)^(k/2). A
run so long that none of its length is expected in the log is not noise.
"""

import math
from collections.abc import Sequence

import numpy as np

from calib.errors import Undetermined
from calib.poses.imu_log import TRIADS, BoolArray, FloatArray, ImuLog

FALSE_ALARM = 1e-6
"""Expected number of such runs in a log by noise alone, and probability that any other check of a
session's files reports a mistake where there is none. Derived: one in a million logs."""

CERTAIN_SD = 5.0
"""Sds from which a difference is certain. Derived: normal noise is beyond them with a probability
of 6e-7, as often as ``FALSE_ALARM`` allows."""

SHORTEST_BLOCK = 10
"""Length of a block, rows. Fact: sensors that are read faster than they measure repeat each reading
a few times, one of 100 Hz on a line of 1 kHz ten times."""

TOO_MANY = 0.5
"""Share of a pose's samples. A judgement: what stopped for longer than it ran is faulty."""

BLOCKS_LISTED = 4  #: it chooses words only


def frozen_samples(log: ImuLog, one_pose: bool = True) -> BoolArray:
    """Samples that repeat the one before for longer than noise does, shape (t,).

    In a log of one pose a single triad that does so counts; between poses all axes must.
    """
    readings = [log.readings(triad) for triad in TRIADS if log.has(triad)]
    parts = readings if one_pose else [np.hstack(readings)]
    return np.asarray(np.any([_frozen(part) for part in parts], axis=0))


def _frozen(readings: FloatArray) -> BoolArray:
    """Find frozen samples in readings, shape (t, k)."""
    repeats = np.concatenate([[False], (np.diff(readings, axis=0) == 0).all(axis=1)])
    edges = np.flatnonzero(np.diff(np.concatenate([repeats, [False]]).astype(np.int8)))
    starts, stops = edges[::2] + 1, edges[1::2] + 1
    frozen = np.zeros(len(repeats), dtype=bool)
    share = float(repeats.mean())
    if not 0 < share < 1:
        return frozen
    shortest = max(SHORTEST_BLOCK, 2 * math.log(FALSE_ALARM / len(repeats)) / math.log(share))
    for start, stop in zip(starts, stops, strict=True):
        if stop - start >= shortest:
            frozen[start:stop] = True
    return frozen


def without_frozen(
    log: ImuLog, turning: bool, one_pose: bool = True
) -> tuple[ImuLog, str | None]:
    """A log without its frozen samples.

    Parameters
    ----------
    log : ImuLog
    turning : bool
        Whether the plate turned. Then the longest stretch between frozen blocks is kept, since a
        mean over whole turns needs one without a gap.
    one_pose : bool
        As of :func:`frozen_samples`.

    Returns
    -------
    log : ImuLog
    note : str or None
        A sentence on what is left out; None where nothing is.

    Raises
    ------
    Undetermined
        More than half of the samples are frozen.
    """
    frozen = frozen_samples(log, one_pose)
    if not frozen.any():
        return log, None
    if one_pose and frozen.mean() > TOO_MANY:
        raise Undetermined(
            f"{log.label}: froze: {100 * frozen.mean():.0f} % of its samples only repeat the one "
            f"before. The sensor or its connection had stopped. Record the pose again."
        )
    edges = np.flatnonzero(np.diff(np.concatenate([[False], frozen, [False]]).astype(np.int8)))
    blocks = list(zip(edges[::2], edges[1::2], strict=True))
    plural = "s" if len(blocks) > 1 else ""
    note = (f"{log.label}: {len(blocks)} frozen block{plural}, in which the logger wrote one "
            f"reading again and again (rows {_listed(blocks)}); {int(frozen.sum())} of "
            f"{len(frozen)} samples are left out.")
    if turning:
        ends = [0, *(stop for _, stop in blocks)], [*(start for start, _ in blocks), len(frozen)]
        start, stop = max(zip(*ends, strict=True), key=lambda span: span[1] - span[0])
        return log.between(int(start), int(stop), log.label), note
    return log.where(~frozen), note


def _listed(blocks: Sequence[tuple[int, int]]) -> str:
    shown = ", ".join(f"{start + 1}-{stop}" for start, stop in blocks[:BLOCKS_LISTED])
    more = len(blocks) - BLOCKS_LISTED
    return f"{shown} and {more} more" if more > 0 else shown
