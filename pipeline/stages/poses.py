"""Logs in, pose means out: every set of poses that the configuration names."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from calib.consistency.clock import require_whole_turns
from calib.errors import Undetermined
from calib.poses.averaging import PoseMean, average_pose
from calib.poses.frozen import without_frozen
from calib.poses.imu_log import ImuLog
from calib.poses.pose_checks import LARGEST_STILL_SHIFT
from calib.poses.rest_candidates import PLATE_STOOD, WANDER_M_S2, StillSearch
from calib.poses.runs import TURNING_RAD_S
from calib.poses.static_intervals import StaticIntervals, find_still, list_stops
from pipeline.config.load import Config
from pipeline.config.schema import PosesSection, StillSection
from pipeline.config.sensor import Specs, sensor_specs
from pipeline.config.types import STOPPED
from pipeline.stages.pose_means import read_pose_means
from pipeline.stages.rate import SettingRate
from pipeline.stages.session_logs import SessionLogs, Setting

LARGEST_OF_USUAL = 10.0
"""How far a stop may give way, as a multiple of what three in four of its log do: speeds and
lengths of stops in a hand spread over a decade each. Half of it loses one of 24 simulated stops in
a hand."""

SMALLEST_SHARE_AT_REST = 0.25
"""Poses of one attitude on a turning plate read alike too; no design repeats one so often."""


@dataclass(frozen=True, eq=False)
class Recording:
    """The averaged poses of one setting.

    ``start_s`` is when its first log begins; ``warnings`` say which found poses were left out;
    ``sense`` is how the plate turns by the accelerometer alone, +1 ccw, -1 cw, 0 unknown.
    """

    means: tuple[PoseMean, ...]
    start_s: float
    warnings: tuple[str, ...] = ()
    sense: float = 0.0


@dataclass(frozen=True, eq=False)
class Recordings:
    """All poses of a session, averaged."""

    by_setting: Mapping[Setting, Recording]

    def of(self, poses: PosesSection, rate: str = STOPPED) -> Recording:
        """The recording of these poses at this rate."""
        return self.by_setting[Setting(poses, rate)]

    @property
    def origin_s(self) -> float:
        """When the session began: the earliest sample of all logs; 0 where no time is known."""
        start_s = min(recording.start_s for recording in self.by_setting.values())
        return start_s if math.isfinite(start_s) else 0.0

    @property
    def warnings(self) -> tuple[str, ...]:
        """Those of all recordings."""
        return tuple(w for recording in self.by_setting.values() for w in recording.warnings)


def average_recordings(
    config: Config, logs: SessionLogs, rates: Mapping[str, SettingRate]
) -> Recordings:
    """Average the poses of both triads; poses that serve both are averaged once.

    Raises
    ------
    UnusableLog
        A log holds what this sensor cannot give.
    Undetermined
        A pose that was named is no pose: it moved, is saturated or too short.
    Contradiction
        The plate turns at another rate in the logs than in its clip.
    """
    specs = sensor_specs(config.sensor)
    folder = config.source.path.parent
    recordings = {}
    for setting, each in logs.by_setting.items():
        recording = (
            _tabled(setting.poses, folder, specs)
            if setting.poses.means
            else _record(setting, specs, rates, each)
        )
        notes = (*logs.notes[setting], *recording.warnings)
        recordings[setting] = replace(recording, warnings=notes)
    return Recordings(recordings)


def _tabled(poses: PosesSection, folder: Path, specs: Specs) -> Recording:
    means = read_pose_means(poses, folder, specs)
    return Recording(tuple(means), min(_known(mean.time_s) for mean in means))


def _record(
    setting: Setting,
    specs: Specs,
    rates: Mapping[str, SettingRate],
    logs: Sequence[ImuLog],
) -> Recording:
    rate = rates.get(setting.rate)
    plate = np.zeros(1) if rate is None else rate.plate.rate_rad_s
    if setting.poses.log:
        return _pooled([_searched(log, specs, float(plate.mean()), setting.poses.still)
                        for log in logs])
    turning = np.broadcast_to(plate, len(logs))
    wave = None
    if rate is not None and specs[0] is not None:
        others = {name: each.rate_rad_s for name, each in rates.items() if name != setting.rate}
        wave = require_whole_turns(setting.rate, logs, turning, (specs[0], specs[1]), others)
    means = [average_pose(log, *specs, float(w)) for log, w in zip(logs, turning, strict=True)]
    start_s = min(float(log.time_s[0]) for log in logs)
    return Recording(tuple(means), start_s, sense=0.0 if wave is None else wave.sense)


def _known(time_s: float) -> float:
    """A time that a recording can begin at; the end of all times where it is not known."""
    return time_s if math.isfinite(time_s) else math.inf


def _pooled(found: Sequence[Recording]) -> Recording:
    """The poses of several recordings of one sensor; each has a clock of its own."""
    if len(found) == 1:
        return found[0]
    counts = " + ".join(str(len(each.means)) for each in found)
    means = tuple(mean for each in found for mean in each.means)
    notes = tuple(note for each in found for note in each.warnings)
    return Recording(means, min(each.start_s for each in found), (
        f"{len(found)} logs hold the same triads: their poses are pooled ({counts}), and nothing "
        f"is joined in time.", *notes))


def still_search(section: StillSection) -> StillSearch:
    """What the user overrules of the search for static intervals."""
    return StillSearch(section.seconds, section.threshold)


def _searched(
    log: ImuLog, specs: Specs, rate_rad_s: float, still: StillSection
) -> Recording:
    """The poses of a long log; stops that turn out to be none are left out, with the reason."""
    log, frozen = without_frozen(log, turning=False)
    intervals = find_still(log, *specs, rate_rad_s, still_search(still))
    means: list[PoseMean] = []
    refused: list[Undetermined] = []
    largest_shift = _largest_shift(intervals)
    for pose in intervals.logs:
        try:
            means.append(average_pose(pose, *specs, rate_rad_s, largest_shift))
        except Undetermined as error:
            refused.append(error)
    if not means:
        raise refused[0]
    skipped = list(intervals.skipped)
    if rate_rad_s == 0:
        means, turning = _parted_by_rate(means)
        skipped += [(mean.label.removeprefix(f"{log.label} "), "the plate or the hand turned it")
                    for mean in turning]
    warnings = [*filter(None, [frozen]), *(f"Left out: {error}" for error in refused)]
    if skipped:
        warnings.append(
            f"{log.label}: {len(means)} stops are poses; left out: {list_stops(skipped)}. Stops "
            f"are found up to {intervals.threshold:.2g} times the noise of the quietest rest; "
            f"`still: {{threshold: ...}}` beside `find: still` overrules that."
        )
        if rate_rad_s and any(reason == PLATE_STOOD for _, reason in skipped):
            warnings.append(
                f"{log.label}: to use the stops of the plate as poses at rest, add the run "
                f"`{{poses: {{log: {log.label}, find: still}}, rate: stopped}}`."
            )
    return Recording(tuple(means), float(log.time_s[0]), tuple(warnings))


def _largest_shift(intervals: StaticIntervals) -> Mapping[str, float]:
    """How far the halves of a stop may differ, by triad, SI.

    A hand gives way by a degree, which the magnitude hardly feels and the sd of the mean has: there
    a stop counts as moved where it gives way more than the others of the log do.
    """
    if intervals.triad == "gyroscope":
        return LARGEST_STILL_SHIFT
    usual = min(LARGEST_OF_USUAL * intervals.usual_shift, WANDER_M_S2)
    return {**LARGEST_STILL_SHIFT,
            "accelerometer": max(LARGEST_STILL_SHIFT["accelerometer"], usual)}


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
