"""Tables that hold a recording again, or the rest of a pose that another one begins."""

from collections import Counter
from collections.abc import Sequence
from hashlib import blake2b
from itertools import pairwise
from pathlib import Path

import numpy as np

from calib.poses.imu_log import TRIADS, FloatArray, ImuLog, Triad
from pipeline.guess.magnitudes import sample_noise_sd
from pipeline.guess.pool import FEWEST_MEANS, REST_S, STILL, usual_step
from pipeline.guess.sensor_files import names_of_sensors
from pipeline.guess.table_guess import TableGuess
from pipeline.logs.clock import EPOCH_S
from pipeline.logs.join import shared_rows
from pipeline.text.names import command

SAME_SDS = 5.0
"""Largest distance of two means of one pose over the noise of their difference. A judgement: noise
that is correlated widens it twofold, and a sensor that is laid anew lies off by ten and more."""
UNLIKE = 0.5
"""Share of the motion in one log from which another of the same times does not explain it. A
judgement: of two sensors on one board a hundredth is left, of two recordings nearly all."""

OPPOSITE = 0.9
"""Least cosine between the readings of one accelerometer and the opposite of another's. A
judgement: biases of a tenth of gravity leave 0.99, other axes a third."""


def drop_alternatives(tables: Sequence[TableGuess]) -> tuple[list[TableGuess], list[str]]:
    """The tables without repeated sensors of one kind at the same times, and a note on each.

    A phone's app writes the same sensor two or three times, and a flight controller has several
    sensors, whose poses must not be mixed.
    """
    copies = _copies(tables)
    tables = [table for table in tables if table not in copies]
    kept: list[TableGuess] = []
    passed_over: dict[tuple[str, str], list[Path]] = {}
    like = Counter((table.path.parent, *table.table.columns) for table in tables)
    sensors = dict(zip(tables, names_of_sensors([one.table for one in tables]), strict=True))
    # Readings that the phone has not corrected come before corrected ones.
    for table in sorted(tables, key=lambda table: (
            _is_mirrored(table, tables), "uncalibrated" not in table.path.name.lower())):
        are_poses = like[table.path.parent, *table.table.columns] >= FEWEST_MEANS  # of one sensor
        same = None if are_poses else next(
            (other for other in kept if _are_alternatives(
                table, other, sensors[table] != sensors[other])), None)
        if same is None:
            kept.append(table)
        else:
            passed_over.setdefault((table.path.name, same.path.name), []).append(table.path)
    order = {id(table): i for i, table in enumerate(tables)}
    return sorted(kept, key=lambda table: order[id(table)]), [
        *(f"{table.path}: left out, because it holds the numbers of {other.path} again"
          for table, other in copies.items()),
        *(f"{name}: not used, because {other} holds a sensor of the same kind at the same times; "
          f"to calibrate it, type: {command('import', *paths)}"
          for (name, other), paths in passed_over.items())]


def _copies(tables: Sequence[TableGuess]) -> dict[TableGuess, TableGuess]:
    """The tables whose numbers are all those of another one before them, which is named."""
    first: dict[bytes, TableGuess] = {}
    copies: dict[TableGuess, TableGuess] = {}
    for table in tables:
        numbers = blake2b()
        for values in table.table.columns.values():
            numbers.update(np.ascontiguousarray(values).tobytes())
        if (other := first.setdefault(numbers.digest(), table)) is not table:
            copies[table] = other
    return copies


def _are_alternatives(one: TableGuess, other: TableGuess, two_sensors: bool) -> bool:
    """Whether two tables of one recording, which may be files of two sensors, hold the same triad.
    """
    both = any(getattr(one, triad) and getattr(other, triad) for triad in TRIADS)
    together = one.path.parent == other.path.parent and two_sensors
    since_1970 = min(one.clock.time_s[0], other.clock.time_s[0]) > EPOCH_S[0]
    return (both and (since_1970 or together) and one.clock.overlaps(other.clock)
            and not _move_apart(one, other))


