"""The logs of a session, without samples that are not measurements.

Each log is labelled by its path from the configuration.
"""

import os
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from calib.consistency.log_units import require_celsius, require_one_unit_of_time
from calib.consistency.raw_samples import require_raw, require_running, require_unclipped
from calib.consistency.repeats import require_no_copies
from calib.consistency.truncation import before_truncation, truncation_steps
from calib.errors import CalibrationError
from calib.poses.checks.frozen import without_frozen
from calib.poses.checks.pose_checks import check_counts, check_range
from calib.poses.checks.stray_samples import without_strays
from calib.poses.data_sheet import Specs, signed_log
from calib.poses.imu_log import TRIADS, ImuLog, Triad
from pipeline.config.load import Config
from pipeline.config.schema import (
    LogsSection,
    PosesSection,
    RunSection,
)
from pipeline.config.sensor import sensor_specs
from pipeline.config.types import STOPPED
from pipeline.errors import PipelineError
from pipeline.logs.clock import StatedClock
from pipeline.logs.join import group_logs, join_logs, whole_logs
from pipeline.logs.read import read_log
from pipeline.logs.source import require_uncorrected
from pipeline.stages.excluded_poses import Choice, chosen
from pipeline.stages.fittable import require_stated_units


def measured_samples(log: ImuLog, turning: bool, specs: Specs) -> tuple[ImuLog, str | None]:
    """The samples of a pose that the sensor measured, and a note on those that are left out.

    Raises
    ------
    UnusableLog
        A value that the converter cannot give: the file is damaged, or of another sensor.
    Undetermined
        An axis is saturated, or too many samples are no measurement.
    """
    for triad in TRIADS:
        spec = specs.get(triad)
        if spec is not None and log.has(triad):
            counts = log.readings(triad)
            check_range(log.label, triad, counts, spec)
            low, high = spec.count_range
            # If all axes are at an end at once, a reading failed; if one axis is, it is saturated.
            failed = ((counts <= low) | (counts >= high)).all(axis=1)
            check_counts(log.label, triad, counts[~failed], spec)
    running, frozen = without_frozen(log, turning)
    measured, strays = without_strays(running)
    return measured, " ".join(filter(None, [frozen, strays])) or None


NOTES_SHOWN = 3  #: notes of one run's poses; it chooses words only


@dataclass(frozen=True, eq=False)
class SettingLogs:
    """The logs of one setting, one for each pose or the long ones that hold all of them.

    Frozen blocks and stray samples are removed from files of one pose; ``notes`` say where. A table
    of means has no logs. ``choice`` separates the files of one pose that the configuration
    excludes; ``excluded`` are these with their labels, None where a log cannot be read.
    """

    logs: tuple[ImuLog, ...] = ()
    notes: tuple[str, ...] = ()
    choice: Choice | None = None
    excluded: tuple[tuple[str, ImuLog | None], ...] = ()


SessionLogs = Mapping[RunSection, SettingLogs]
"""The logs by :attr:`RunSection.recorded`."""


def settings_of(config: Config, triad: Triad) -> list[RunSection]:
    """The settings that the section of ``triad`` names, in its order."""
    return [section.recorded for section in config.runs_of(triad)]


def sections_by_setting(config: Config) -> dict[RunSection, RunSection]:
    """Every setting of a configuration with the first section that names it."""
    sections: dict[RunSection, RunSection] = {}
    for _, section in config.placed_runs():
        sections.setdefault(section.recorded, section)
    return sections


def read_logs(
    section: LogsSection, paths: Sequence[Path], folder: Path, specs: Specs, *,
    clock_needed: bool = True,
) -> list[ImuLog]:
    """Read files of a section with its columns and clock, in counts with their signs.

    Parameters
    ----------
    section : LogsSection
        States ``columns``, ``sample_rate_hz`` and ``time_unit``.
    paths : sequence of Path
        One of the section's lists of files, whole and in its order.
    folder : Path
        The configuration's; logs are labelled by their path from it.
    specs : mapping of str to TriadSpec
    clock_needed : bool
        False for poses at rest, one file each: their means need no times.

    Raises
    ------
    UnreadableInput
        A file is missing, or is not a log with these columns.
    """
    return [_read_one(section, i, path, folder, specs, clock_needed)
            for i, path in enumerate(paths)]


def _read_one(
    section: LogsSection, i: int, path: Path, folder: Path, specs: Specs, clock_needed: bool
) -> ImuLog:
    require_uncorrected(path)
    clock = StatedClock(section.sample_rate_hz, section.time_unit, clock_needed)
    log = signed_log(read_log(path, section.columns_of(i), clock), specs)
    return replace(log, label=_shown_name(path, folder))


def pose_labels(poses: PosesSection, config: Config) -> list[str]:
    """Labels of the poses of a section with one file per pose; none of another."""
    return [_shown_name(path, config.source.path.parent) for path in poses.files]


def _shown_name(path: Path, folder: Path) -> str:
    """Path with slashes; undecodable bytes are escaped, since a label is written to files."""
    relative = os.path.relpath(path, folder)
    return os.fsencode(relative).decode(errors="backslashreplace").replace(os.sep, "/")


