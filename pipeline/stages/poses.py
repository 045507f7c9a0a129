"""From logs to pose means: every set of poses that the configuration names."""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace

import numpy as np

from calib.consistency.clock import gravity_wave, require_whole_turns
from calib.consistency.clock_ratio import ClockRatio, clock_ratio
from calib.errors import Undetermined
from calib.poses.averaging.average_pose import average_pose, without_pause
from calib.poses.averaging.drift_within import average_poses
from calib.poses.averaging.pose_mean import PoseMean
from calib.poses.checks.frozen import without_frozen
from calib.poses.checks.pose_checks import LARGEST_STILL_SHIFT
from calib.poses.checks.stray_samples import without_strays
from calib.poses.data_sheet import Specs
from calib.poses.imu_log import FloatArray, ImuLog
from calib.poses.rests.rest_candidates import OF_ANOTHER_RUN, PLATE_STOOD
from calib.poses.rests.static_intervals import StaticIntervals, find_still, list_stops
from calib.poses.rests.still_search import StillSearch
from calib.poses.runs.reference_runs import TURNING_RAD_S
from pipeline.config.load import Config
from pipeline.config.schema import RunSection, StillSection
from pipeline.config.sensor import sensor_specs
from pipeline.config.types import STOPPED
from pipeline.stages.excluded_poses import ExcludedMean, chosen
from pipeline.stages.pose_means import read_pose_means
from pipeline.stages.rate import SettingRate
from pipeline.stages.recordings import Recording, Recordings
from pipeline.stages.session_logs import SessionLogs, sections_by_setting
from pipeline.text.formatting import count

SMALLEST_SHARE_AT_REST = 0.25
"""Poses of one attitude on a turning plate also read the same; no design repeats one so often."""


def average_recordings(
    config: Config, logs: SessionLogs, rates: Mapping[str, SettingRate]
) -> Recordings:
    """Average the poses of both triads, of all settings with a rate; shared poses once.

    Raises
    ------
    ConfigError, UnreadableInput
        A pose that is excluded is not there; a table of means cannot be read.
    UnusableLog
        A log holds what this sensor cannot give.
    Undetermined
        A pose that was named is no pose: it moved, is saturated or too short.
    Contradiction
        The plate turns at another rate in the logs than in its clip.
    """
    specs = sensor_specs(config.sensor)
    recordings = {}
    for setting, section in sections_by_setting(config).items():
        if setting.rate not in (STOPPED, *rates):
            continue
        if setting.poses.means:
            recording = _tabled(section, config, specs)
        elif setting.poses.log:
            recording = _searched(section, config, specs, rates, logs)
        else:
            recording = _averaged(setting, specs, rates, logs)
        notes = (*logs[setting].notes, *recording.warnings)
        recordings[setting] = replace(recording, warnings=notes)
    return Recordings(recordings)


def _tabled(
    section: RunSection, config: Config, specs: Specs
) -> Recording:
    means = read_pose_means(section.poses, config.source.path.parent, specs)
    choice = chosen([mean.label for mean in means], section, config)
    excluded = tuple(ExcludedMean(means[i].label, i, means[i]) for i in map(int, choice.excluded))
    kept = tuple(means[i] for i in choice.kept)
    starts = tuple(mean.time_s if math.isfinite(mean.time_s) else math.inf for mean in kept)
    return Recording(kept, starts, choice.kept,
                     excluded=excluded)