def _is_mirrored(table: TableGuess, tables: Sequence[TableGuess]) -> bool:
    """Whether an accelerometer in g reads the opposite of one in m/s² at the same times.

    Apple's interface gives g, and -1 along the axis that points up; what an app writes in m/s² has
    the sign of the specific force.
    """
    if table.accelerometer is None or dict(table.accelerometer.sheet).get("unit") != "g":
        return False
    others = [other for other in tables if other.path.parent == table.path.parent
              and other.accelerometer is not None
              and dict(other.accelerometer.sheet).get("unit") == "m_s2"
              and table.clock.overlaps(other.clock)]
    for other in others:
        _, values = _at_same_times(table, other, "accelerometer")
        if values and np.vdot(*values) < -OPPOSITE * np.prod([*map(np.linalg.norm, values)]):
            return True
    return False


def _at_same_times(
    one: TableGuess, other: TableGuess, triad: Triad
) -> tuple[list[ImuLog], list[FloatArray]]:
    """The logs of two tables, and their readings, SI, (t, 3), at the same times; nothing where a
    table is no log."""
    logs = [log for table in (one, other) if (log := table.log()) is not None]
    if len(logs) < 2:
        return [], []
    begin, end = max(log.time_s[0] for log in logs), min(log.time_s[-1] for log in logs)
    at_s = np.arange(begin, end, REST_S)
    return logs, [
        np.column_stack([np.interp(at_s, log.time_s, axis) for axis in log.readings(triad).T])
        for log in logs]


def _move_apart(one: TableGuess, other: TableGuess) -> bool:
    """Whether one moves when the other does not, in recordings that both count from 0.

    Two sensors of one body feel its motion at the same times: the readings of one are those of the
    other in other axes and units.
    """
    name = next(name for name in TRIADS if getattr(one, name) and getattr(other, name))
    logs, values = _at_same_times(one, other, name)
    for log, mine, others in zip(logs, values, values[::-1], strict=True):
        known = np.column_stack([others, np.ones(len(others))])
        unlike = mine - known @ np.linalg.lstsq(known, mine, rcond=None)[0]
        moves = mine.std(axis=0).max() > STILL * sample_noise_sd(log.readings(name))
        if moves and unlike.var(axis=0).sum() > UNLIKE * mine.var(axis=0).sum():
            return True
    return False


def without_continuations(tables: Sequence[TableGuess]) -> tuple[list[TableGuess], list[str]]:
    """The tables of single poses without those that go on with the pose of the one before, and a
    note on each: of a pose that was cut in several files the longest is used."""
    runs = [[table] for table in tables[:1]]
    for one, other in pairwise(tables):
        if _goes_on(one, other):
            runs[-1].append(other)
        else:
            runs.append([other])
    longest = [max(run, key=lambda table: table.table.rows) for run in runs]
    return longest, [
        f"{', '.join(table.path.name for table in run)}: one pose that was cut; it counts once, by "
        f"its longest part, {table.path.name}"
        for run, table in zip(runs, longest, strict=True) if run[1:]]


def _goes_on(one: TableGuess, other: TableGuess) -> bool:
    """Whether a table begins when another ends, in the same attitude and motion, or with its last
    rows."""
    if None in (one.clock.column, other.clock.column) or (
            one.accelerometer, one.gyroscope) != (other.accelerometer, other.gyroscope):
        return False
    first, second = one.log(), other.log()
    shared = shared_rows(first, second) if first and second else None
    if shared is None or first is None or second is None:
        return False
    rows = max(2, round(REST_S / usual_step(first.time_s)))
    return shared > 0 or all(
        _reads_alike(first.readings(triad)[-rows:], second.readings(triad)[:rows])
        for triad in TRIADS if first.has(triad))


def _reads_alike(one: FloatArray, other: FloatArray) -> bool:
    """Whether the means of two short parts (t, 3) differ by no more than their noise."""
    variance = sum(part.var(axis=0).sum() / len(part) for part in (one, other))
    return bool(np.sum((one.mean(axis=0) - other.mean(axis=0)) ** 2) <= SAME_SDS**2 * variance)
