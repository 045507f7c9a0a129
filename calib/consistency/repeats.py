"""Samples that occur twice: files under two names, copied blocks; and rows of a table of means.

Noise does not repeat itself. If a row has H bits of collision entropy given the rows before it
(``2^-H`` is the chance that two such rows agree), a stretch of L rows agrees with another of N by
chance with the probability ``N² 2^(-H L) / 2``; the length at which this falls below
``FALSE_ALARM`` is the shortest copy that can be detected. The log of most entropy decides that
length; logs whose rows would need more are left alone.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from calib.errors import Contradiction
from calib.poses.checks.frozen import FALSE_ALARM
from calib.poses.imu_log import ImuLog, Triad
from calib.poses.pose_set import PoseSet

Keys = NDArray[np.uint64]

SHORTEST_COPY = 32
"""Rows. Derived: a shorter copy moves a mean by less than its sd in every log of three seconds."""

WHOLE = 0.9
"""Share of a log from which a copy is called a copy of the whole log. It chooses words only."""

STRETCH = 3
"""Doublings of a row: stretches of eight rows are tested for a repetition within eight. Derived:
two alternating levels, A B A B, always repeat, and noise of one bit a row does in one of 32."""

FACTORS = 2 * np.random.default_rng(17).integers(2**63, size=9, dtype=np.uint64) + 1
"""Odd multipliers: the key of a row is its cells' bits, multiplied and added modulo 2^64.
Numerical."""


REPEATED = 0.2
"""Share of the poses. Derived: poses of one attitude placed by hand within a degree are equal to
the last digit of a ten-bit converter once in 25; of rows put together twice it is half."""


@dataclass(frozen=True)
class Copy:
    """Rows ``start : start + count`` of log ``first`` that also occur in log ``second``."""

    first: int
    second: int
    first_start: int
    second_start: int
    count: int


def row_keys(log: ImuLog, triad: Triad) -> Keys:
    """One number for each row's readings: equal readings have equal keys, (t,)."""
    key = np.zeros(len(log.time_s), dtype=np.uint64)
    for factor, column in zip(FACTORS, log.readings(triad).T, strict=False):
        key = (key + np.ascontiguousarray(column + 0.0).view(np.uint64)) * factor
        key ^= key >> np.uint64(29)
    return key


def _entropy(keys: Keys) -> float:
    """Collision entropy of one row given those before it, bits; no larger than rows can show.

    Alternating rows carry no information, however many levels a single row has: what counts is the
    share of rows that do not begin a stretch which repeats at once.
    """
    length = 2**STRETCH
    if len(keys) < 2 * length:
        return _collision_bits(keys)
    stretches = _window_keys(keys, STRETCH)
    again = np.zeros(len(stretches) - length, dtype=bool)
    for shift in range(1, length + 1):
        again |= stretches[:-length] == stretches[shift:len(stretches) - length + shift]
    return _collision_bits(keys) * float(1 - again.mean())


def _collision_bits(keys: Keys) -> float:
    """Collision entropy of ``keys``, bits."""
    _, counts = np.unique(keys, return_counts=True)
    n = len(keys)
    return float(-np.log2(((counts.astype(float) ** 2).sum() - n + 1) / n**2)) if n > 1 else 0.0


def _window_keys(keys: Keys, doublings: int) -> Keys:
    """Keys of all stretches of ``2**doublings`` rows, by first row."""
    factor = FACTORS[:1]  # an array: its products wrap around without a warning
    for i in range(doublings):
        half = 2**i
        keys = keys[:-half] * factor + keys[half:]
        factor = factor * factor
    return keys


