"""The logs that a section of the configuration names, each under its path from that file."""

import os
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from calib.poses.imu_log import ImuLog
from pipeline.config.schema import LogsSection
from pipeline.logs.clock import StatedClock
from pipeline.logs.read import read_log


def read_logs(
    section: LogsSection, paths: Sequence[Path], folder: Path, *, clock_needed: bool = True
) -> list[ImuLog]:
    """Read files of a section with its columns and clock.

    Parameters
    ----------
    section : LogsSection
        States ``columns``, ``sample_rate_hz`` and ``time_unit``.
    paths : sequence of Path
        One of the section's lists of files, whole and in its order.
    folder : Path
        The configuration's; logs are labelled by their path from it.
    clock_needed : bool
        False for poses at rest, one file each: their means need no times.

    Raises
    ------
    UnreadableInput
        A file is missing, or is not a log with these columns.
    """
    return [
        replace(
            read_log(path, section.columns_of(i),
                     StatedClock(section.sample_rate_hz, section.time_unit, clock_needed)),
            label=_shown_name(os.path.relpath(path, folder)),
        )
        for i, path in enumerate(paths)
    ]


def _shown_name(path: str) -> str:
    """With slashes; bytes that are no text are written out, since a label stands in files."""
    text = os.fsencode(path).decode(errors="backslashreplace")
    return text.replace(os.sep, "/")
