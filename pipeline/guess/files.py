"""From the files on the command line to the guess of their tables and clips."""

import re
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from calib.earth import STANDARD_GRAVITY_M_S2
from pipeline.errors import NoReadings, UnreadableInput
from pipeline.guess.magnitudes import FORCE_UNITS, is_direction, typical_length
from pipeline.guess.plate import MeasuredClip
from pipeline.guess.pool import reads_alike, sphere_through, still_means
from pipeline.guess.raw_tables import RawTable, raw_tables
from pipeline.guess.sensor_files import hint_of, names_of_sensors
from pipeline.guess.table_guess import SHOWN, TableGuess, guess_tables
from pipeline.guess.triads import Triple, possible_triples, triples_by_name
from pipeline.logs.clock import ASSUMED_HZ, FEWEST_TO_SHOW
from pipeline.logs.header_words import read_name
from pipeline.logs.source import is_corrected, require_uncorrected
from pipeline.stages.context import RunContext
from pipeline.stages.rate import ClipToFollow, SettingRate, follow_clips, measure_setting
from pipeline.text.formatting import count

#: Suffixes of clips; fact.
CLIPS = {".mp4", ".mov", ".avi", ".mkv", ".webm", ".m4v", ".mpg", ".mpeg", ".mts", ".3gp", ".wmv"}
NO_ROWS = "{}: no table in it holds a row of three numbers. Is it a log?"
NUMBER = re.compile(r"\d[\d.e+-]*")
LIES_STILL = ("its accelerometer reads nearly the same in every rest, so that gravity is removed "
              "from it, or it lay in one attitude. Record the acceleration with gravity, in poses")
REMOVED = 0.3
"""Share of gravity below which a typical reading shows that gravity was removed: half of the rows
of a log are at rest."""


def guess_files(
    files: Sequence[Path], rate_hz: float | None
) -> tuple[list[TableGuess], tuple[str, ...]]:
    """Guesses of all tables of ``files``, and notes on files without a table, corrected logs and
    tables without a triad; none on other sensors of a recording of which a table is used.

    Parameters
    ----------
    files : sequence of Path
    rate_hz : float or None
        The sample rate, stated by the user.

    Raises
    ------
    UnreadableInput
        A file cannot be read, no table of any file holds a triad, or all are corrected.
    """
    corrected = [path for path in files if is_corrected(path)]
    if len(corrected) == len(files):
        require_uncorrected(files[0])
    tables, without = _tables_of_files([path for path in files if path not in corrected])
    every = _alike(tables, guess_tables(tables, rate_hz))
    guesses = [guess for guess in every if guess is not None]
    used = {folder for guess in guesses for folder in guess.path.parents}
    passed_over = _not_used([
        table for table, guess in zip(tables, every, strict=True) if guess is None
        and (table.path.parent not in used or called_accelerometers(table)
             or (table.path.parent.is_dir() and hint_of(table.path) != "else"))])
    if not guesses:
        raise UnreadableInput(passed_over[0] if passed_over else NO_ROWS.format(files[0]))
    left_out = ((without, "no line is a row of readings"),
                (corrected, "`pipeline apply` has corrected its readings already"))
    return guesses, (*(f"{listed(paths)}: left out, because {why}."
                       for paths, why in left_out if paths), *passed_over)


def _alike(
    tables: Sequence[RawTable], guesses: Sequence[TableGuess | None]
) -> list[TableGuess | None]:
    """``guesses`` without those of columns without names that most tables of as many deny: a rate
    of the plate may be as long as gravity in counts, and the rest then is not."""
    layouts = [tuple(table.columns) for table in tables]
    some, none = (Counter(layout for layout, guess in zip(layouts, guesses, strict=True)
                          if (guess is None) == is_none) for is_none in (False, True))
    return [None if table.positions and none[layout] > some[layout] else guess
            for table, layout, guess in zip(tables, layouts, guesses, strict=True)]


def _tables_of_files(files: Sequence[Path]) -> tuple[list[RawTable], list[Path]]:
    """The tables of all files, and the files without one; if none has one, the first is refused."""
    tables: list[RawTable] = []
    refused: dict[Path, NoReadings] = {}
    for path in files:
        try:
            tables += raw_tables(path, files)
        except NoReadings as error:
            refused[path] = error
    if refused and not tables:
        raise next(iter(refused.values()))
    return _under_one_header(tables), [*refused]


def _under_one_header(tables: Sequence[RawTable]) -> list[RawTable]:
    """``tables``, of which those without a header have that of the files of their sensor and width
    beside them: a logger writes it once, into the first of its files."""
    named, every = [table for table in tables if table.header], []
    for table in tables:
        headers = {other.header for other in named if (
            other.path.parent, len(other.header), hint_of(other.path)) == (
            table.path.parent, len(table.positions), hint_of(table.path))}
        if len(headers) == 1 and len({*(header := headers.pop())}) == len(header):
            table = replace(table, positions=header, header=header, columns={
                name: table.columns[place] for name, place in zip(
                    header, table.positions, strict=True) if place})
        every.append(table)
    return every


def _not_used(tables: Sequence[RawTable]) -> list[str]:
    """One sentence for all tables with one reason, whatever its numbers; poses of one sensor have
    that of all together, and so have files of one name in several recordings."""
    kinds: dict[tuple[str, ...], list[RawTable]] = {}
    for table, name in zip(tables, names_of_sensors(tables), strict=True):
        kinds.setdefault((name, *table.columns), []).append(table)
    groups: dict[str, list[tuple[Path, str]]] = {}
    for first, *more in kinds.values():
        why = why_no_log(replace(first, columns={
            name: np.concatenate([table.columns[name] for table in (first, *more)])
            for name in first.columns}))
        groups.setdefault(NUMBER.sub("", why), []).extend(
            (table.path, why) for table in (first, *more))
    return [f"{listed([path for path, _ in group])}: not used, because {group[0][1]}."
            for group in groups.values()]


