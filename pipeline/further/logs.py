"""Further logs for a session that exists: the poses and the setting of the plate in each.

A log is read as the session's own are, in their columns and on their data sheets. The calibration
of the session tells whether the plate turned in it, and at which of its settings.
"""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from calib.errors import CalibrationError
from calib.fit.triad.calibration import TriadCalibration
from calib.numbers import RPM
from calib.poses.averaging.average_pose import average_pose
from calib.poses.averaging.pose_mean import PoseMean
from calib.poses.data_sheet import Specs, signed_log
from calib.poses.imu_log import FloatArray, ImuLog, Triad
from calib.poses.rests.static_intervals import find_still
from calib.poses.runs.reference_runs import TURNING_RAD_S
from pipeline.config.load import Config
from pipeline.config.sensor import sensor_specs
from pipeline.config.session import named_files
from pipeline.config.types import STOPPED
from pipeline.config.yaml_text import PathTo
from pipeline.errors import ConfigError, UnreadableInput
from pipeline.guess.plate import MeasuredClip, matching_clip, nominal_rpm
from pipeline.guess.speeds import NEAR_CLIP
from pipeline.logs.clock import StatedClock
from pipeline.logs.read import read_log
from pipeline.logs.source import require_uncorrected
from pipeline.stages.rate import SettingRate
from pipeline.stages.recordings import Recordings
from pipeline.stages.session_logs import measured_samples

AS_READ = ("columns", "sample_rate_hz", "time_unit")  #: keys by which a log is read


@dataclass(frozen=True, eq=False)
class Known:
    """What a session tells of further logs.

    ``calibrations`` are those of its triads, ``rates`` the signed rates of its settings in rad/s,
    ``at_rest`` the nominal reading (3,) of its gyroscope in poses at rest, SI.
    """

    calibrations: Mapping[Triad, TriadCalibration]
    rates: Mapping[str, float]
    at_rest: FloatArray

    @classmethod
    def of(
        cls, config: Config, calibrations: Mapping[Triad, TriadCalibration],
        rates: Mapping[str, SettingRate], recordings: Recordings,
    ) -> "Known":
        """The knowledge of a session that was averaged, and calibrated as far as it can be.

        A rate that was stated may lack its direction: the poses of its setting tell it.
        """
        signed = {name: rate.signed_rad_s for name, rate in rates.items()}
        for _, run in config.placed_runs():
            along = [float(mean.gyroscope.mean @ mean.accelerometer.mean)
                     for mean in recordings.of(run).means] if run.rate in signed else []
            if np.isfinite(along).any():
                signed[run.rate] = math.copysign(signed[run.rate], float(np.nanmedian(along)))
        still = [mean.gyroscope.mean for _, run in config.placed_runs() if run.rate == STOPPED
                 for mean in recordings.of(run).means if np.isfinite(mean.gyroscope.mean).all()]
        return cls(calibrations, signed,
                   np.median(still, axis=0) if still else np.zeros(3))


@dataclass(frozen=True, eq=False)
class FurtherLog:
    """A log with the poses in it: one, or the stops of a long one.

    ``rate`` names the setting of the plate, ``stopped`` at rest; ``clip`` is the clip that shows a
    new one. ``read_as`` are the keys of the section whose columns and clock it has.
    """

    path: Path
    rate: str
    means: tuple[PoseMean, ...]
    is_long: bool
    read_as: PathTo
    clip: MeasuredClip | None = None


def further_logs(
    config: Config, known: Known, paths: Sequence[Path], clips: Sequence[MeasuredClip] = ()
) -> list[FurtherLog]:
    """The logs ``paths``, each with its poses and its setting of the plate.

    Parameters
    ----------
    config : Config
    known : Known
    paths : sequence of Path
    clips : sequence of MeasuredClip
        New clips; each becomes a setting.

    Raises
    ------
    ConfigError, UnreadableInput, CalibrationError
        A log is in the session already, is none of this sensor, or turns at a rate that nothing
        states.
    """
    there = {path.resolve() for path in named_files(config)}
    for path in paths:
        require_uncorrected(path)
        if path.resolve() in there:
            raise ConfigError(f"{path}: is in {config.source.path} already. `pipeline run` uses "
                              f"it.")
    return [_further_log(config, known, path, clips) for path in paths]


