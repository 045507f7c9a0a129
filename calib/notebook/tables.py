"""From a table to poses: a DataFrame, a mapping of columns, or an array of pose means.

Columns: ``acc_x, acc_y, acc_z`` in m/s², ``gyr_x, gyr_y, gyr_z`` in rad/s, ``sd_acc_x`` ... (the
sds of the means; with ``samples``, of the samples), ``time_s``, ``rate_rad_s`` (of the plate: 0 at
rest, negative clockwise), ``pose`` (what the pose is called), ``run`` (the setting of the plate,
``stopped`` at rest), ``station``, and any further numeric column. A row is the mean of a pose;
where several rows have the same ``pose`` they are its samples.
"""

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from calib.earth import (
    GREATEST_GRAVITY_M_S2,
    LEAST_GRAVITY_M_S2,
    STANDARD_GRAVITY_M_S2,
)
from calib.errors import UnusableLog
from calib.numbers import RPM
from calib.poses.averaging.average_pose import average_pose
from calib.poses.averaging.pose_mean import SAMPLES, SD, TIME, PoseMean, tabled_poses, triad_columns
from calib.poses.data_sheet import TriadSpec
from calib.poses.imu_log import AXES, SI_UNIT, TRIADS, FloatArray, ImuLog, Triad
from calib.poses.reference import PlateRate
from calib.poses.runs.pose_run import PoseRun
from calib.poses.runs.reference_runs import gravity_run, stopped_run, turning_run

SI = TriadSpec(np.inf, 0, "si")
POSE, RATE, RUN, STATION, STOPPED = "pose", "rate_rad_s", "run", "station", "stopped"

#: Units used in place of m/s²: the number of each in one SI unit; definition
FORCE_UNITS: Mapping[str, float] = {"g": 1 / STANDARD_GRAVITY_M_S2,
                                    "mg": 1e3 / STANDARD_GRAVITY_M_S2}
#: The same in place of rad/s; definition
RATE_UNITS: Mapping[str, float] = {"°/s": math.degrees(1.0), "m°/s": 1e3 * math.degrees(1.0),
                                   "rpm": 1 / RPM}
FAR, NEAR = 3.0, 1.3
"""Ratios of units: a bias and a gain error together change a typical reading by less than FAR; g
and m/s² are 9.8 apart, rpm and °/s six. Within NEAR of a unit the readings are in it. Derived."""

Columns = dict[str, FloatArray]


def columns_of(table: Any, triad: Triad) -> tuple[Columns, list[str]]:
    """The numeric columns of a table, and the label of each row's pose.

    Parameters
    ----------
    table : DataFrame, mapping of name to sequence, structured array, or array of shape (n, 3)
        An array holds the readings of ``triad`` alone.
    triad : str

    Raises
    ------
    UnusableLog
        The table has no column of the triad, a column is no numbers, or lengths differ.
    """
    if isinstance(table, list | tuple):
        table = np.asarray(table)
    if not isinstance(table, np.ndarray) and not hasattr(table, "keys"):
        raise UnusableLog(f"table: {type(table).__name__} found; a DataFrame, a mapping of columns "
                          f"or an array (n, 3) is expected. A file is read by pandas.read_csv.")
    if isinstance(table, np.ndarray) and table.dtype.names is None:
        if table.ndim != 2 or table.shape[1] != 3:
            raise UnusableLog(f"table: an array of shape {table.shape}, (n, 3) expected: the x, y, "
                              f"z means of every pose. Name the columns of anything else.")
        table = dict(zip(triad_columns(triad), table.T, strict=True))
    names = list(table.dtype.names or () if isinstance(table, np.ndarray) else table.keys())
    expected = triad_columns(triad)
    absent = [name for name in expected if name not in names]
    if absent:
        raise UnusableLog(f"table: no column {', '.join(absent)}; {', '.join(expected)} are "
                          f"expected. The table has {', '.join(map(str, names)) or 'no columns'}."
                          f"{_renaming(list(map(str, names)), triad)}")
    if len(set(names)) < len(names):
        raise UnusableLog("table: a name stands over two columns; every column needs its own.")
    columns = {str(name): _numbers(str(name), table[name]) for name in names
               if name not in (POSE, RUN, STATION)}
    lengths = {name: len(values) for name, values in columns.items()}
    if len(set(lengths.values())) > 1:
        raise UnusableLog(f"table: columns of different lengths: {lengths}.")
    rows = next(iter(lengths.values()))
    if rows == 0:
        raise UnusableLog("table: it has no rows; a row for each pose is expected.")
    _require_sds(columns)
    labels = [str(one) for one in table[POSE]] if POSE in names else [
        f"row {i + 1}" for i in range(rows)]
    return columns, labels