def listed(paths: Sequence[Path]) -> str:
    """A path, or the different names of several with their number."""
    if len(paths) == 1:
        return str(paths[0])
    names = list(dict.fromkeys(path.name for path in paths))
    more = f" and {len(names) - SHOWN} more" if names[SHOWN:] else ""
    return f"{', '.join(names[:SHOWN])}{more} ({len(paths)} files)"


def is_clip(path: Path) -> bool:
    """Whether the name of a file is that of a clip."""
    return path.suffix.lower() in CLIPS


def rates_of_clips(clips: Sequence[Path], context: RunContext) -> dict[Path, SettingRate]:
    """The rate of the plate in each clip; each clip is a separate setting.

    Raises
    ------
    UnreadableInput, UnreadableVideo, RateRefused
        For the first clip, in their order, that shows no turning plate.
    """
    if not clips:
        return {}
    from vision.rate.timebase import CLOCK_PPM, Timebase  # OpenCV, where there is a clip

    tracks = follow_clips([ClipToFollow(path) for path in clips], context)
    timebase = Timebase("container", None, CLOCK_PPM["container"])
    return {path: measure_setting(path.stem, [track], timebase)
            for path, track in zip(clips, tracks, strict=True)}


def measured_clips(rates: Mapping[Path, SettingRate]) -> list[MeasuredClip]:
    """The signed rate of each clip in ``rates``."""
    return [MeasuredClip(path, rate.signed_rad_s) for path, rate in rates.items()]


def called_accelerometers(table: RawTable) -> list[Triple]:
    """Triples of columns that belong to an accelerometer by their names or that of their file."""
    names = list(table.columns)
    if hint_of(table.path) == "else":
        return []
    words = {name: read_name(name) for name in names}
    return [*triples_by_name(names, "acc"),
            *(triple for triple in triples_by_name(names, "") if words[triple[0]].gravity_free),
            *(triple for triple in possible_triples(names) if hint_of(table.path) == "acc"
              and [words[name].axis for name in triple] == [0, 1, 2])]


def why_no_log(table: RawTable) -> str:
    """Reason why a table cannot be used, as the end of a sentence that names the table."""
    names = list(table.columns)
    called = called_accelerometers(table)
    gravity = [triple for triple in triples_by_name(names, "")
               if "grav" in read_name(triple[0]).stem]
    if gravity and called and read_name(called[0][0]).gravity_free:
        sums = ", ".join(f"{one} + {other}"
                         for one, other in zip(gravity[0], called[0], strict=True))
        return (f"its accelerometer is split into gravity and what is left; the readings are the "
                f"sums of both. Write {sums} as three columns, and import that table")
    for triple in called:
        values = np.column_stack([table.columns[name] for name in triple])
        values = values[np.isfinite(values).all(axis=1)]
        if len(values) < FEWEST_TO_SHOW:
            return (f"it has {count(len(values), 'row')} of readings, too few to tell a sensor by. "
                    f"Record the pose again, for some seconds")
        if is_direction(values):
            return ("all its readings have the length 1, so they were normalised and show no "
                    "scale; record the raw readings")
        stuck = [name for name in triple if np.nanmax(table.columns[name]) == np.nanmin(
            table.columns[name])]
        if stuck:
            numbers = " and ".join(f"{name} reads {table.columns[name][0]:g}" for name in stuck)
            return (f"{numbers} in every row, which no sensor does that answers: it is dead, or "
                    f"the column is another's. Check its wiring, and what writes the log")
        usual = 1.0 if (values < 0).any() else STANDARD_GRAVITY_M_S2  # volts have no sign
        unit = FORCE_UNITS.get(read_name(triple[0]).unit, usual)
        if typical_length(values) < REMOVED * STANDARD_GRAVITY_M_S2 / unit:
            return ("gravity is removed from its readings (half of them are shorter than "
                    f"{typical_length(values):.2g}), and what is left shows no scale; record the "
                    "acceleration with gravity (Sensor Logger: Total Acceleration or Accelerometer "
                    "Uncalibrated; phyphox: Acceleration (with g))")
    alone = len(possible_triples(names)) == 1 and hint_of(table.path) != "else"
    for triple in possible_triples(names):
        values = np.column_stack([table.columns[name] for name in triple])
        values = values[np.isfinite(values).all(axis=1)]
        rests = sphere_through(still_means(values, np.zeros(len(values), np.int64), 1 / ASSUMED_HZ))
        if rests is not None and rests.is_far and (values > 0).all():
            zero = ", ".join(f"{value:.4g}" for value in rests.centre)
            return (f"{', '.join(triple)} have one length at rest only about {zero}, as the volts "
                    f"and readings of an analog sensor do, whose zero is no 0. Subtract these and "
                    f"divide by {rests.radius:.4g}: that is g")
        if alone and reads_alike(values, 1 / ASSUMED_HZ):
            return LIES_STILL
    shown = ", ".join(names[:SHOWN])
    none = "what is called so has not" if called else (
        "none are called so, and no three that are not called another quantity have")
    return (f"no accelerometer and no gyroscope are among its columns ({shown}): {none} gravity's "
            f"length at rest in a usual unit or range; computed angles do not replace them. Log "
            f"the raw acceleration and rate, each kind of log in one unit, or name their columns "
            f"in a configuration, as `pipeline init` shows")
