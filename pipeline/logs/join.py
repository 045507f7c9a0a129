"""Joining of logs of one sensor: one triad with the other, or separate recordings."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from calib.poses.imu_log import TRIADS, FloatArray, ImuLog
from calib.poses.rows import joined
from pipeline.errors import UnreadableInput
from pipeline.logs.clock import USUAL_STEPS

#: Longest pause of the second log that is interpolated over, in its usual steps.
LONGEST_GAP_STEPS = 10


def whole_logs(logs: Sequence[ImuLog]) -> list[ImuLog]:
    """``logs`` in their order, each with those that go on where it ends: a recorder begins a new
    file, whose first rows may be the last ones of the file before."""
    whole: dict[int, ImuLog] = {}
    for i in sorted(range(len(logs)), key=lambda i: logs[i].time_s[0]):
        begun = next((j for j, one in whole.items() if shared_rows(one, logs[i]) is not None), i)
        whole[begun] = _continued(whole[begun], logs[i]) if begun in whole else logs[i]
    return [whole[i] for i in sorted(whole)]


def shared_rows(one: ImuLog, other: ImuLog) -> int | None:
    """Number of rows with which ``one`` ends and ``other`` begins; None if it does not go on."""
    triads = [triad for triad in TRIADS if one.has(triad)]
    if triads != [triad for triad in TRIADS if other.has(triad)] or (
            one.columns.keys() != other.columns.keys() or one.time_s[-1] >= other.time_s[-1]):
        return None
    pause = other.time_s[0] - one.time_s[-1]
    if pause > 0:
        return 0 if pause < USUAL_STEPS * np.median(np.diff(one.time_s)) else None
    count = int((one.time_s >= other.time_s[0]).sum())
    pairs = [(one.time_s, other.time_s), *(
        (one.readings(triad), other.readings(triad)) for triad in triads)]
    return count if all(np.array_equal(a[-count:], b[:count]) for a, b in pairs) else None


def _continued(one: ImuLog, other: ImuLog) -> ImuLog:
    """Two logs of which the second goes on where the first ends, as one."""
    count = shared_rows(one, other)
    note = (f"the first {count} rows of {other.label} are the last ones of {one.label} and count "
            f"once" if count else f"{other.label} goes on where {one.label} ends")
    return replace(joined([one, other.take(slice(count, None))]),
                   label=f"{one.label} + {other.label}", notes=(*one.notes, *other.notes, note))


def group_logs(logs: Sequence[ImuLog]) -> list[list[ImuLog]]:
    """Groups of logs to be joined in time; a repeated triad begins the next group.

    ``[a, g]`` are the two triads of one recording, ``[a1, g1, a2, g2]`` those of two, and
    ``[one, two]`` with the same triads are two recordings with different poses.
    """
    groups: list[list[ImuLog]] = []
    for log in logs:
        held = [triad for triad in TRIADS if log.has(triad)]
        if groups and not any(other.has(triad) for other in groups[-1] for triad in held):
            groups[-1].append(log)
        else:
            groups.append([log])
    return groups


def join_logs(logs: Sequence[ImuLog]) -> ImuLog:
    """One log from separate accelerometer and gyroscope logs of the same period.

    If the time stamps agree, the readings are put side by side. Otherwise those of the later logs
    are interpolated linearly at the times of the first; samples of the first log that are outside
    another log, or in a pause of it, are left out.

    Raises
    ------
    UnreadableInput
        Two logs hold the same triad, or have fewer than two samples in their common time.
    """
    whole = logs[0]
    for other in logs[1:]:
        whole = _beside(whole, other)
    return whole


def _beside(one: ImuLog, other: ImuLog) -> ImuLog:
    """``other``'s triad and columns at the times of ``one``."""
    label = f"{one.label} + {other.label}"
    for triad in TRIADS:
        if one.has(triad) and other.has(triad):
            raise UnreadableInput(
                f"{label}: both hold the {triad}. Name one file with each triad, or give each "
                "pose its own file."
            )
    kept = _covered(one.time_s, other.time_s)
    if kept.sum() < 2:
        raise UnreadableInput(
            f"{label}: the first runs from {one.time_s[0]:g} to {one.time_s[-1]:g} s and the "
            f"second from {other.time_s[0]:g} to {other.time_s[-1]:g} s; common time is expected. "
            "Check that both belong to the same recording and count from the same start."
        )
    time_s = one.time_s[kept]
    same = np.array_equal(time_s, other.time_s)

    def moved(values: FloatArray) -> FloatArray:
        return values if same else np.asarray(np.interp(time_s, other.time_s, values))

    def side_by_side(triad: str) -> FloatArray:
        if not other.has(triad):
            return np.asarray(one.readings(triad)[kept])
        return np.column_stack([moved(axis) for axis in other.readings(triad).T])

    columns = {name: moved(values) for name, values in other.columns.items()}
    columns |= {name: values[kept] for name, values in one.columns.items()}
    return ImuLog(label, time_s, side_by_side("accelerometer"), side_by_side("gyroscope"), columns,
                  (*one.notes, *other.notes))


def _covered(time_s: FloatArray, other_s: FloatArray) -> np.ndarray:
    """Whether each of ``time_s`` (t,) is within ``other_s`` and not in a pause of it."""
    step = np.diff(other_s)
    after = np.clip(np.searchsorted(other_s, time_s, side="left"), 1, len(step))
    in_pause = (step > LONGEST_GAP_STEPS * np.median(step))[after - 1]
    touching = np.isin(time_s, other_s)
    return np.asarray((time_s >= other_s[0]) & (time_s <= other_s[-1]) & (touching | ~in_pause))
