"""The logs of a session, read and checked against each other before anything slow.

Each log is labelled by its path from the configuration.
"""

import os
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from calib.consistency.clipping import require_unclipped
from calib.consistency.repeats import require_no_copies, require_running
from calib.effects.catalogue import find_effect
from calib.effects.effect import Effect
from calib.errors import Contradiction, Undetermined
from calib.poses.imu_log import TRIADS, ImuLog, Triad
from pipeline.config.load import Config
from pipeline.config.schema import LogsSection, PosesSection
from pipeline.config.types import STOPPED
from pipeline.errors import ConfigError
from pipeline.logs.read import join_logs, read_log
from pipeline.names import nearest_name

OTHER_UNIT = 100.0
"""Nobody logs one sensor at rates that differ so much: the next unit of time is 1000 away, a counter
of samples 100 at the usual 100 Hz."""


@dataclass(frozen=True)
class Setting:
    """Which poses, at which plate rate; what a recording is found by."""

    poses: PosesSection
    rate: str


@dataclass(frozen=True, eq=False)
class SessionLogs:
    """The logs of all settings: one for each pose, or the one long log of all its poses."""

    by_setting: Mapping[Setting, tuple[ImuLog, ...]]

    def of_triad(self, config: Config, triad: Triad) -> list[ImuLog]:
        """The logs that ``triad`` is calibrated by, run after run."""
        return [log for setting in settings_of(config, triad) for log in self.by_setting[setting]]


def settings_of(config: Config, triad: Triad) -> list[Setting]:
    """The settings that the section of ``triad`` names, in its order."""
    if triad == "accelerometer":
        return [Setting(config.accelerometer.poses, STOPPED)] if config.accelerometer else []
    return [Setting(run.poses, run.rate) for run in (config.gyroscope.runs if config.gyroscope
                                                     else ())]


def read_logs(section: LogsSection, paths: Sequence[Path], folder: Path) -> list[ImuLog]:
    """Read files of a section with its columns and sample rate.

    Parameters
    ----------
    section : LogsSection
        States ``columns`` and ``sample_rate_hz``.
    paths : sequence of Path
        One of the section's lists of files, whole and in its order.
    folder : Path
        The configuration's; logs are labelled by their path from it.

    Raises
    ------
    UnreadableInput
        A file is missing, or is not a log with these columns.
    """
    return [
        replace(
            read_log(path, section.columns_of(i), section.sample_rate_hz),
            label=Path(os.path.relpath(path, folder)).as_posix(),
        )
        for i, path in enumerate(paths)
    ]


def read_session(config: Config) -> SessionLogs:
    """Read the poses of both triads; poses that serve both are read once.

    Raises
    ------
    UnreadableInput, UnusableLog
        A log cannot be read.
    Contradiction, Undetermined
        Samples occur twice, a log froze, or the logs count time in different units.
    """
    folder = config.source.path.parent
    settings = dict.fromkeys(
        (*settings_of(config, "accelerometer"), *settings_of(config, "gyroscope")))
    logs = SessionLogs({setting: _read(setting.poses, folder) for setting in settings})
    every = [log for each in logs.by_setting.values() for log in each]
    if every:
        _require_one_unit_of_time(every)
        require_running([log for setting, each in logs.by_setting.items() for log in each
                         if not setting.poses.log])  # of long logs the poses are looked at
    for triad in TRIADS:
        require_no_copies(logs.of_triad(config, triad), triad)
        for setting in settings_of(config, triad):
            require_unclipped(logs.by_setting[setting], triad)
    return logs


def _read(poses: PosesSection, folder: Path) -> tuple[ImuLog, ...]:
    if poses.log:
        return (join_logs(read_logs(poses, poses.log, folder)),)
    return tuple(read_logs(poses, poses.files, folder))


def _require_one_unit_of_time(logs: Sequence[ImuLog]) -> None:
    steps = np.array([float(np.median(np.diff(log.time_s))) for log in logs])
    typical = float(np.median(steps))
    ratio = np.maximum(steps / typical, typical / steps)
    odd = int(np.argmax(ratio))
    if ratio[odd] < OTHER_UNIT:
        return
    raise Contradiction(
        f"{logs[odd].label}: its time stamps are {steps[odd]:.3g} apart, those of the other logs "
        f"{typical:.3g}. Are some of them seconds and others milliseconds, microseconds or a "
        f"counter? Bring time_s of all logs to seconds."
    )


def require_logged_columns(config: Config, logs: SessionLogs) -> None:
    """Refuse models with effects of columns that the logs of their triads do not hold.

    User-defined effects are left to :mod:`pipeline.stages.user_effects`.

    Raises
    ------
    ConfigError
        A column is not there, with the nearest that is.
    Undetermined
        A column has no number in some sample.
    """
    problems = []
    incomplete: list[Undetermined] = []
    for triad in TRIADS:
        section = getattr(config, triad)
        used = logs.of_triad(config, triad)
        for name in section.model if section else ():
            if name in config.effects:
                continue
            effect = find_effect(name)
            problems += [config.source.problem((triad, "model"), absent)
                         for absent in _absent(effect, used)]
            incomplete += _incomplete(effect, triad, used)
    if problems:
        raise ConfigError(*problems)
    if incomplete:
        raise incomplete[0]


def _absent(effect: Effect, logs: Sequence[ImuLog]) -> Iterator[str]:
    for name in effect.logged:
        without = [log for log in logs if name not in log.columns]
        if without:
            there = tuple(without[0].columns)
            yield (f"'{effect.name}' needs the column {name}, which {without[0].label} does not "
                   f"have{nearest_name(name, there)}. Its further columns: "
                   f"{', '.join(there) or 'none'}. Log it, or take the effect out of the model")


def _incomplete(effect: Effect, triad: Triad, logs: Sequence[ImuLog]) -> Iterator[Undetermined]:
    for name in effect.logged:
        for log in logs:
            empty = ~np.isfinite(log.columns.get(name, np.zeros(1)))
            if empty.any():
                yield Undetermined(
                    f"{log.label}: the column {name} has no number at sample "
                    f"{int(np.argmax(empty)) + 1}, and {triad}.{effect.name} needs it in every "
                    f"sample. Delete the rows in which it is empty, or take the effect out of the "
                    f"model."
                )
                return
