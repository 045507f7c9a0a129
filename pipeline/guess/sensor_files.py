"""The sensor of each file, by its name, or by its motion relative to another file's gravity."""

import re
from collections import Counter
from collections.abc import Sequence
from itertools import permutations
from pathlib import Path

import numpy as np

from pipeline.guess.clocks import ClockGuess
from pipeline.guess.pool import FEWEST_MEANS, PooledTables, usual_step
from pipeline.guess.raw_tables import RawTable
from pipeline.guess.triads import chosen_triads

#: Names of the files in which phone apps write computed quantities and other sensors.
OTHER_FILES = {"gravity", "orientation", "magnetometer", "magnetometeruncalibrated", "compass",
               "barometer", "battery", "location", "linear acceleration", "linearacceleration",
               "pedometer"}
SENSOR_FILES = {"acc": ("acc",), "gyr": ("gyr", "angularvelocity", "rotationrate")}
"""Parts of the names of files, without blanks and signs, in which apps write the two sensors."""
ALONE = 4  #: fact: columns of a table of one triad with its times
MOST_SENSORS = 4  #: fact: files of one recording: three triads and a temperature


def hint_of(path: Path) -> str:
    """``acc`` or ``gyr`` if the file's name contains a word of that sensor; the last one decides.

    ``else`` if the name is that of another quantity; empty if it shows nothing.
    """
    name = re.sub(r"[\W_]", "", path.name.lower())
    if path.stem.lower() in OTHER_FILES:
        return "else"
    at = {quantity: max(map(name.rfind, words)) for quantity, words in SENSOR_FILES.items()}
    last = max(at, key=lambda quantity: at[quantity])
    return last if at[last] >= 0 else ""


def names_of_sensors(tables: Sequence[RawTable]) -> list[str]:
    """The name of each table's file if it holds a sensor of a recording, not a pose.

    That is a member of an archive or a file that is named after its sensor, without its number,
    unless as many poses as determine a sphere lie beside it with the same columns.
    """
    folders = {table.path.parent: table.path.parent.is_dir() for table in tables}
    kinds = [(table.path.parent, table.header, folders[table.path.parent] and hint_of(table.path))
             for table in tables]
    alike = Counter(kinds)
    return ["" if alike[kind] >= FEWEST_MEANS or kind[-1] in ("", "else") else
            re.sub(r"\d", "", table.path.name) if kind[-1] else table.path.name
            for table, kind in zip(tables, kinds, strict=True)]


def sensors_of_files(tables: Sequence[RawTable], clocks: Sequence[ClockGuess]) -> list[str]:
    """The hint of each table, by the name of its file, else by its relation to another file.

    If the names of two files of the same times show nothing, one is the gyroscope if it predicts
    the turns of gravity in the other, even if their columns have the same names.
    """
    hints = [hint_of(table.path) or (
        hint_of(table.path.parent) if len(table.columns) <= ALONE else "") for table in tables]
    able = [i for i, hint in enumerate(hints)
            if hint in ("", "acc") and clocks[i].is_known]
    together = {i: [j for j in able if clocks[i].overlaps(clocks[j])] for i in able}
    for i, j in permutations(able, 2):
        if (j in together[i] and len(together[i]) <= MOST_SENSORS and not hints[i]
                and hints[j] != "gyr" and _turns(tables[i], clocks[i], tables[j], clocks[j])):
            hints[i], hints[j] = "gyr", "acc"
    return hints


def _turns(one: RawTable, its: ClockGuess, other: RawTable, clock: ClockGuess) -> bool:
    """Whether the columns of one table predict the turns of gravity in the other's."""
    time_s = its.time_s[(its.time_s >= clock.time_s[0]) & (its.time_s <= clock.time_s[-1])]
    columns = {f"{number} {name}": np.interp(time_s, ticks.time_s, values)
               for number, table, ticks in ((1, one, its), (2, other, clock))
               for name, values in table.columns.items() if name != ticks.column}
    of_one = np.zeros(len(time_s), np.int64)
    pool = PooledTables(columns, of_one, time_s, usual_step(time_s), True, "")
    chosen = chosen_triads(pool)
    force, rate = chosen.force, chosen.rate
    if force is None or rate is None or force.columns[0][0] == rate.columns[0][0]:
        return False
    turn = rate.turns(force)
    return bool(rate.columns[0][0] == "1" and turn and turn.is_sure)
