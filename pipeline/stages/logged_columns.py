"""Which further columns the logs of a session have, and whether models and covariates find theirs.
"""

from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np

from calib.effects.catalogue import find_effect
from calib.effects.effect import Effect
from calib.errors import Undetermined
from calib.poses.averaging.pose_mean import is_stated
from calib.poses.imu_log import ImuLog, Triad
from pipeline.config.load import Config
from pipeline.config.messages import ConfigProblem, config_error
from pipeline.config.schema import LogsSection, PosesSection
from pipeline.errors import UnreadableInput
from pipeline.logs.columns import READINGS
from pipeline.logs.read import column_names
from pipeline.stages.session_logs import SessionLogs
from pipeline.text.names import nearest_name


def check_covariates(config: Config) -> None:
    """Refuse ``covariates`` that no log has.

    Raises
    ------
    ConfigError
        With the line of each, and the nearest column that the logs have.
    """
    if config.covariates is None:
        return
    known = [columns for triad in config.triads
             if (columns := logged_columns(config, triad)) is not None]
    if not known:
        return
    logged = tuple(dict.fromkeys(name for columns in known for name in columns))
    problems = [
        ConfigProblem(("covariates", i), (
            f"'{name}' is no logged column{nearest_name(name, logged)}. The logs have: "
            f"{', '.join(logged) or 'no further column'}. Name one of these, or log it."))
        for i, name in enumerate(config.covariates) if name not in logged
    ]
    if problems:
        raise config_error(config.source, problems)


def logged_columns(config: Config, triad: Triad | None) -> list[str] | None:
    """Columns that every log of the triad has beside time and readings; None before recording."""
    poses = [run.poses for path, run in config.placed_runs() if triad in (None, path[0])]
    heads = [names for pose in poses if (names := _columns_of(pose)) is not None]
    if not heads:
        return None
    return [name for name in heads[0] if all(name in names for names in heads)]


def _columns_of(poses: PosesSection) -> list[str] | None:
    """Further columns of a set of poses, by its first file or by all files of its long log.

    Of a table of means those that are neither sds nor numbers of samples.
    """
    names: list[str] = []
    for i, path in enumerate(poses.log or poses.files[:1] or poses.means[:1]):
        names += _header(poses, i, path)
    return names or None


def _header(section: LogsSection, i: int, path: Path) -> list[str]:
    try:
        names = column_names(path, section.columns_of(i))
    except UnreadableInput:  # said where the log itself is read
        return []
    return [name for name in names if name not in READINGS and not is_stated(name)] or [""]


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
    for triad, section in config.triads.items():
        used = logs.triad_logs(config, triad)
        for name in section.model:
            if name in config.effects:
                continue
            effect = find_effect(name)
            problems += [ConfigProblem((triad, "model"), absent)
                         for absent in _absent(effect, used)]
            incomplete += _incomplete(effect, triad, used)
    if problems:
        raise config_error(config.source, problems)
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