def long_logs(poses: PosesSection, folder: Path, specs: Specs) -> list[ImuLog]:
    """The recordings of a section: the parts of each, and its triads, are joined in time.

    Raises
    ------
    UnreadableInput
        A log cannot be read, or its triads do not overlap in time.
    """
    logs = whole_logs(read_logs(poses, poses.log, folder, specs))
    return [join_logs(group) for group in group_logs(logs)]


def read_session(config: Config) -> SessionLogs:
    """Read the poses of both triads; poses that serve both are read once.

    Raises
    ------
    UnreadableInput, UnusableLog
        A log cannot be read.
    ConfigError
        ``exclude`` names no pose.
    Contradiction, Undetermined
        Samples occur twice, a log froze, or the logs count time in different units.
    """
    folder = config.source.path.parent
    sections = sections_by_setting(config)
    require_stated_units(config, [path for setting in sections for path in
                                  (*setting.poses.files, *setting.poses.log)])
    choices = {setting: chosen(pose_labels(setting.poses, config), section, config)
               for setting, section in sections.items() if setting.poses.files}
    specs = sensor_specs(config.sensor)
    session = {setting: _read(setting, folder, choices.get(setting), specs)
               for setting in sections}
    every = [log for one in session.values() for log in one.logs]
    if every:
        require_one_unit_of_time(every)
        require_celsius(every)
        # In long logs the poses are checked instead.
        require_running([one.logs for setting, one in session.items() if not setting.poses.log])
    for triad, spec in specs.items():
        settings = settings_of(config, triad)
        require_no_copies([*_each_once(settings, session)], triad)
        for setting in settings:
            require_unclipped(session[setting].logs, triad, spec)
            if triad == "accelerometer" and setting.rate == STOPPED and not setting.poses.log:
                require_raw(session[setting].logs, spec)
    return _before_truncation(session, [triad for triad in TRIADS if triad in specs])


def _before_truncation(session: SessionLogs, triads: Sequence[Triad]) -> SessionLogs:
    """The session with its readings as they were before the logger truncated them."""
    every = {log.label: log for one in session.values() for log in one.logs}
    all_steps = {triad: truncation_steps([*every.values()], triad) for triad in triads}
    steps = {triad: of_triad for triad, of_triad in all_steps.items() if of_triad is not None}
    if not steps:
        return session
    note = (f"The readings of {' and '.join(steps)} are truncated toward zero, as a conversion to "
            f"an integer does: zero occurs twice as often as the values beside it. Half a step is "
            f"added to each. Round where this calibration is used, and in the logger.")
    first = next(iter(session))
    return {setting: replace(
        one,
        logs=tuple(before_truncation(log, steps) for log in one.logs),
        excluded=tuple((label, log and before_truncation(log, steps))
                       for label, log in one.excluded),
        notes=(note, *one.notes) if setting == first else one.notes,
    ) for setting, one in session.items()}


def _each_once(
    settings: Sequence[RunSection], session: SessionLogs
) -> Iterator[ImuLog]:
    """The logs of settings; a long log once for all rates, each of which uses other stops of it.

    Without an accelerometer no direction tells the stops of two turning runs apart.
    """
    rates: dict[str, set[str]] = {}
    for setting in settings:
        for log in session[setting].logs:
            others = rates.setdefault(log.label, set())
            apart = STOPPED in {setting.rate, *others} or all(map(log.has, TRIADS))
            if not (others and apart and setting.poses.log and setting.rate not in others):
                yield log
            others.add(setting.rate)


def _read(setting: RunSection, folder: Path, choice: Choice | None, specs: Specs) -> SettingLogs:
    poses, turning = setting.poses, setting.rate != STOPPED
    if poses.means:
        return SettingLogs()
    if choice is None:
        logs = long_logs(poses, folder, specs)
        return SettingLogs(tuple(logs), _few(setting.rate, filter(None, map(_note, logs))))

    def measured(i: int) -> tuple[ImuLog, str]:
        log = _read_one(poses, i, poses.files[i], folder, specs, turning)
        cleaned, note = measured_samples(log, turning, specs)
        return cleaned, " ".join(filter(None, [_note(log), note]))

    def readable(i: int) -> ImuLog | None:
        try:
            return measured(i)[0]
        except (PipelineError, CalibrationError):  # that may be why it is excluded
            return None

    read = [measured(i) for i in map(int, choice.kept)]
    return SettingLogs(
        tuple(log for log, _ in read),
        _few(setting.rate, filter(None, (note for _, note in read))), choice,
        tuple((_shown_name(poses.files[i], folder), readable(i))
              for i in map(int, choice.excluded)))


def _few(run: str, notes: Iterable[str]) -> tuple[str, ...]:
    """The notes of the first poses; one line states that there are more."""
    notes = tuple(notes)
    more = len(notes) - NOTES_SHOWN
    if more < 2:
        return notes
    return (*notes[:NOTES_SHOWN],
            f"{run}: {more} more poses have a warning of this kind.")


def _note(log: ImuLog) -> str | None:
    """The changes its reader made, with its name."""
    return " ".join(f"{log.label}: {note}." for note in log.notes) or None
