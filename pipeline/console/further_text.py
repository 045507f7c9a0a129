"""Further logs as rows: the attitude, the setting of the plate and the sd of each pose."""

from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np

from calib.poses.attitudes import direction_name
from calib.poses.averaging.pose_mean import PoseMean
from calib.poses.imu_log import TRIADS
from calib.rounding import two_digits
from pipeline.config.file_patterns import relative_name
from pipeline.config.types import STOPPED
from pipeline.further.logs import FurtherLog
from pipeline.further.text import Place
from pipeline.text.formatting import DISPLAY, count
from pipeline.text.tables import table_lines

HEAD = ("pose", "attitude", "plate", "sd", "duration")  #: names of the columns of a row


def further_rows(logs: Sequence[FurtherLog], folder: Path) -> Iterator[tuple[str, ...]]:
    """Name, attitude, setting of the plate, sds and duration of each pose, in texts."""
    for log in logs:
        name = relative_name(log.path, folder)
        for mean in log.means:
            part = mean.label.removeprefix(log.path.name)
            yield (f"{name}{part if log.is_long else ''}", _attitude(mean),
                   log.rate + (f", new, by {log.clip.path.name}" if log.clip else ""),
                   ", ".join(_sds(mean)), f"{mean.duration_s:.3g} s")


def further_lines(logs: Sequence[FurtherLog], places: Sequence[Place], folder: Path) -> list[str]:
    """The poses as a table, and the runs that they join."""
    return [*table_lines([list(HEAD), *map(list, further_rows(logs, folder))]),
            *(place_text(place, logs) for place in places)]


def place_text(place: Place, logs: Sequence[FurtherLog]) -> str:
    """The run that logs join, with their number of poses."""
    poses = sum(len(log.means) for log in logs if log.rate == place.rate)
    where = "at rest" if place.rate == STOPPED else f"at the setting {place.rate}"
    new = "" if place.section else ", as a run of its own"
    return f"{place.triad}: {count(poses, 'pose')} more {where}{new}"


def _attitude(mean: PoseMean) -> str:
    triad = "accelerometer" if np.isfinite(mean.accelerometer.mean).all() else "gyroscope"
    vector = mean.of(triad).mean
    return direction_name(vector / np.linalg.norm(vector), triad)


def _sds(mean: PoseMean) -> Iterator[str]:
    for triad in TRIADS:
        sd = float(np.sqrt(mean.of(triad).variance.mean()))
        if np.isfinite(sd):
            unit, factor = DISPLAY[triad]
            yield f"{two_digits(sd * factor)} {unit}"