def find_copy(logs: Sequence[ImuLog], triad: Triad) -> Copy | None:
    """The first stretch of readings of ``triad`` that occurs twice in ``logs``, or None.

    Rows equal to their predecessor count once: slow sensors are read several times.
    """
    every = [row_keys(log, triad) if log.has(triad) else np.zeros(0, np.uint64) for log in logs]
    kept = [np.flatnonzero(np.r_[True, keys[1:] != keys[:-1]]) if len(keys) else
            np.zeros(0, int) for keys in every]
    rows = [keys[index] for keys, index in zip(every, kept, strict=True)]
    bits = 2 * np.log2(sum(map(len, rows)) + 1) - np.log2(FALSE_ALARM)
    entropy = [_entropy(keys) for keys in rows]
    needed = bits / max(entropy, default=0.0) if any(entropy) else np.inf
    if needed > max(map(len, rows), default=0):
        return None
    doublings = int(np.ceil(np.log2(max(needed, SHORTEST_COPY))))
    usable = [i for i, h in enumerate(entropy)
              if len(rows[i]) >= 2**doublings and h * 2**doublings >= bits]
    if not usable:
        return None
    windows = [_window_keys(rows[i], doublings) for i in usable]
    log_of = np.repeat(usable, [len(keys) for keys in windows])
    start = np.concatenate([np.arange(len(keys)) for keys in windows])
    keys = np.concatenate(windows)
    order = np.lexsort((start, log_of, keys))
    same = np.flatnonzero(keys[order][1:] == keys[order][:-1])
    one, other = order[same], order[same + 1]
    shift = np.abs(start[one] - start[other])
    apart = (log_of[one] != log_of[other]) | (shift >= 2**doublings)
    if not apart.any():
        return None
    pairs = np.column_stack([one, other])[apart]
    a, b = min(pairs.tolist(), key=lambda pair: (log_of[pair[0]], start[pair[0]]))
    i, j = int(log_of[a]), int(log_of[b])
    first, second = rows[i][start[a]:], rows[j][start[b]:]
    length = min(len(first), len(second))
    differ = np.flatnonzero(first[:length] != second[:length])
    count = int(differ[0]) if differ.size else length
    return Copy(i, j, int(kept[i][start[a]]), int(kept[j][start[b]]),
                int(kept[i][start[a] + count - 1] - kept[i][start[a]] + 1))


def require_no_copies(logs: Sequence[ImuLog], triad: Triad) -> None:
    """Refuse logs of one triad that hold the same samples twice.

    Parameters
    ----------
    logs : sequence of ImuLog
        All of one triad, whatever their run.
    triad : str

    Raises
    ------
    Contradiction
        Naming both places. Samples that count twice make every sd too small.
    """
    copy = find_copy(logs, triad)
    if copy is None:
        return
    first, second = logs[copy.first], logs[copy.second]
    counted = "Counted twice they would make every sd too small"
    if first.label == second.label and copy.first != copy.second:
        raise Contradiction(
            f"{first.label}: its {triad} samples are used twice, by two runs or under two paths. "
            f"{counted}. Name each file once."
        )
    if copy.first != copy.second and copy.count >= WHOLE * min(
            len(first.time_s), len(second.time_s)):
        raise Contradiction(
            f"{first.label} and {second.label} hold the same {triad} samples: one file is a copy "
            f"of the other, or stands in the list under two names. {counted}. Take one of them "
            f"out, or name the file that was meant."
        )
    raise Contradiction(
        f"{second.label}: its {triad} samples {copy.second_start + 1} to "
        f"{copy.second_start + copy.count} are those of {first.label} from sample "
        f"{copy.first_start + 1} on, digit by digit, and noise does not repeat itself: a block was "
        f"copied or logged twice. {counted}. Record the pose again, or delete the copied lines."
    )


def require_no_repeated_means(poses: PoseSet) -> None:
    """Refuse poses whose means occur twice: rows of a table that were put together twice.

    Raises
    ------
    Contradiction
        Naming a pair of them.
    """
    turning = np.flatnonzero(~poses.reference.is_null)
    _, first, counts = np.unique(poses.reading[turning], axis=0, return_index=True,
                                 return_counts=True)
    again = int((counts - 1).sum())
    if again < max(2.0, REPEATED * len(turning)):
        return
    one = turning[first[int(np.argmax(counts > 1))]]
    same = np.flatnonzero((poses.reading == poses.reading[one]).all(axis=1))
    raise Contradiction(
        f"{poses.label[same[0]]} and {poses.label[same[1]]}: their {poses.triad} means are the "
        f"same to the last digit, and so are those of {again - 1} other pairs. Counted twice they "
        f"would make every sd too small. Take the copies out."
    )
