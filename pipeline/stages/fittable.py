"""Checks of the names in a configuration's models against triads, solvers and the logs' heads.

No log is read whole, and no Python file runs.
"""

from collections.abc import Iterable, Iterator
from itertools import chain
from pathlib import Path

from calib.effects.arithmetic import FUNCTIONS
from calib.effects.catalogue import BASE, find_effect
from calib.effects.expression import KNOWN_NAMES
from calib.errors import CalibrationError
from calib.poses.averaging.pose_mean import is_stated
from calib.poses.imu_log import Triad
from pipeline.config.load import Config
from pipeline.config.messages import ConfigProblem, config_error
from pipeline.config.schema import EffectSection, PosesSection
from pipeline.config.sensor import AccelerometerSheet, GyroscopeSheet
from pipeline.errors import ConfigError, UnreadableInput
from pipeline.logs.columns import READINGS
from pipeline.logs.formats.kinds import kind_of, split_member
from pipeline.logs.read import column_names
from pipeline.stages.user_effects import expression_of, require_function, shape_of
from pipeline.text.names import nearest_name

Problems = Iterator[ConfigProblem]


def require_fittable(config: Config) -> None:
    """Refuse, before anything slow, models that cannot be fitted in this configuration.

    Raises
    ------
    ConfigError
        With the line of every model that its triad or its solver does not have, of every
        expression or Python file that cannot be read, and of every name in them, in a model or
        under ``covariates`` that the logs do not have, with the nearest that they have.
    """
    problems = [*_models(config), *chain(*(
        _user_effect(config, name, section) for name, section in config.effects.items())),
        *_covariates(config)]
    if problems:
        raise config_error(config.source, problems)


def _models(config: Config) -> Problems:
    for triad, section in config.triads.items():
        where = (triad, "model")
        for name in section.model:
            if name in config.effects:
                if config.effects[name].triad not in (None, triad):
                    yield ConfigProblem(where, (
                        f"'{name}' is defined for the {config.effects[name].triad}. Take it out "
                        f"of this model"))
                continue
            effect = find_effect(name)
            if triad not in effect.triads:
                yield ConfigProblem(where, (
                    f"'{name}' is no effect of the {triad}; `pipeline effects {name}` says what "
                    f"it acts on. Take it out of this model"))
            columns = logged_columns(config, triad) if effect.logged else None
            for column in effect.logged:
                if columns is not None and column not in columns:
                    yield ConfigProblem(where, (
                        f"'{name}' needs the column {column}, which is not in all logs of the "
                        f"{triad}{nearest_name(column, columns)}. They have: {_listed(columns)}. "
                        f"Log it, or take the effect out of the model"))
        if section.solver == "paper" and section.loss != "squares":
            yield ConfigProblem((triad, "loss"), (
                "'paper' knows plain least squares only. Use `solver: default` with another loss"))
        if section.solver == "paper" and set(section.model) != set(BASE):
            yield ConfigProblem((triad, "solver"), (
                f"'paper' knows bias, scale and misalignment only, the model is "
                f"[{', '.join(section.model)}]. Use `solver: default` with any other model"))


def _user_effect(config: Config, name: str, section: EffectSection) -> Problems:
    where = ("effects", name)
    try:
        shape_of(section.shapes)
        if section.python is not None:
            require_function(config.source.path.parent, section.python)
            return
        expression = expression_of(section)
    except CalibrationError as error:
        yield ConfigProblem(where, error)
        return
    columns = logged_columns(config, section.triad)
    right = (*(columns or ()), *KNOWN_NAMES, *section.shapes, *FUNCTIONS)
    for column in expression.columns if columns is not None else ():
        if column not in (columns or ()):
            yield ConfigProblem((*where, "expression"), (
                f"'{column}' is no logged column, name or shape parameter"
                f"{nearest_name(column, right)}. The logs have: {_listed(columns)}. Log it, or "
                f"name it under `shapes` with its unit and bounds."))
    runs = tuple(dict.fromkeys(run.rate for path, run in config.placed_runs()
                               if section.triad in (None, path[0])))
    for run in expression.runs:
        if run not in runs:
            yield ConfigProblem((*where, "expression"), (
                f"run('{run}') is no run{nearest_name(run, runs)}. There are: {', '.join(runs)}."))


def _covariates(config: Config) -> Problems:
    if not config.covariates:
        return
    known = [columns for triad in config.triads
             if (columns := logged_columns(config, triad)) is not None]
    logged = tuple(dict.fromkeys(chain(*known)))
    for i, name in enumerate(config.covariates if known else ()):
        if name not in logged:
            yield ConfigProblem(("covariates", i), (
                f"'{name}' is no logged column{nearest_name(name, logged)}. The logs have: "
                f"{_listed(logged)}. Name one of these, or log it."))


def _listed(columns: tuple[str, ...] | None) -> str:
    return ", ".join(columns or ()) or "no further column"


def logged_columns(config: Config, triad: Triad | None) -> tuple[str, ...] | None:
    """Columns besides time and readings in every log of the triad; None before recording."""
    poses = [run.poses for path, run in config.placed_runs() if triad in (None, path[0])]
    heads = [names for pose in poses if (names := _columns_of(pose)) is not None]
    if not heads:
        return None
    return tuple(name for name in heads[0] if all(name in names for names in heads))


def _columns_of(poses: PosesSection) -> list[str] | None:
    """Further columns of a set of poses, by its first file or by all files of its long log.

    For a table of means without the sds and the numbers of samples.
    """
    names: list[str] = []
    for i, path in enumerate(poses.log or poses.files[:1] or poses.means[:1]):
        try:
            head = column_names(path, poses.columns_of(i))
        except UnreadableInput:  # reported where the log itself is read
            return None
        names += [name for name in head if name not in READINGS and not is_stated(name)]
    return names if poses.log or poses.files or poses.means else None


#: Triad -> key and unit of readings in SI units, in a configuration and in text.
SI_UNITS = {"accelerometer": ("m_s2", "m/s²"), "gyroscope": ("rad_s", "rad/s")}
WRITE = "`sensor: {accelerometer: {unit: m_s2}, gyroscope: {unit: rad_s}}`"


def require_stated_units(config: Config, paths: Iterable[Path]) -> None:
    """Refuse logs in SI units of a sensor that is stated in counts or other units.

    Parameters
    ----------
    config : Config
    paths : iterable of Path
        Logs that are read with the sensor of ``config``.

    Raises
    ------
    ConfigError
        With the line of the sensor, the unit of the format, and what to write.
    UnreadableInput
        A file cannot be read.
    """
    for path in paths:
        file, _ = split_member(path)
        kind = kind_of(file)
        if kind is None or not kind.si:
            continue
        for triad, (unit, words) in SI_UNITS.items():
            sheet = getattr(config.sensor, triad)
            if sheet is not None and sheet.unit != unit:
                raise ConfigError(config.source.problem(("sensor",), (
                    f"{path.name} is a {kind.name}, whose {triad} is in {words}; the sensor is "
                    f"stated with {_stated(sheet)}. Write {WRITE}, or name logs of raw counts")))


def _stated(sheet: AccelerometerSheet | GyroscopeSheet) -> str:
    """The first key of a data sheet as it is written."""
    stated = sheet.model_dump(exclude_none=True)
    name, value = min(stated.items(), key=lambda item: item[0] in ("bits", "encoding"))
    return f"`{name}: {value:g}`" if isinstance(value, float) else f"`{name}: {value}`"
