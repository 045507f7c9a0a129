"""The mounting stage: the logs of the mounted sensor to its mounting angles."""

import os
from dataclasses import replace
from pathlib import Path

from calib.mounting.mounting import Installation, measure_installation
from calib.poses.data_sheet import TriadSpec
from calib.poses.imu_log import ImuLog
from calib.poses.static_intervals import find_still
from pipeline.config.load import Config
from pipeline.config.schema import Installation as InstallationSection
from pipeline.logs.read import read_log
from pipeline.stages.context import Workplace
from pipeline.stages.poses import still_search
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
    spec = accelerometer.calibration.spec
    return measure_installation(
        _still_logs(section, section.log, folder, spec),
        accelerometer.calibration,
        accelerometer.gravity.value_m_s2,
        accelerometer.gravity.sd_m_s2,
        reverse=_still_logs(section, section.reverse_log, folder, spec),
        drive=[_read(section, path, i, folder) for i, path in enumerate(section.drive_log)],
        first_push=section.drive_direction,
    )


def _still_logs(
    section: InstallationSection, paths: tuple[Path, ...], folder: Path, spec: TriadSpec
) -> list[ImuLog]:
    logs = [_read(section, path, i, folder) for i, path in enumerate(paths)]
    if section.find == "still":
        return [part for log in logs
                for part in find_still(log, spec, search=still_search(section.still)).logs]
    return logs


def _read(section: InstallationSection, path: Path, i: int, folder: Path) -> ImuLog:
    columns = None
    if section.columns is not None:
        columns = section.columns[i] if i < len(section.columns) else section.columns[-1]
    log = read_log(path, columns, section.sample_rate_hz)
    return replace(log, label=Path(os.path.relpath(path, folder)).as_posix())


