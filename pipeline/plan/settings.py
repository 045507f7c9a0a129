"""The poses of one plate setting: recorded and missing ones, and the rate."""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

import numpy as np

from calib.errors import CalibrationError
from calib.numbers import RPM
from calib.poses.attitudes import WEDGE_DIRECTIONS, uncovered
from calib.poses.averaging.average_pose import average_pose
from calib.poses.averaging.pose_mean import PoseMean
from calib.poses.imu_log import FloatArray, ImuLog
from calib.poses.rests.static_intervals import find_still
from calib.poses.runs.ideal_ring import ADVISED_TILT_RAD
from calib.poses.runs.ring import is_leaning, tilt_of_run
from pipeline.config.load import Config
from pipeline.config.schema import (
    KnownRateSection,
    PosesSection,
    RunSection,
    VideoRateSection,
)
from pipeline.config.sensor import SensorSection, sensor_specs
from pipeline.logs.formats.kinds import split_member
from pipeline.stages.excluded_poses import chosen
from pipeline.stages.pose_means import first_directions, pose_seconds, read_pose_means, sensed_rate
from pipeline.stages.poses import still_search
from pipeline.stages.session_logs import long_logs, read_logs
from pipeline.stages.triad_poses import attitude_sd_rad

USUAL_RATE_RAD_S = 100 / 3 * RPM  #: the speed that every record player has
PAUSE_S = 20.0  #: between two planned poses: as long as it takes to place the sensor; chosen


@dataclass(frozen=True, eq=False)
class PlannedSetting:
    """Poses of one setting, recorded and missing.

    ``rate_rad_s`` is 0 at rest, ``tilt_rad`` on a plate that should be level; ``unusable`` gives
    reasons for recorded poses that cannot be used.
    """

    name: str
    rate_rad_s: float
    relative_sd: float
    rate_sd_rad_s: float
    means: tuple[PoseMean, ...]
    missing: FloatArray
    seconds: float
    unusable: tuple[str, ...]
    tilt_rad: float = 0.0
    attitude_sd_rad: float | None = None


def planned_setting(config: Config, section: RunSection) -> PlannedSetting:
    """Read the recorded poses of one setting; each file once while it does not change."""
    poses, name = section.poses, section.rate
    rate, stated = 0.0, config.rate.get(name)
    relative, sd = 0.0, 0.0
    if isinstance(stated, KnownRateSection):
        rate, sd = abs(stated.rate_rad_s), stated.sd_rad_s
    elif isinstance(stated, VideoRateSection):
        rate = (stated.nominal_rpm or math.nan) * RPM
        relative = stated.timebase.relative_sd
    specs = sensor_specs(config.sensor)
    tabled = read_pose_means(poses, config.source.path.parent, specs) if poses.means else []
    means = [tabled[i] for i in chosen([mean.label for mean in tabled], section, config).kept]
    unusable = []
    usual = USUAL_RATE_RAD_S if math.isnan(rate) else rate
    logs = list(_logs(config, poses, usual))
    for log in (logs[i] for i in chosen([log.label for log in logs], section, config).kept):
        if math.isnan(rate):
            rate = sensed_rate(log, specs.get("gyroscope"), None)
        try:
            means.append(_mean(log, config.sensor, rate))
        except CalibrationError as error:
            unusable.append(str(error))
    if math.isnan(rate):
        rate = USUAL_RATE_RAD_S
    known = [mean.duration_s for mean in means if not mean.stated]
    seconds = float(np.median(known)) if known else pose_seconds(config.record, rate)
    return PlannedSetting(name, rate, relative, sd, tuple(means), _missing(config, means), seconds,
                          tuple(unusable), _tilt(config, section, means) if rate else 0.0,
                          attitude_sd_rad(section))


def _tilt(config: Config, section: RunSection, means: list[PoseMean]) -> float:
    """The tilt of the plate, rad: as recorded, else as advised where the accelerometer needs it."""
    if means:
        return (tilt_of_run(means) or 0.0) if is_leaning(means) else 0.0
    tilted = config.accelerometer.runs if config.accelerometer else ()
    return ADVISED_TILT_RAD * (section.recorded in [one.recorded for one in tilted])


def _logs(config: Config, poses: PosesSection, rate_rad_s: float) -> Iterator[ImuLog]:
    single = [poses.model_copy(update={"log": (), "files": (path,), "columns": names and (names,)})
              for i, path in enumerate(poses.files) for names in [poses.columns_of(i)]]
    for part in (poses.model_copy(update={"files": ()}), *single):
        files = [split_member(path)[0] for path in (*part.log, *part.files)]
        written = tuple(file.stat().st_mtime_ns for file in files if file.exists())
        yield from _logs_of(part, config.source.path.parent, config.sensor, rate_rad_s, written)


@lru_cache(maxsize=100)  # the outlook after each recorded pose needs all earlier ones
def _logs_of(poses: PosesSection, folder: Path, sensor: SensorSection, rate_rad_s: float,
             _written_ns: tuple[int, ...]) -> list[ImuLog]:
    specs = sensor_specs(sensor)
    stops = [stop for log in long_logs(poses, folder, specs) for stop in find_still(
        log, specs, rate_rad_s, still_search(poses.still)).logs]
    return [*stops, *read_logs(poses, poses.files, folder, specs, clock_needed=rate_rad_s != 0)]


@lru_cache(maxsize=100)
def _mean(log: ImuLog, sensor: SensorSection, rate_rad_s: float) -> PoseMean:
    return average_pose(log, sensor_specs(sensor), rate_rad_s)


def _missing(config: Config, means: list[PoseMean]) -> FloatArray:
    """Directions that ``record`` requires and no recorded pose covers, (n, 3).

    Without a ``record`` section nothing is missing once something is recorded.
    """
    count = config.record.poses if config.record else (0 if means else WEDGE_DIRECTIONS)
    wanted = first_directions(count)
    force = np.array([mean.accelerometer.mean for mean in means]).reshape(-1, 3)
    if not np.isfinite(force).all():  # no accelerometer shows which are covered
        return wanted[len(force) :]
    return uncovered(force, wanted)