def parts_by(table: Any, column: str) -> Iterator[tuple[str, dict[str, Any]]]:
    """The rows of a table sensor by sensor, in the order in which they first occur.

    Parameters
    ----------
    table : DataFrame, mapping of name to sequence, or structured array
    column : str
        The column that names the sensor of a row.

    Yields
    ------
    sensor : str
    part : dict of str to array, shape (n,)
        The other columns.

    Raises
    ------
    UnusableLog
        The table has no such column.
    """
    names = list(table.dtype.names or () if isinstance(table, np.ndarray)
                 else table.keys() if hasattr(table, "keys") else ())
    if column not in names:
        raise UnusableLog(f"table: no column {column}, by which its sensors are told apart; it has "
                          f"{', '.join(map(str, names)) or 'no named columns'}.")
    columns = {name: np.asarray(table[name]) for name in names}
    sensors, number = np.unique(columns.pop(column).astype(str), return_inverse=True)
    order = np.argsort(number, kind="stable")
    rows = np.split(order, np.cumsum(np.bincount(number))[:-1])
    for i in sorted(range(len(sensors)), key=lambda i: rows[i][0]):
        yield str(sensors[i]), {name: values[rows[i]] for name, values in columns.items()}


def _renaming(names: Sequence[str], triad: Triad) -> str:
    """Advice to rename three columns whose names differ only in the axis; empty without such."""
    for name in names:
        for i, letter in enumerate(name):
            axes = AXES if letter == "x" else [axis.upper() for axis in AXES]
            three = [name[:i] + axis + name[i + 1 :] for axis in axes]
            if letter in "xX" and all(one in names for one in three):
                pairs = ", ".join(f"'{theirs}': '{ours}'"
                                  for theirs, ours in zip(three, triad_columns(triad), strict=True))
                return f" If these are the readings: table.rename(columns={{{pairs}}})."
    return " Rename the columns: table.rename(columns={...})."


def _numbers(name: str, values: Any) -> FloatArray:
    raw = np.asarray(values) if np.ndim(values) == 1 else np.zeros(())
    if raw.ndim != 1 or raw.dtype.kind in "mMc":
        raise UnusableLog(f"table: column {name} is no list of real numbers. Of dates and times "
                          f"make seconds first; a value for each row is expected.")
    try:
        return np.asarray(raw, dtype=float)
    except (TypeError, ValueError) as error:
        raise UnusableLog(f"table: column {name} is not numeric ({error}). Where it names the "
                          f"sensor of a row, state `by={name!r}`; else leave it out, or turn it "
                          f"into numbers.") from error


def _require_sds(columns: Columns) -> None:
    """Refuse sds of some axes only, and sds and sample counts that are not positive."""
    for triad in TRIADS:
        sds = [SD + name for name in triad_columns(triad)]
        there = [name for name in sds if name in columns]
        if there and len(there) < len(sds):
            raise UnusableLog(f"table: {', '.join(there)} without the other axes; {', '.join(sds)} "
                              f"are expected together, or none of them.")
    for name, values in columns.items():
        if (name == SAMPLES or name.startswith(SD)) and not (values > 0).all():
            raise UnusableLog(f"table: column {name} has {values[~(values > 0)][0]:g}; a positive "
                              f"number is expected in every row.")


def finite(name: str, value: Any, least: float = -np.inf) -> float:
    """An argument that is a finite number of at least ``least``, in its own unit.

    Raises
    ------
    UnusableLog
        Naming the argument.
    """
    is_number = isinstance(value, (int, float, np.integer, np.floating))
    if not is_number or isinstance(value, bool) or not least <= value < np.inf:
        wanted = "a finite number" if least < 0 else "a finite number that is not negative"
        raise UnusableLog(f"{name}={value!r}: {wanted} is expected.")
    return float(value)


def gravity_runs(table: Any, gravity: float, sd: float) -> list[PoseRun]:
    """The poses of an accelerometer under gravity, m/s²; errors as of :func:`columns_of`."""
    if not LEAST_GRAVITY_M_S2 <= gravity <= GREATEST_GRAVITY_M_S2:
        raise UnusableLog(f"gravity={gravity:g}: {LEAST_GRAVITY_M_S2} to {GREATEST_GRAVITY_M_S2} "
                          f"m/s² is expected, as everywhere on Earth.")
    columns, labels = columns_of(table, "accelerometer")
    _require_si(columns, "accelerometer", gravity, FORCE_UNITS)
    return [gravity_run("table", pose_means(columns, labels, 0.0), gravity, sd)]


