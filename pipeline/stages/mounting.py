"""The mounting stage: from the logs of the mounted sensor to its mounting angles."""

from pathlib import Path

from calib.consistency.repeats import require_no_copies
from calib.fit.triad.calibration import TriadCalibration
from calib.mounting.mounting import Mounting, MountingLogs, mounting_from_logs
from calib.mounting.still_reading import require_at_rest
from calib.poses.data_sheet import Specs
from calib.poses.imu_log import FloatArray, ImuLog
from calib.poses.rests.static_intervals import find_still
from pipeline.config.load import Config
from pipeline.config.schema import InstallationSection
from pipeline.config.sensor import sensor_specs
from pipeline.stages.pose_means import rest_reading
from pipeline.stages.poses import still_search
from pipeline.stages.recordings import Recordings
from pipeline.stages.references import Gravity
from pipeline.stages.session_logs import read_logs


def measure_mounting(
    config: Config,
    accelerometer: TriadCalibration | None,
    gravity: Gravity | None,
    at_rest: FloatArray | None = None,
) -> Mounting | None:
    """Measure the mounting from the logs of the section ``installation``.

    ``gravity`` is the reference of the accelerometer's calibration, ``at_rest`` (3,) the
    gyroscope's reading at rest, see :func:`reading_at_rest`.

    Returns
    -------
    Mounting or None
        None where the configuration has no such section.

    Raises
    ------
    UnreadableInput, UnusableLog
        A log cannot be read, or holds what this sensor cannot give.
    Undetermined
        The sensor was turning; or see :func:`calib.mounting.mounting.mounting_from_logs`.
    """
    section = config.installation
    if section is None:
        return None
    # The configuration's rules refuse an installation without an accelerometer, and that without
    # a site.
    assert accelerometer is not None
    assert gravity is not None
    folder, specs = config.source.path.parent, sensor_specs(config.sensor)
    logs = MountingLogs(
        still=_still_logs(section, section.log, folder, specs),
        reverse=_still_logs(section, section.reverse_log, folder, specs),
        drive=read_logs(section, section.drive_log, folder, specs),
        first_push=section.drive_direction,
    )
    still = [*logs.still, *logs.reverse]
    require_no_copies(still, "accelerometer")
    gyroscope = specs.get("gyroscope")
    if gyroscope is not None:
        require_at_rest(still, gyroscope, at_rest)
    return mounting_from_logs(logs, accelerometer, gravity.value_m_s2, gravity.sd_m_s2,
                              section.order)


def reading_at_rest(config: Config, recordings: Recordings) -> FloatArray | None:
    """Mean gyroscope reading in the accelerometer's poses, SI, (3,); None where not logged."""
    poses = config.accelerometer.at_rest if config.accelerometer else ()
    return rest_reading(recordings.of(poses[0]).means) if poses else None


def _still_logs(
    section: InstallationSection, paths: tuple[Path, ...], folder: Path, specs: Specs
) -> list[ImuLog]:
    logs = read_logs(section, paths, folder, specs)
    if section.find == "still":
        force, search = {"accelerometer": specs["accelerometer"]}, still_search(section.still)
        return [part for log in logs for part in find_still(log, force, search=search).logs]
    return logs
