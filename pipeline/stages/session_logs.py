"""The logs that a section of the configuration names, each under its path from that file."""

import os
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from calib.poses.imu_log import ImuLog
from pipeline.config.schema import LogsSection
from pipeline.logs.read import read_log


def read_logs(section: LogsSection, paths: Sequence[Path], folder: Path) -> list[ImuLog]:
    """Read files of a section with its columns and sample rate.

    Parameters
    ----------
    section : LogsSection
        States ``columns`` and ``sample_rate_hz``.
    paths : sequence of Path
        One of the section's lists of files, whole and in its order.
    folder : Path
        The configuration's; logs are labelled by their path from it.

    Raises
    ------
    UnreadableInput
        A file is missing, or is not a log with these columns.
    """
    return [
        replace(
            read_log(path, section.columns_of(i), section.sample_rate_hz),
            label=Path(os.path.relpath(path, folder)).as_posix(),
        )
        for i, path in enumerate(paths)
    ]
