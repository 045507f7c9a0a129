"""Log files in, :class:`calib.poses.imu_log.ImuLog` out.

NumPy's C parser reads the rows. Only where it fails, or finds something that cannot be, the file is
read again line by line to say exactly where.
"""

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from calib.poses.imu_log import FloatArray, ImuLog
from pipeline.errors import UnreadableInput
from pipeline.logs.columns import ACCELEROMETER, COUNTER, GYROSCOPE, SKIP, TIME
from pipeline.logs.text import LogText, is_number, read_head, read_text

COUNTER_PERIOD = 65536  #: the Xsens packet counter has 16 bits; others never jump that far
#: A pause of the second log longer than this many of its usual steps is not interpolated over.
LONGEST_GAP_STEPS = 10


def read_log(
    path: Path, columns: Sequence[str] | None = None, sample_rate_hz: float | None = None
) -> ImuLog:
    """Read one log file.

    Parameters
    ----------
    path : Path
        Text, compressed with gzip or not; columns separated by commas, semicolons, tabs or
        blanks; lines that begin with ``#``, ``//`` or ``%`` before the rows are comments.
    columns : sequence of str, optional
        Names of all columns in their order, for files without a header; they replace a header.
        ``skip`` is a column not to be read.
    sample_rate_hz : float, optional
        For files without ``time_s``; a ``counter`` column then shows lost samples.

    Returns
    -------
    ImuLog
        Every numeric column of the file; a triad that is not there is NaN.

    Raises
    ------
    UnreadableInput
        With file, line, column, what was found, what was expected, what to do.
    """
    text = read_head(path, read_text(path), columns)
    table = _numbers(text)
    values = {name: column * factor
              for name, column, factor in zip(text.names, table.T, text.factors, strict=True)
              if name != SKIP}
    _require_finite(text, values)
    time_s = _time(text, values, sample_rate_hz)
    absent = np.full((len(time_s), 3), np.nan)
    triads = {triad: np.column_stack([values.pop(name) for name in triad])
              if triad[0] in values else absent for triad in (ACCELEROMETER, GYROSCOPE)}
    values.pop(TIME, None)
    return ImuLog(path.name, time_s, triads[ACCELEROMETER], triads[GYROSCOPE], values)


def join_logs(logs: Sequence[ImuLog]) -> ImuLog:
    """One log from separate accelerometer and gyroscope logs of the same stretch of time.

    Where the time stamps agree the readings are put side by side. Otherwise those of the later
    logs are interpolated linearly at the first one's times; samples of the first log that lie
    outside the other, or in a pause of it, are left out.

    Raises
    ------
    UnreadableInput
        Two logs hold the same triad, or they share less than two samples of time.
    """
    joined = logs[0]
    for other in logs[1:]:
        joined = _joined(joined, other)
    return joined


def _joined(one: ImuLog, other: ImuLog) -> ImuLog:
    """``other``'s triad and columns at the times of ``one``."""
    label = f"{one.label} + {other.label}"
    for triad in ("accelerometer", "gyroscope"):
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
            return np.asarray(getattr(one, triad)[kept])
        return np.column_stack([moved(axis) for axis in getattr(other, triad).T])

    columns = {name: moved(values) for name, values in other.columns.items()}
    columns |= {name: values[kept] for name, values in one.columns.items()}
    return ImuLog(label, time_s, side_by_side("accelerometer"), side_by_side("gyroscope"), columns)


def _covered(time_s: FloatArray, other_s: FloatArray) -> np.ndarray:
    """Which of ``time_s`` (t,) lie within ``other_s`` and not in a pause of it."""
    step = np.diff(other_s)
    after = np.clip(np.searchsorted(other_s, time_s, side="left"), 1, len(step))
    in_pause = (step > LONGEST_GAP_STEPS * np.median(step))[after - 1]
    touching = np.isin(time_s, other_s)
    return np.asarray((time_s >= other_s[0]) & (time_s <= other_s[-1]) & (touching | ~in_pause))