def _averaged(
    setting: RunSection, specs: Specs, rates: Mapping[str, SettingRate], session: SessionLogs
) -> Recording:
    """The poses of one file each."""
    read = session[setting]
    choice, used = read.choice, read.logs
    assert choice is not None
    rate = rates.get(setting.rate)
    plate = np.zeros(1) if rate is None else rate.plate.rate_rad_s
    of_all = np.broadcast_to(plate, len(setting.poses.files))
    turning = of_all[choice.kept]
    cut = [] if rate is None else [
        without_pause(log, abs(float(at))) for log, at in zip(used, turning, strict=True)]
    pausing = [log.label for log, part in zip(used, cut, strict=False) if part is not log]
    notes = tuple(f"{setting.rate}: {len(pausing)} of {len(used)} poses lack samples for a quarter "
                  f"of a turn of the plate or longer ({label} first); the longest stretch between "
                  f"is used." for label in pausing[:1])
    used = tuple(cut) or used
    wave = None
    if rate is not None and "accelerometer" in specs:
        others = {name: one.rate_rad_s for name, one in rates.items() if name != setting.rate}
        wave = require_whole_turns(setting.rate, used, turning, specs, others)
    ratio = None if wave is None or rate is None else _ratio(rate, used, turning, specs)
    means = average_poses(used, specs, [float(rate) for rate in turning])
    every = [log for one in session.values()
             for log in (*one.logs, *(log for _, log in one.excluded if log is not None))]
    excluded = tuple(
        ExcludedMean.of(label, int(i), log, every, specs, float(of_all[i]))
        for (label, log), i in zip(read.excluded, choice.excluded, strict=True))
    starts = tuple(float(log.time_s[0]) for log in used)
    sense = 0.0 if wave is None else wave.sense
    return Recording(tuple(means), starts, choice.kept, notes, sense, excluded).beside(
        setting.rate, ratio)


def _ratio(
    rate: SettingRate, logs: Sequence[ImuLog], rate_rad_s: FloatArray, specs: Specs
) -> ClockRatio | None:
    return clock_ratio(logs, rate_rad_s, specs["accelerometer"], rate.sd_rad_s / rate.rate_rad_s,
                       bool(rate.clips))


def _pooled(recordings: Sequence[Recording]) -> Recording:
    """The poses of several recordings of one sensor; each has a clock of its own."""
    if len(recordings) == 1:
        return recordings[0]
    means = tuple(mean for recording in recordings for mean in recording.means)
    notes = tuple(note for recording in recordings for note in recording.warnings)
    return Recording(means, (min(min(recording.starts_s) for recording in recordings),),
                     np.arange(len(means)), notes,
                     excluded=tuple(one for recording in recordings for one in recording.excluded))


def still_search(section: StillSection) -> StillSearch:
    """The user's settings of the search for static intervals."""
    return StillSearch(section.seconds, section.threshold)


def _searched(
    section: RunSection, config: Config, specs: Specs,
    rates: Mapping[str, SettingRate], session: SessionLogs,
) -> Recording:
    """The poses of long logs, in which they are searched; stops at the rates of other runs that
    use the same logs are theirs."""
    setting = section.recorded
    rate = _signed_rate(setting, rates)
    elsewhere = [_signed_rate(other, rates) for other in session
                 if other.rate != setting.rate and {*other.poses.log} & {*setting.poses.log}
                 and other.rate in (STOPPED, *rates)]
    running = [without_frozen(log, turning=False, one_pose=False) for log in session[setting].logs]
    searches = [find_still(log, specs, rate, still_search(section.poses.still), elsewhere)
                for log, _ in running]
    labels = [pose.label for one in searches for pose in one.logs]
    out = {labels[i] for i in chosen(labels, section, config).excluded}
    recording = _pooled([_search_recording(log, frozen, search, out, specs, abs(rate), elsewhere)
                         for (log, frozen), search in zip(running, searches, strict=True)])
    poses = {pose.label: pose for one in searches for pose in one.logs}
    turning = [poses[mean.label] for mean in recording.means if mean.label in poses]
    of_each = np.full(len(turning), abs(rate))
    if not rate or "accelerometer" not in specs or not turning:
        return recording
    wave = gravity_wave(turning, of_each, specs["accelerometer"])
    ratio = wave and wave.is_clear and _ratio(rates[setting.rate], turning, of_each, specs)
    return recording.beside(setting.rate, ratio or None)


def _signed_rate(setting: RunSection, rates: Mapping[str, SettingRate]) -> float:
    """The plate's rate, rad/s, 0 at rest."""
    return rates[setting.rate].signed_rad_s if setting.rate in rates else 0.0


