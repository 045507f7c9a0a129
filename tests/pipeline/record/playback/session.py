"""The poses of a configuration, ready to be played."""

import numpy as np

from calib.poses.data_sheet import TriadSpec
from calib.poses.imu_log import TEMPERATURE, TRIADS, ImuLog
from pipeline.config.load import Config
from pipeline.config.schema import PosesSection
from pipeline.config.sensor import sensor_specs
from pipeline.errors import ConfigError
from pipeline.stages.session_logs import read_logs
from tests.pipeline.record.playback.device import Pose

ROOM_C = 25.0  #: where the logs have no temperature


def played_poses(config: Config) -> tuple[list[Pose], float]:
    """All poses in the order of the file, those at rest first, and their sample rate in Hz.

    Raises
    ------
    ConfigError
        The configuration names no files of poses, or they lack a triad.
    UnreadableInput
        A log cannot be read.
    """
    named: list[PosesSection] = []
    named += [run.poses for run in config.accelerometer.sections] if config.accelerometer else []
    named += [run.poses for run in config.gyroscope.runs] if config.gyroscope else []
    folder = config.source.path.parent
    logs = {log.label: log for poses in dict.fromkeys(named)
            for log in read_logs(poses, poses.files, folder)}
    if not logs:
        raise ConfigError(f"{config.source.path}: names no files of poses that could be played.")
    if not all(log.has("accelerometer") and log.has("gyroscope") for log in logs.values()):
        raise ConfigError(f"{config.source.path}: poses to be played need both triads.")
    poses = [_pose(log) for log in logs.values()]
    rate_hz = 1 / float(np.median(np.diff(next(iter(logs.values())).time_s)))
    return poses, rate_hz


def _pose(log: ImuLog) -> Pose:
    temperature_c = log.columns.get(TEMPERATURE, np.full(len(log.time_s), ROOM_C))
    return Pose(log.label, np.hstack([log.accelerometer, log.gyroscope]), temperature_c)


def both_specs(config: Config) -> tuple[TriadSpec, TriadSpec]:
    """Data sheets of both triads.

    Raises
    ------
    ConfigError
        One of them is missing.
    """
    specs = sensor_specs(config.sensor)
    if len(specs) < len(TRIADS):
        raise ConfigError(config.source.problem(("sensor",), (
            "poses to be played need the data sheets of both triads.")))
    return specs["accelerometer"], specs["gyroscope"]