def plate_runs(table: Any, rate: float | None, sd: float) -> list[PoseRun]:
    """The poses of a gyroscope, one run for each rate of the plate.

    Parameters
    ----------
    table : see :func:`columns_of`
    rate : float or None
        Rate of the plate in all poses, rad/s; None takes the column ``rate_rad_s``.
    sd : float
        Its sd, common to all poses of a rate, rad/s.

    Raises
    ------
    UnusableLog
        As of :func:`columns_of`, or no rate is stated.
    Undetermined
        The readings do not fit the rates.
    """
    columns, labels = columns_of(table, "gyroscope")
    if rate is None and RATE not in columns:
        raise UnusableLog("table: no rate of the plate. State `rate=` in rad/s, or a column "
                          "rate_rad_s; 0 means that the plate stood still.")
    rates = columns.pop(RATE, np.zeros(len(labels)))
    if rate is not None:
        named = RUN in (table.dtype.names or () if isinstance(table, np.ndarray) else table)
        settings = np.asarray(table[RUN] if named else labels).astype(str)
        if named and len({*settings} - {STOPPED}) > 1:
            raise UnusableLog(f"table: column {RUN} names {', '.join(sorted({*settings}))}, and "
                              f"one rate is stated. State that of each row in a column {RATE}.")
        rates = np.where(settings == STOPPED, 0.0, rate)
    if not np.isfinite(rates).all():
        raise UnusableLog("table: a rate of the plate is not a finite number.")
    turning = np.abs(rates[rates != 0])
    if turning.size:
        _require_si({name: values[rates != 0] for name, values in columns.items()}, "gyroscope",
                    float(np.median(turning)), RATE_UNITS)
    runs = []
    for omega in dict.fromkeys(rates.tolist()):
        rows = np.flatnonzero(rates == omega)
        means = pose_means({name: values[rows] for name, values in columns.items()},
                           [labels[i] for i in rows], omega)
        if omega == 0:
            runs.append(stopped_run(STOPPED, means, None))
            continue
        plate = PlateRate(f"{omega:.6g} rad/s", np.array([abs(omega)]), np.array([sd]),
                          direction="ccw" if omega > 0 else "cw")
        runs.append(turning_run(means, plate, None))
    return runs


def _require_si(
    columns: Columns, triad: Triad, magnitude: float, units: Mapping[str, float]
) -> None:
    """Refuse readings whose typical length is the reference in a unit other than SI's."""
    readings = np.column_stack([columns[name] for name in triad_columns(triad)])
    length = np.linalg.norm(readings, axis=1)
    length = length[np.isfinite(length)]
    typical = float(np.median(length)) if len(length) else np.nan
    ratio = typical / magnitude
    if not np.isfinite(ratio) or 1 / FAR < ratio < FAR:
        return
    cure = "Convert counts by the sensitivity of the data sheet"
    for unit, per_si in units.items():
        if 1 / NEAR < ratio / per_si < NEAR:
            cure = f"That is {unit}: multiply the readings by {1 / per_si:.6g}"
        elif 1 / NEAR < ratio * per_si < NEAR:
            cure = f"The reference is in {unit}: multiply it by {1 / per_si:.6g}"
    raise UnusableLog(f"table: a typical reading of the {triad} is {typical:.3g} long, where "
                      f"{magnitude:.4g} {SI_UNIT[triad]} is expected. {cure}.")


def pose_means(columns: Columns, labels: Sequence[str], rate_rad_s: float) -> list[PoseMean]:
    """Mean of each pose: of its rows where several have its name, else as its row states it."""
    if len(set(labels)) < len(labels):
        return [_averaged(columns, label, np.array([one == label for one in labels]), rate_rad_s)
                for label in dict.fromkeys(labels)]
    for one in TRIADS:
        _require_stated(columns, one, labels)
    return tabled_poses(labels, columns, dict.fromkeys(TRIADS, SI))


def _averaged(columns: Columns, label: str, rows: Any, rate_rad_s: float) -> PoseMean:
    """Mean of the samples of one pose, its sds by their scatter and autocorrelation."""
    if TIME not in columns:
        raise UnusableLog(f"table: several rows are called {label}, so they are samples and need "
                          f"a column time_s. Or give every pose its own name.")
    part = {name: values[rows] for name, values in columns.items()}
    accelerometer, gyroscope = (
        np.column_stack([part.pop(name) for name in triad_columns(triad)])
        if triad_columns(triad)[0] in part else np.full((int(rows.sum()), 3), np.nan)
        for triad in TRIADS)
    log = ImuLog(label, part.pop(TIME), accelerometer, gyroscope, part)
    return average_pose(log, dict.fromkeys(TRIADS, SI), abs(rate_rad_s))


def _require_stated(columns: Columns, triad: Triad, labels: Sequence[str]) -> None:
    """Refuse means that are not numbers."""
    names = triad_columns(triad)
    if any(name not in columns for name in names):
        return
    missing = ~np.isfinite([columns[name] for name in names]).all(axis=0)
    if missing.any():
        raise UnusableLog(f"table: {' or '.join(names)} has no number in "
                          f"{labels[int(np.argmax(missing))]}. Leave that row out: "
                          f"table.dropna().")