def _search_recording(
    log: ImuLog, frozen: str | None, intervals: StaticIntervals, out: set[str], specs: Specs,
    rate_rad_s: float, elsewhere: Sequence[float],
) -> Recording:
    """The poses of a long log; stops that fail a check are left out, with the reason. If other runs
    use the log ``elsewhere``, at their rates in rad/s, stops on the turning plate are theirs."""
    means: list[PoseMean] = []
    refused: list[Undetermined] = []
    stray_notes: list[str] = []
    largest_shift = _largest_shift(intervals)
    for pose in intervals.logs:
        if pose.label in out:
            continue
        try:
            measured, strays = without_strays(pose)
            means.append(average_pose(measured, specs, rate_rad_s, largest_shift))
            stray_notes += [strays] if strays else []
        except Undetermined as error:
            refused.append(error)
    if not means and refused:
        raise refused[0]
    excluded = tuple(ExcludedMean.of(pose.label, 0, pose, intervals.logs, specs, rate_rad_s)
                     for pose in intervals.logs if pose.label in out)
    skipped = [stop for stop in intervals.skipped if stop[1] != OF_ANOTHER_RUN]
    if rate_rad_s == 0 and means:
        means, turning = _parted_by_rate(means, elsewhere)
        skipped += [(mean.label.removeprefix(f"{log.label} "), "the plate or the hand turned it")
                    for mean in turning if not elsewhere]
    notes = [*filter(None, [frozen]), *stray_notes, *(
        f"Left out beside {count(len(means), 'pose')}: {error}" for error in refused)]
    notes += _skipped_notes(log, intervals, skipped, len(means), rate_rad_s)
    return Recording(tuple(means), (float(log.time_s[0]),), np.arange(len(means)), tuple(notes),
                     excluded=excluded)


def _skipped_notes(
    log: ImuLog, intervals: StaticIntervals, skipped: Sequence[tuple[str, str]], poses: int,
    rate_rad_s: float,
) -> Iterator[str]:
    """Notes on stops that are not poses, and on how to make them usable."""
    if not skipped:
        return
    yield (f"{log.label}: {poses} stops are poses; left out: {list_stops(skipped)}. Stops are "
           f"found up to {intervals.threshold:.2g} times the noise of the quietest rest; "
           f"`still: {{threshold: ...}}` beside `find: still` overrules that.")
    if rate_rad_s and any(reason == PLATE_STOOD for _, reason in skipped):
        yield (f"{log.label}: to use the stops of the plate as poses at rest, add the run "
               f"`{{poses: {{log: [{log.label.replace(' + ', ', ')}], find: still}}, "
               f"rate: stopped}}`.")


def _largest_shift(intervals: StaticIntervals) -> Mapping[str, float]:
    """Largest difference between the halves of a stop, by triad, SI.

    A hand gives way by a degree, to which the magnitude is insensitive and which the sd of the mean
    includes: there a stop counts as moved if it gives way more than the others of the log do.
    """
    if intervals.triad == "gyroscope":
        return LARGEST_STILL_SHIFT
    return {**LARGEST_STILL_SHIFT, "accelerometer": intervals.largest_shift}


def _parted_by_rate(
    means: list[PoseMean], elsewhere: Sequence[float]
) -> tuple[list[PoseMean], list[PoseMean]]:
    """Poses at rest and poses that turned, from a log that contains both.

    At rest a gyroscope reads its bias in every attitude, on a turning plate a different vector in
    each. If too few poses agree to be the ones at rest, the rates ``elsewhere`` tell them.
    """
    rate = np.array([mean.gyroscope.mean for mean in means])
    if not np.isfinite(rate).all():
        return means, []
    alike = np.linalg.norm(rate[:, None] - rate, axis=2) < TURNING_RAD_S
    at_rest = alike[int(np.argmax(alike.sum(axis=1)))]
    if at_rest.mean() < SMALLEST_SHARE_AT_REST:
        at_rest = np.linalg.norm(rate, axis=1) < min(map(abs, elsewhere), default=np.inf) / 2
    if not at_rest.any():
        return means, []
    return ([mean for mean, rests in zip(means, at_rest, strict=True) if rests],
            [mean for mean, rests in zip(means, at_rest, strict=True) if not rests])