def _numbers(text: LogText) -> FloatArray:
    """The rows as an array (t, columns); skipped columns are NaN."""
    wanted = [i for i, name in enumerate(text.names) if name != SKIP]
    all_wanted = len(wanted) == len(text.names)
    rows = text.lines[text.first :]
    try:
        # With usecols NumPy no longer minds ragged rows: these are counted here.
        if not all_wanted and any(len(cells) != len(text.names) for _, cells in text.rows()):
            raise ValueError("ragged rows")
        table = np.loadtxt(rows, delimiter=text.delimiter, ndmin=2,
                           usecols=None if all_wanted else wanted)
        if table.shape[1] != len(wanted):
            raise ValueError("ragged rows")
    except ValueError as error:
        raise UnreadableInput(_first_fault(text) or f"{text.path}: {error}") from error
    if all_wanted:
        return table
    full = np.full((len(table), len(text.names)), np.nan)
    full[:, wanted] = table
    return full


def _first_fault(text: LogText) -> str | None:
    """The first row that is too short, too long, or holds what is no number; in words."""
    numbered = list(text.rows())
    for line, cells in numbered:
        if len(cells) != len(text.names):
            cut = (" The file seems cut off in its last line; delete that line."
                   if line == numbered[-1][0] and len(cells) < len(text.names)
                   else " Delete the damaged line, or record the log again.")
            return (f"{text.path}:{line}: {len(cells)} values found, {len(text.names)} expected "
                    f"({', '.join(text.names)}).{cut}")
        for name, cell in zip(text.names, cells, strict=True):
            if name != SKIP and not is_number(cell):
                shown = f"'{cell}'" if cell else "nothing"
                todo = ("Write decimal points for the decimal commas"
                        if is_number(cell.replace(",", "."))
                        else "Delete the damaged line, or record the log again")
                return (f"{text.path}:{line}: column {name}: found {shown}, a number is expected. "
                        f"{todo}.")
    return None


def _line_of(text: LogText, row: int) -> int:
    """The line in the file, from 1, of a row of the table."""
    return next(line for i, (line, _) in enumerate(text.rows()) if i == row)


def _require_finite(text: LogText, values: dict[str, FloatArray]) -> None:
    """Time and readings must be numbers; further columns may be NaN, as absent telemetry is."""
    for name in (TIME, COUNTER, *ACCELEROMETER, *GYROSCOPE):
        if name in values and not np.isfinite(values[name]).all():
            row = int(np.flatnonzero(~np.isfinite(values[name]))[0])
            raise UnreadableInput(
                f"{text.path}:{_line_of(text, row)}: column {name}: found {values[name][row]}, a "
                "finite number is expected. Delete the damaged lines, or record the log again."
            )


def _time(
    text: LogText, values: dict[str, FloatArray], sample_rate_hz: float | None
) -> FloatArray:
    """Sample times in seconds, shape (t,), from their column or from the sample rate."""
    if TIME in values and sample_rate_hz is not None:
        raise UnreadableInput(f"{text.path}: the log has {TIME}, and sample_rate_hz is given as "
                              "well. Delete sample_rate_hz from the configuration.")
    if TIME in values:
        time_s = values[TIME]
    else:
        rate_hz = sample_rate_hz or text.rate_hz
        if rate_hz is None:
            raise UnreadableInput(
                f"{text.path}: there is no column {TIME} (columns: {', '.join(text.names)}), and "
                "no sample rate is known. Add or rename the column, or give sample_rate_hz beside "
                "the file in the configuration."
            )
        if COUNTER in values:
            lost_or_next = np.diff(values[COUNTER]) % COUNTER_PERIOD
            time_s = np.concatenate([[0.0], np.cumsum(lost_or_next)]) / rate_hz
        else:
            time_s = np.arange(len(next(iter(values.values())))) / rate_hz
    backwards = np.flatnonzero(np.diff(time_s) <= 0)
    if backwards.size:
        row = int(backwards[0]) + 1
        raise UnreadableInput(
            f"{text.path}:{_line_of(text, row)}: time does not increase: {time_s[row]:.9g} s after "
            f"{time_s[row - 1]:.9g} s. Delete repeated or misplaced lines, or record the log again."
        )
    return time_s
