"""Logs in, pose means out: every set of poses that the configuration names, each read once."""

import os
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from calib.errors import Undetermined
from calib.poses.averaging import LARGEST_STILL_SHIFT, PoseMean, average_pose
from calib.poses.data_sheet import TriadSpec
from calib.poses.imu_log import ImuLog
from calib.poses.rest_candidates import WANDER_M_S2, StillSearch
from calib.poses.runs import TURNING_RAD_S
from calib.poses.static_intervals import find_still, list_stops
from pipeline.config.load import Config, triad_spec
from pipeline.config.schema import Poses, StillSection
from pipeline.config.types import STOPPED
from pipeline.logs.read import join_logs, read_log
from pipeline.stages.context import Workplace
from pipeline.stages.rate import SettingRate

STILL_SHIFT = {**LARGEST_STILL_SHIFT, "accelerometer": WANDER_M_S2}
"""How far the halves of a stop in a hand may differ: the magnitude hardly feels it, and the sd of
the mean has it."""

SMALLEST_SHARE_AT_REST = 0.25
"""Poses of one attitude on a turning plate read alike too; no design repeats one so often."""


@dataclass(frozen=True)
class Setting:
    """Which poses, at which plate rate; what a recording is found by."""

    poses: Poses
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

    def of(self, poses: Poses, rate: str = STOPPED) -> Recording:
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


def average_recordings(
    config: Config, _workplace: Workplace, rates: Mapping[str, SettingRate]
) -> Recordings:
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
    specs = (
        triad_spec(config.sensor.accelerometer) if config.sensor.accelerometer else None,
        triad_spec(config.sensor.gyroscope) if config.sensor.gyroscope else None,
    )
    folder = config.source.path.parent
    return Recordings(
        {
            setting: _record(setting, specs, rates.get(setting.rate), folder)
            for setting in dict.fromkeys(settings)
        }
    )


def _record(
    setting: Setting,
    specs: tuple[TriadSpec | None, TriadSpec | None],
    rate: SettingRate | None,
    folder: Path,
) -> Recording:
    poses = setting.poses
    plate = np.zeros(1) if rate is None else rate.plate.rate_rad_s
    if poses.log:
        return _found(read_joined(poses, folder), specs, float(plate.mean()), poses.still)
    logs = [
        read_labelled(path, poses, i, folder) for i, path in enumerate(poses.files)
    ]
    turning = np.broadcast_to(plate, len(logs))
    means = [average_pose(log, *specs, float(w)) for log, w in zip(logs, turning, strict=True)]
    return Recording(tuple(means), min(float(log.time_s[0]) for log in logs))


def read_labelled(path: Path, poses: Poses, i: int, folder: Path) -> ImuLog:
    """The i-th file of ``poses``, called by its path from the configuration's folder."""
    log = read_log(path, poses.columns_of(i), poses.sample_rate_hz)
    return replace(log, label=Path(os.path.relpath(path, folder)).as_posix())


def read_joined(poses: Poses, folder: Path) -> ImuLog:
    """The one long log of ``poses``, its files joined on time."""
    return join_logs([read_labelled(path, poses, i, folder) for i, path in enumerate(poses.log)])


def still_search(section: StillSection) -> StillSearch:
    """What the user overrules of the search for static intervals."""
    return StillSearch(section.seconds, section.threshold)


def _found(
    log: ImuLog,
    specs: tuple[TriadSpec | None, TriadSpec | None],
    rate_rad_s: float,
    still: StillSection,
) -> Recording:
    """The poses of a long log; stops that turn out to be none are left out, with the reason."""
    intervals = find_still(log, *specs, rate_rad_s, still_search(still))
    means: list[PoseMean] = []
    refused: list[Undetermined] = []
    for pose in intervals.logs:
        try:
            means.append(average_pose(pose, *specs, rate_rad_s, STILL_SHIFT))
        except Undetermined as error:
            refused.append(error)
    if not means:
        raise refused[0]
    skipped = list(intervals.skipped)
    if rate_rad_s == 0:
        means, turning = _parted_by_rate(means)
        skipped += [(mean.label.removeprefix(f"{log.label} "), "the plate or the hand turned it")
                    for mean in turning]
    warnings = [f"Left out: {error}" for error in refused]
    if skipped:
        warnings.append(
            f"{log.label}: {len(means)} stops are poses; left out: {list_stops(skipped)}. Stops "
            f"are found up to {intervals.threshold:.2g} times the noise of the quietest rest; "
            f"`still: {{threshold: ...}}` beside `find: still` overrules that."
        )
    return Recording(tuple(means), float(log.time_s[0]), tuple(warnings))


def _parted_by_rate(means: list[PoseMean]) -> tuple[list[PoseMean], list[PoseMean]]:
    """Poses at rest and poses that turned, of a log that holds both.

    At rest a gyroscope reads its bias in every attitude, on a turning plate something else in each.
    Where too few poses read alike to be the ones at rest, none is taken out.
    """
    rate = np.array([mean.gyroscope.mean for mean in means])
    if not np.isfinite(rate).all():
        return means, []
    alike = np.linalg.norm(rate[:, None] - rate, axis=2) < TURNING_RAD_S
    at_rest = alike[int(np.argmax(alike.sum(axis=1)))]
    if at_rest.mean() < SMALLEST_SHARE_AT_REST:
        return means, []
    return ([mean for mean, rests in zip(means, at_rest, strict=True) if rests],
            [mean for mean, rests in zip(means, at_rest, strict=True) if not rests])
