"""The poses of a configuration, ready to be played."""

import numpy as np

from calib.poses.data_sheet import TriadSpec
from calib.poses.imu_log import ImuLog
from pipeline.config.load import Config, triad_spec
from pipeline.config.schema import PosesSection
from pipeline.errors import ConfigError
from pipeline.logs.read import read_log
from pipeline.playback.device import Pose

TEMPERATURE = "temperature_c"
ROOM_C = 25.0  #: where the logs have no temperature


def played_poses(config: Config) -> tuple[list[Pose], float]:
    """All poses in the order of the file, those at rest first, and their sample rate.

    Raises
    ------
    ConfigError
        The configuration names no files of poses, or they lack a triad.
    """
    named: list[PosesSection] = [config.accelerometer.poses] if config.accelerometer else []
    named += [run.poses for run in config.gyroscope.runs] if config.gyroscope else []
    paths = list(dict.fromkeys((path, poses.columns_of(i), poses.sample_rate_hz)
                               for poses in named for i, path in enumerate(poses.files)))
    if not paths:
        raise ConfigError(f"{config.source.path}: names no files of poses that could be played.")
    logs = [read_log(*each) for each in paths]
    if not all(log.has("accelerometer") and log.has("gyroscope") for log in logs):
        raise ConfigError(f"{config.source.path}: poses to be played need both triads.")
    rate_hz = 1 / float(np.median(np.diff(logs[0].time_s)))
    return [_pose(log) for log in logs], rate_hz


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
    sensor = config.sensor
    if sensor.accelerometer is None or sensor.gyroscope is None:
        raise ConfigError(config.source.problem(("sensor",), (
            "poses to be played need the data sheets of both triads.")))
    return triad_spec(sensor.accelerometer), triad_spec(sensor.gyroscope)
