"""Samples that occur twice: files under two names, copied blocks; and rows of a table of means.

Noise does not repeat itself. If a row has h bits of collision entropy given the rows before it
(``2^-h`` is the chance that two such rows agree), a stretch whose rows have H bits together agrees
with another of N by chance with the probability ``N² 2^-H / 2``; where this is below
``FALSE_ALARM`` two equal stretches are a copy. The entropy is that of the rows near by: in a rest
few levels take turns, however much the log moves elsewhere.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from calib.errors import Contradiction
from calib.poses.checks.frozen import FALSE_ALARM
from calib.poses.imu_log import FloatArray, ImuLog, Triad
from calib.poses.pose_set import PoseSet

Keys = NDArray[np.uint64]

SHORTEST_COPY = 32
"""Rows. Derived: a shorter copy moves a mean by less than its sd in every log of three seconds."""

WHOLE = 0.9
"""Share of a log from which a copy is called a copy of the whole log. It chooses words only."""

NEAR_BY = 256
"""Rows, about, over which the entropy of one is estimated. Derived: among so many, half a bit a row
still makes stretches of eight equal hundreds of times, and a rest of three seconds fills them."""

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


def _entropy(keys: Keys) -> FloatArray:
    """Collision entropy of each row (t,) given those before it, bits, by the rows near by.

    That of the shortest stretches of which no two are equal, a row's share; where stretches of
    eight are equal too, what they have more than those of four.
    """
    parts = np.array_split(keys, max(1, len(keys) // NEAR_BY))
    return np.concatenate([np.full(len(part), _bits_a_row(part)) for part in parts])


def _bits_a_row(keys: Keys) -> float:
    """Collision entropy of one row given those before it, bits; 0 for fewer than the shortest
    copy."""
    shorter = bits = 0.0
    for doublings in range(4 if len(keys) >= SHORTEST_COPY else 0):
        stretches, shorter = _window_keys(keys, doublings), bits
        bits = _collision_bits(stretches)
        if np.unique(stretches).size == stretches.size:
            return float(bits / 2.0**doublings)
    return max(bits - shorter, 0.0) / 4


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
    told = [np.r_[0.0, np.cumsum(_entropy(keys))] for keys in rows]
    longest = max(map(len, rows), default=0)
    for doublings in range(SHORTEST_COPY.bit_length() - 1, longest.bit_length()):
        half, length = 2**doublings // 2, 2**doublings
        # Stretches that are long enough, and whose first half was not: those were compared before.
        able = [np.flatnonzero((part[length:] - part[:-length] >= bits) & (
            (length == SHORTEST_COPY) | (part[half:-half] - part[:-length] < bits)))
            for part in told]
        log_of = np.repeat(np.arange(len(rows)), [len(starts) for starts in able])
        if not len(log_of):
            continue
        start = np.concatenate(able)
        keys = np.concatenate([_window_keys(row, doublings)[starts]
                               for row, starts in zip(rows, able, strict=True) if len(starts)])
        order = np.lexsort((start, log_of, keys))
        same = np.flatnonzero(keys[order][1:] == keys[order][:-1])
        one, other = order[same], order[same + 1]
        apart = (log_of[one] != log_of[other]) | (np.abs(start[one] - start[other]) >= length)
        pairs = np.column_stack([one, other])[apart].tolist()
        if pairs:
            a, b = min(pairs, key=lambda pair: (log_of[pair[0]], start[pair[0]]))
            i, j = int(log_of[a]), int(log_of[b])
            first, second = int(start[a]), int(start[b])
            length = min(len(rows[i]) - first, len(rows[j]) - second)
            differ = np.flatnonzero(rows[i][first:][:length] != rows[j][second:][:length])
            last = first + (int(differ[0]) if differ.size else length) - 1
            return Copy(i, j, int(kept[i][first]), int(kept[j][second]),
                        int(kept[i][last] - kept[i][first] + 1))
    return None


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
