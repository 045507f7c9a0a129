"""Logs in, pose means out: every set of poses that the configuration names, each read once."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from calib.errors import Undetermined
from calib.poses.averaging import PoseMean, average_pose
from calib.poses.imu_log import ImuLog
from calib.poses.static_intervals import find_still
from pipeline.config.load import Config, Specs, sensor_specs
from pipeline.config.schema import PosesSection
from pipeline.config.types import STOPPED
from pipeline.logs.read import join_logs
from pipeline.stages.rate import SettingRate
from pipeline.stages.session_logs import read_logs


@dataclass(frozen=True)
class Setting:
    """Which poses, at which plate rate; what a recording is found by."""

    poses: PosesSection
    rate: str


@dataclass(frozen=True, eq=False)
class Recording:
    """The averaged poses of one setting.

    ``start_s`` is when its first log begins; ``warnings`` say which found poses were left out.
    """

    means: tuple[PoseMean, ...]
    start_s: float
    warnings: tuple[str, ...] = ()


@dataclass(frozen=True, eq=False)
class Recordings:
    """All poses of a session, averaged."""

    by_setting: Mapping[Setting, Recording]

    def of(self, poses: PosesSection, rate: str = STOPPED) -> Recording:
        """The recording of these poses at this rate."""
        return self.by_setting[Setting(poses, rate)]

    @property
    def origin_s(self) -> float:
        """When the session began: the earliest sample of all logs."""
        return min(recording.start_s for recording in self.by_setting.values())

    @property
    def warnings(self) -> tuple[str, ...]:
        """Those of all recordings."""
        return tuple(w for recording in self.by_setting.values() for w in recording.warnings)


def average_recordings(config: Config, rates: Mapping[str, SettingRate]) -> Recordings:
    """Read and average the poses of both triads; poses that serve both are read once.

    Raises
    ------
    UnreadableInput, UnusableLog
        A log cannot be read, or holds what this sensor cannot give.
    Undetermined
        A pose that was named is no pose: it moved, is saturated or too short.
    """
    settings = [Setting(config.accelerometer.poses, STOPPED)] if config.accelerometer else []
    if config.gyroscope:
        settings += [Setting(run.poses, run.rate) for run in config.gyroscope.runs]
    specs = sensor_specs(config.sensor)
    folder = config.source.path.parent
    return Recordings(
        {
            setting: _record(setting, specs, rates.get(setting.rate), folder)
            for setting in dict.fromkeys(settings)
        }
    )


def _record(
    setting: Setting,
    specs: Specs,
    rate: SettingRate | None,
    folder: Path,
) -> Recording:
    poses = setting.poses
    plate = np.zeros(1) if rate is None else rate.plate.rate_rad_s
    if poses.log:
        return _found(join_logs(read_logs(poses, poses.log, folder)), specs, float(plate.mean()))
    logs = read_logs(poses, poses.files, folder)
    turning = np.broadcast_to(plate, len(logs))
    means = [average_pose(log, *specs, float(w)) for log, w in zip(logs, turning, strict=True)]
    return Recording(tuple(means), min(float(log.time_s[0]) for log in logs))


def _found(
    log: ImuLog, specs: Specs, rate_rad_s: float
) -> Recording:
    """The still poses of a long log; one that turns out to have moved is left out and named."""
    means: list[PoseMean] = []
    refused: list[Undetermined] = []
    for pose in find_still(log):
        try:
            means.append(average_pose(pose, *specs, rate_rad_s))
        except Undetermined as error:
            refused.append(error)
    if not means:
        raise refused[0]
    warnings = tuple(f"Left out: {error}" for error in refused)
    return Recording(tuple(means), float(log.time_s[0]), warnings)