def _further_log(
    config: Config, known: Known, path: Path, clips: Sequence[MeasuredClip]
) -> FurtherLog:
    specs = sensor_specs(config.sensor)
    log, read_as = _read(config, path)
    log = signed_log(log, specs)
    turns = _signed_rate(log, specs, known)
    log, _ = measured_samples(log, bool(turns), specs)
    rate, clip = STOPPED, None
    if turns:
        rate, clip = _setting(turns, known.rates, clips)
        if not rate:
            there = ", ".join(f"{name} {each / RPM:+.4g} rpm" for name, each in known.rates.items())
            raise ConfigError(
                f"{path.name}: the plate turns at {turns / RPM:+.4g} rpm in it, and no setting of "
                f"this session does ({there or 'none is stated'}). Bring the clip of it too, or "
                f"state its rate under `rate:` in {config.source.path}.")
        turns = known.rates[rate] if clip is None else clip.rate_rad_s
    means, is_long = _poses_in(log, specs, turns)
    return FurtherLog(path, rate, means, is_long, read_as, clip)


def _read(config: Config, path: Path) -> tuple[ImuLog, PathTo]:
    """A log in the columns of the first section that it fits, and the keys of that section."""
    refusal: UnreadableInput | None = None
    tried: list[tuple[Any, ...]] = []
    for keys, section in config.placed_runs():
        stated = tuple(getattr(section.poses, name) for name in AS_READ)
        if section.poses.means or stated in tried:
            continue
        tried.append(stated)
        try:
            clock = StatedClock(section.poses.sample_rate_hz, section.poses.time_unit)
            return read_log(path, section.poses.columns_of(0), clock), (*keys, "poses")
        except UnreadableInput as error:
            refusal = refusal or error
    if refusal is None:
        raise ConfigError(f"{config.source.path}: its poses are tables of means, and a log cannot "
                          f"join them. Add its row to the table.")
    raise refusal


def _signed_rate(log: ImuLog, specs: Specs, known: Known) -> float:
    """Rate of the plate in a log, rad/s, negative clockwise; 0 at rest."""
    rate = _corrected(log, "gyroscope", specs, known)
    speed = 0.0 if rate is None else float(np.median(np.linalg.norm(rate, axis=1)))
    if rate is None or speed < TURNING_RAD_S:
        return 0.0
    force = _corrected(log, "accelerometer", specs, known)
    along = 1.0 if force is None else float(np.median((rate * force).sum(axis=1)))
    return math.copysign(speed, along)


def _corrected(
    log: ImuLog, triad: Triad, specs: Specs, known: Known
) -> FloatArray | None:
    """The readings (t, 3), SI, without bias, scale and misalignment where these are known."""
    if triad not in specs or not log.has(triad):
        return None
    readings = specs[triad].nominal(log.readings(triad))
    if triad not in known.calibrations:
        return np.asarray(readings - known.at_rest if triad == "gyroscope" else readings)
    matrix, offset = known.calibrations[triad].correction.linear_form()
    return np.asarray(readings @ matrix.T + offset)


def _setting(
    turns: float, rates: Mapping[str, float], clips: Sequence[MeasuredClip]
) -> tuple[str, MeasuredClip | None]:
    """Name of the setting of this rate, rad/s, by the new clips first; empty if there is none."""
    if (clip := matching_clip(turns, clips)) is not None:
        rpm = nominal_rpm(clip.rate_rad_s)
        name = f"{'m' if clip.rate_rad_s < 0 else ''}{rpm:.3g}rpm"
        same = sum(each.partition("_")[0] == name for each in rates)
        return (f"{name}_{same + 1}" if same else name), clip
    near = {name: abs(math.log(abs(rate / turns))) for name, rate in rates.items()}
    return min((name for name in near if near[name] < NEAR_CLIP), default="",
               key=lambda name: (rates[name] * turns < 0, near[name])), None


def _poses_in(log: ImuLog, specs: Specs, turns: float) -> tuple[tuple[PoseMean, ...], bool]:
    """The pose of a log, or the stops of a long one."""
    try:
        return (average_pose(log, specs, abs(turns)),), False
    except CalibrationError as moved:
        try:
            stops = find_still(log, specs, turns).logs
            means = [average_pose(stop, specs, abs(turns)) for stop in stops]
        except CalibrationError:
            means = []
        if len(means) < 2:
            raise moved
        return tuple(means), True


def unused_clips(clips: Sequence[MeasuredClip], logs: Sequence[FurtherLog]) -> Iterator[str]:
    """A sentence on each clip that no log needs."""
    used = {log.clip.path for log in logs if log.clip}
    for clip in clips:
        if clip.path not in used:
            yield (f"{clip.path.name}: the plate turns at {clip.rate_rad_s / RPM:+.4g} rpm in it, "
                   f"and no new log does; the clip is not used.")
