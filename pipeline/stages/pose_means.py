"""A table of pose means: one row per pose, with or without sds."""

from pathlib import Path

import numpy as np

from calib.poses.averaging.pose_mean import PoseMean, is_stated, tabled_poses
from calib.poses.data_sheet import Specs
from pipeline.config.schema import PosesSection
from pipeline.errors import UnreadableInput
from pipeline.logs.clock import unwrapped_ticks
from pipeline.logs.columns import ACCELEROMETER, COUNTER, GYROSCOPE, SECONDS_PER, TIME
from pipeline.logs.read import LogTable, read_tables


def read_pose_means(section: PosesSection, folder: Path, specs: Specs) -> list[PoseMean]:
    """The rows of the tables of a section as averaged poses, in nominal SI units.

    Raises
    ------
    UnreadableInput
        A table cannot be read, or an sd or a number of samples is not positive.
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
        {name: column for name, column in values.items() if name != COUNTER},
        specs)


def _require_numbers(table: LogTable) -> None:
    for name, column in table.values.items():
        reading = name in (*ACCELEROMETER, *GYROSCOPE)
        positive = is_stated(name)
        wrong = (~np.isfinite(column) if reading else
                 ~(np.isfinite(column) & (column > 0)) if positive else np.zeros(len(column), bool))
        if wrong.any():
            row = int(np.flatnonzero(wrong)[0])
            wanted = "a finite number" if reading else "a positive number"
            raise UnreadableInput(f"{table.place(row)}: column {name}: found {column[row]:g}, "
                                  f"{wanted} is expected.")
