"""The mounting stage: the logs of the mounted sensor to its mounting angles."""

from pathlib import Path

from calib.mounting.mounting import Mounting, MountingLogs, mounting_from_logs
from calib.poses.data_sheet import TriadSpec
from calib.poses.imu_log import ImuLog
from calib.poses.static_intervals import find_still
from pipeline.config.load import Config
from pipeline.config.schema import InstallationSection
from pipeline.stages.poses import still_search
from pipeline.stages.session_logs import read_logs
from pipeline.stages.triads import TriadResult


def measure_mounting(
    config: Config, accelerometer: TriadResult | None
) -> Mounting | None:
    """Measure the mounting from the logs of the section ``installation``.

    Returns
    -------
    Mounting or None
        None where the configuration has no such section.

    Raises
    ------
    UnreadableInput, UnusableLog
        A log cannot be read, or holds what this sensor cannot give.
    Undetermined
        See :func:`calib.mounting.mounting.mounting_from_logs`.
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
    logs = MountingLogs(
        still=_still_logs(section, section.log, folder, spec),
        reverse=_still_logs(section, section.reverse_log, folder, spec),
        drive=read_logs(section, section.drive_log, folder),
        first_push=section.drive_direction,
    )
    gravity = accelerometer.gravity
    return mounting_from_logs(
        logs, accelerometer.calibration, gravity.value_m_s2, gravity.sd_m_s2
    )


def _still_logs(
    section: InstallationSection, paths: tuple[Path, ...], folder: Path, spec: TriadSpec
) -> list[ImuLog]:
    logs = read_logs(section, paths, folder)
    if section.find == "still":
        return [part for log in logs
                for part in find_still(log, spec, search=still_search(section.still)).logs]
    return logs
