"""The installation stage: the logs of the mounted sensor to its mounting, and that as results."""

import math
import os
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

from calib.mounting.mounting import Installation, measure_installation
from calib.poses.imu_log import ImuLog
from calib.poses.static_intervals import find_still
from pipeline.config.load import Config
from pipeline.config.schema import Installation as InstallationSection
from pipeline.console.format import with_sd
from pipeline.logs.read import read_log
from pipeline.stages.context import Workplace
from pipeline.stages.triads import TriadResult


def measure_mounting(
    config: Config, _workplace: Workplace, accelerometer: TriadResult | None
) -> Installation | None:
    """Measure how the sensor is mounted; None where the file has no such section.

    Raises
    ------
    UnreadableInput, UnusableLog
        A log cannot be read, or holds what this sensor cannot give.
    Undetermined
        See :func:`calib.mounting.mounting.measure_installation`.
    """
    section = config.installation
    if section is None:
        return None
    # The configuration's rules refuse an installation without an accelerometer, and that without
    # a site.
    assert accelerometer is not None
    assert accelerometer.gravity is not None
    folder = config.source.path.parent
    return measure_installation(
        _still_logs(section, section.log, folder),
        accelerometer.calibration,
        accelerometer.gravity.value_m_s2,
        accelerometer.gravity.sd_m_s2,
        reverse=_still_logs(section, section.reverse_log, folder),
        drive=[_read(section, path, i, folder) for i, path in enumerate(section.drive_log)],
        first_push=section.drive_direction,
    )


def _still_logs(
    section: InstallationSection, paths: tuple[Path, ...], folder: Path
) -> list[ImuLog]:
    logs = [_read(section, path, i, folder) for i, path in enumerate(paths)]
    if section.find == "still":
        return [part for log in logs for part in find_still(log)]
    return logs


def _read(section: InstallationSection, path: Path, i: int, folder: Path) -> ImuLog:
    columns = None
    if section.columns is not None:
        columns = section.columns[i] if i < len(section.columns) else section.columns[-1]
    log = read_log(path, columns, section.sample_rate_hz)
    return replace(log, label=Path(os.path.relpath(path, folder)).as_posix())


def mounting_json(found: Installation) -> dict[str, Any]:
    """The section ``installation`` of results.json; null for what was not measured."""
    yaw, slope = found.yaw, found.slope
    return {
        "order": found.order,
        "roll_deg": math.degrees(found.roll_rad),
        "pitch_deg": math.degrees(found.pitch_rad),
        "sd_deg": [math.degrees(sd) for sd in found.sd_rad],
        "yaw_deg": math.degrees(yaw.yaw_rad) if yaw else None,
        "yaw_sd_deg": math.degrees(yaw.sd_rad) if yaw else None,
        "floor_rise_deg": [math.degrees(v) for v in slope.rise_rad] if slope else None,
        "floor_rise_sd_deg": [math.degrees(v) for v in slope.sd_rad] if slope else None,
        "rotation": found.rotation.tolist(),
        "before": found.before.tolist(),
        "after": found.after.tolist(),
        "magnitude_error_m_s2": found.magnitude_error_m_s2,
        "readings": found.samples,
        "notes": list(found.notes),
    }


def mounting_parts(found: Installation) -> Iterator[str]:
    """``roll 30.65 ± 0.01°`` and so on, what was measured."""
    roll_sd, pitch_sd = found.sd_rad
    yield f"roll {_degrees(found.roll_rad, roll_sd)}"
    yield f"pitch {_degrees(found.pitch_rad, pitch_sd)}"
    if found.yaw:
        yield f"yaw {_degrees(found.yaw.yaw_rad, found.yaw.sd_rad)}"
    if found.slope:
        for axis, rise, sd in zip("xy", found.slope.rise_rad, found.slope.sd_rad, strict=True):
            yield f"floor rises along {axis} by {_degrees(float(rise), float(sd))}"


def mounting_text(found: Installation) -> str:
    """One line for the terminal and the report."""
    return f"{', '.join(mounting_parts(found))} (order {found.order})"


def _degrees(angle_rad: float, sd_rad: float) -> str:
    return f"{with_sd(math.degrees(angle_rad), math.degrees(sd_rad))}°"
