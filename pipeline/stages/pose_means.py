"""A table of pose means, and properties of a pose before calibration."""

import math
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from calib.poses.attitudes import WEDGE_DIRECTIONS, natural_directions
from calib.poses.averaging.pose_mean import PoseMean, is_stated, tabled_poses
from calib.poses.data_sheet import Specs, TriadSpec
from calib.poses.imu_log import FloatArray, ImuLog
from pipeline.config.record_section import SECONDS_PER_POSE, RecordSection
from pipeline.config.schema import PosesSection
from pipeline.errors import UnreadableInput
from pipeline.logs.clock import unwrapped_ticks
from pipeline.logs.columns import ACCELEROMETER, COUNTER, GYROSCOPE, SECONDS_PER, TIME
from pipeline.logs.read import LogTable, read_tables

LABEL = "label"  #: column of a table that names its rows: nothing that a sensor answers to


def read_pose_means(section: PosesSection, folder: Path, specs: Specs) -> list[PoseMean]:
    """The rows of the tables of a section as averaged poses, in nominal SI units.

    Raises
    ------
    UnreadableInput
        A table cannot be read, or an sd or a number of samples is not positive.
    UnusableLog
        A mean that no sensor reads.
    """
    return [mean for i, path in enumerate(section.means)
            for table in read_tables(path, section.columns_of(i))
            for mean in _means(table, path, section, folder, specs)]


def _means(
    table: LogTable, path: Path, section: PosesSection, folder: Path, specs: Specs
) -> list[PoseMean]:
    values = table.values
    _require_numbers(table)
    rows = len(next(iter(values.values())))
    factor = SECONDS_PER[section.time_unit] if section.time_unit else table.time_factor
    if TIME in values:
        values = {**values, TIME: unwrapped_ticks(values[TIME]) * factor}
    label = path.relative_to(folder) if path.is_relative_to(folder) else path
    return tabled_poses(
        [f"{label.as_posix()} row {row + 1}" for row in range(rows)],
        {name: column for name, column in values.items() if name not in (COUNTER, LABEL)},
        specs)


def _require_numbers(table: LogTable) -> None:
    for name, column in table.values.items():
        positive = is_stated(name)
        if not positive and name not in (*ACCELEROMETER, *GYROSCOPE):
            continue
        wrong = ~(np.isfinite(column) & ((column > 0) if positive else True))
        if wrong.any():
            row = int(np.argmax(wrong))
            wanted = "a positive number" if positive else "a finite number"
            raise UnreadableInput(f"{table.place(row)}: column {name}: found {column[row]:g}, "
                                  f"{wanted} is expected.")


FEWEST_TURNS = 3.0  #: turns of the plate in a pose: over whole turns its tilt averages out; chosen


def first_directions(count: int) -> FloatArray:
    """The first natural directions that are to face up, unit vectors, (count, 3).

    If only some of the edges are needed, those in different planes come first: three of them show
    all misalignments.
    """
    natural = natural_directions()
    is_edge = (natural != 0).sum(axis=1) == 2
    edges = natural[is_edge]
    plane = np.abs(edges).argmin(axis=1)
    turn = [int((plane[:i] == plane[i]).sum()) for i in range(len(edges))]  # which of its plane
    if count < WEDGE_DIRECTIONS:
        natural[is_edge] = edges[np.lexsort((plane, turn))]
    return natural[:count]


def pose_seconds(record: RecordSection | None, rate_rad_s: float | None) -> float:
    """Duration of a pose, s: as ``record`` states, and for ``FEWEST_TURNS`` of the plate.

    Parameters
    ----------
    record : RecordSection or None
        The usual length counts where the configuration has no such section.
    rate_rad_s : float or None
        Of the plate; 0 at rest, None where it is not known.
    """
    seconds = SECONDS_PER_POSE if record is None else record.seconds_per_pose
    return max(seconds, FEWEST_TURNS * 2 * math.pi / rate_rad_s) if rate_rad_s else seconds


def rest_reading(means: Sequence[PoseMean]) -> FloatArray | None:
    """The gyroscope's reading at rest, (3,), nominal rad/s; None where no pose at rest logged
    it."""
    rate = np.array([mean.gyroscope.mean for mean in means])
    return np.asarray(np.median(rate, axis=0)) if rate.size and np.isfinite(rate).all() else None


def less_rest(reading: FloatArray, rest: FloatArray | None) -> FloatArray:
    """A gyroscope's reading (3,) less its reading at rest (3,), rad/s; unchanged without that."""
    return reading if rest is None else reading - rest


def sensed_rate(log: ImuLog, gyroscope: TriadSpec | None, rest: FloatArray | None) -> float:
    """The plate's rate as the gyroscope reads it in a log, rad/s; NaN where it was not logged.

    Parameters
    ----------
    log : ImuLog
    gyroscope : TriadSpec or None
        Its data sheet.
    rest : array, shape (3,), or None
        Its reading at rest, rad/s, where that is known.
    """
    if gyroscope is None or not log.has("gyroscope"):
        return math.nan
    return float(np.linalg.norm(less_rest(gyroscope.nominal(log.gyroscope).mean(axis=0), rest)))
