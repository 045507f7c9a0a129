"""A table of pose means: one row per pose, with or without sds."""

import math
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from calib.poses.averaging.pose_mean import NOT_LOGGED, PoseMean, TriadMean, stated_means
from calib.poses.data_sheet import TriadSpec
from calib.poses.imu_log import FloatArray
from pipeline.config.schema import PosesSection
from pipeline.config.sensor import Specs
from pipeline.errors import UnreadableInput
from pipeline.logs.clock import unwrapped_ticks
from pipeline.logs.columns import ACCELEROMETER, GYROSCOPE, READINGS, SECONDS_PER, TIME
from pipeline.logs.read import LogTable, read_tables

SAMPLES = "samples"  #: the column that makes the sds those of the samples
SD = "sd_"


def is_of_means(column: str) -> bool:
    """Whether a column of such a table says how well its means are known."""
    return column in (SAMPLES, *(SD + name for name in (*ACCELEROMETER, *GYROSCOPE)))


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
    triads = [_triad_means(values, names, spec, rows)
              for names, spec in zip((ACCELEROMETER, GYROSCOPE), specs, strict=True)]
    factor = SECONDS_PER[section.time_unit] if section.time_unit else table.time_factor
    time_s = (unwrapped_ticks(values[TIME]) * factor if TIME in values
              else np.full(rows, math.nan))
    label = path.relative_to(folder) if path.is_relative_to(folder) else path
    return [
        PoseMean(
            label=f"{label.as_posix()} row {row + 1}",
            accelerometer=triads[0][row],
            gyroscope=triads[1][row],
            time_s=float(time_s[row]),
            duration_s=0.0,
            columns={name: float(column[row]) for name, column in values.items()
                     if name not in READINGS and not is_of_means(name)},
            stated=True,
        )
        for row in range(rows)
    ]


def _triad_means(
    values: Mapping[str, FloatArray], names: tuple[str, ...], spec: TriadSpec | None, rows: int
) -> list[TriadMean]:
    if spec is None or names[0] not in values:
        return [NOT_LOGGED] * rows
    means = spec.nominal(np.column_stack([values[name] for name in names]))
    sd = (np.column_stack([values[SD + name] for name in names]) * spec.nominal_scale
          if SD + names[0] in values else np.full((rows, 3), np.nan))
    return stated_means(means, sd, values.get(SAMPLES))


def _require_numbers(table: LogTable) -> None:
    for name, column in table.values.items():
        reading = name in (*ACCELEROMETER, *GYROSCOPE)
        positive = name == SAMPLES or name.startswith(SD)
        wrong = (~np.isfinite(column) if reading else
                 ~(np.isfinite(column) & (column > 0)) if positive else np.zeros(len(column), bool))
        if wrong.any():
            row = int(np.flatnonzero(wrong)[0])
            wanted = "a finite number" if reading else "a positive number"
            raise UnreadableInput(f"{table.place(row)}: column {name}: found {column[row]:g}, "
                                  f"{wanted} is expected.")
