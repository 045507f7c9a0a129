"""User-defined effects, from the ``effects:`` section of a configuration or from results.json.

An expression is parsed, never run as code. A Python file runs only when the configuration names
it and the command was given ``--allow-python``; results.json keeps its hash, and a file that has
changed since is refused.
"""

import ast
import hashlib
import importlib.util
from collections.abc import Iterator, Mapping
from importlib.machinery import SourceFileLoader
from pathlib import Path
from typing import Any

from calib.effects.arithmetic import FUNCTIONS
from calib.effects.effect import Effect, Shape
from calib.effects.expression import (
    KNOWN_NAMES,
    BadExpression,
    Expression,
    read_expression,
)
from calib.effects.user_defined import (
    PARAMETERS,
    UsersCode,
    ValueOf,
    shape_between,
    user_effect,
)
from calib.errors import CalibrationError, Undetermined
from calib.poses.conditions import Conditions
from calib.poses.imu_log import FloatArray, Triad
from pipeline.config.load import Config
from pipeline.config.messages import ConfigProblem, config_error
from pipeline.config.schema import EffectSection
from pipeline.errors import UnreadableInput
from pipeline.stages.logged_columns import logged_columns
from pipeline.text.names import nearest_name


def user_effects(config: Config, triad: Triad, allow_python: bool) -> dict[str, Effect]:
    """The effects that ``config`` defines for ``triad``, by name.

    Raises
    ------
    ConfigError
        An expression cannot be read, or a Python function cannot be had; with the line of each.
    """
    effects: dict[str, Effect] = {}
    problems = []
    for name, section in config.effects.items():
        if section.triad not in (None, triad):
            continue
        try:
            value = (
                _expression(section)
                if section.expression is not None
                else _python_function(config.source.path.parent, section, allow_python)
            )
            effects[name] = user_effect(
                name, value, section.per, section.unit, triad, _shape(section.shapes))
        except CalibrationError as error:
            problems.append(ConfigProblem(("effects", name), error))
    if problems:
        raise config_error(config.source, problems)
    return effects


def _expression(section: EffectSection) -> Expression:
    assert section.expression is not None
    try:
        return read_expression(section.expression, tuple(section.shapes))
    except BadExpression as error:
        meant = nearest_name(error.wrong, error.right)
        raise BadExpression(f"{error}{meant}") from error


def _shape(shapes: Mapping[str, tuple[str, float, float]]) -> Shape | None:
    for name, (unit, low, high) in shapes.items():
        return shape_between(name, unit, low, high)
    return None


# --- before anything slow ------------------------------------------------------------------------


def check_user_effects(config: Config) -> None:
    """Refuse effects that no pose can have; no Python file runs.

    Raises
    ------
    ConfigError
        With the line of every expression or file that cannot be read, and of every name in them
        that the logs do not have, with the nearest that they have.
    """
    problems = []
    for name, section in config.effects.items():
        where = ("effects", name)
        try:
            _shape(section.shapes)
            if section.python is not None:
                require_function(config.source.path.parent, section.python)
                continue
            expression = _expression(section)
        except CalibrationError as error:
            problems.append(ConfigProblem(where, error))
            continue
        problems += [ConfigProblem((*where, "expression"), problem)
                     for problem in _unknown_names(config, section, expression)]
    if problems:
        raise config_error(config.source, problems)


def _unknown_names(
    config: Config, section: EffectSection, expression: Expression
) -> Iterator[str]:
    columns = logged_columns(config, section.triad)
    if columns is not None:
        right = (*columns, *KNOWN_NAMES, *section.shapes, *FUNCTIONS)
        for name in expression.columns:
            if name not in columns:
                listed = ", ".join(columns) or "no further column"
                yield (f"'{name}' is no logged column, name or shape parameter"
                       f"{nearest_name(name, right)}. The logs have: {listed}. Log it, or name "
                       f"it under `shapes` with its unit and bounds.")
    runs = _runs(config, section.triad)
    for run in expression.runs:
        if run not in runs:
            yield (f"run('{run}') is no run{nearest_name(run, runs)}. There are: "
                   f"{', '.join(runs)}.")


def _runs(config: Config, triad: Triad | None) -> tuple[str, ...]:
    """Names of the runs of one triad, or of both."""
    return tuple(dict.fromkeys(run.rate for path, run in config.placed_runs()
                               if triad in (None, path[0])))


# --- Python --------------------------------------------------------------------------------------


def require_function(folder: Path, python: str) -> Path:
    """The file of ``FILE.py:FUNCTION`` in ``folder``, in which such a function is defined.

    Raises
    ------
    CalibrationError
        There is no such file, or no such function in it; nothing is run.
    """
    file, _, function = python.partition(":")
    path = folder / file
    if not function or not path.is_file():
        raise CalibrationError(
            f"'{python}' does not name a function; write FILE.py:FUNCTION with a file beside the "
            f"configuration"
        )
    try:
        body = ast.parse(path.read_bytes()).body
    except (SyntaxError, ValueError) as error:
        raise CalibrationError(f"{path} cannot be used: {type(error).__name__}: {error}") from error
    defined = [node.name for node in body if isinstance(node, ast.FunctionDef)]
    if function not in defined:
        raise CalibrationError(
            f"{path} defines no function '{function}'{nearest_name(function, defined)}"
        )
    return path


def python_sha256(folder: Path, python: str) -> str:
    """What tells one version of a user's file from another: the hash of its bytes."""
    return hashlib.sha256((folder / python.partition(":")[0]).read_bytes()).hexdigest()


def _python_function(folder: Path, section: EffectSection, allow_python: bool) -> ValueOf:
    assert section.python is not None  # the rules of the section: an expression or a function
    if not allow_python:
        file = folder / section.python.partition(":")[0]
        raise CalibrationError(_not_allowed(section.python, file))
    return _imported(require_function(folder, section.python), section.python)


def _not_allowed(python: str, path: Path) -> str:
    return (f"'{python}' is Python code, which runs only when you allow it: add --allow-python to "
            f"the command if you trust {path}")


class SourceOnly(SourceFileLoader):
    """Reads no bytecode and writes none: what runs is the file whose hash the results store."""

    def path_stats(self, path: str) -> Mapping[str, Any]:
        """Raises OSError: without times of the file there is no bytecode of it."""
        raise OSError(path)


def _imported(path: Path, python: str) -> ValueOf:
    loader = SourceOnly(path.stem, str(path))
    spec = importlib.util.spec_from_file_location(path.stem, path, loader=loader)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    with UsersCode(lambda raised: CalibrationError(f"{path} cannot be used: {raised}")):
        spec.loader.exec_module(module)
    function: ValueOf = getattr(module, python.partition(":")[2])
    return function


# --- results.json --------------------------------------------------------------------------------


def stored_effects(
    stored: Mapping[str, Mapping[str, Any]], triad: Triad, folder: Path, allow_python: bool
) -> dict[str, Effect]:
    """The user-defined effects that a results.json carries for ``triad``, by name.

    ``folder`` is that of the results. Without ``allow_python`` a Python effect is there by its
    name, parameters and unit; to evaluate it is refused.

    Raises
    ------
    UnreadableInput
        The Python file is not there, or not the one that was fitted.
    CalibrationError
        An expression or a file cannot be read.
    """
    effects = {}
    for name, one in stored.items():
        shapes = one.get("shapes") or {}
        if one["expression"] is not None:
            value: ValueOf = read_expression(one["expression"], tuple(shapes))
        elif allow_python:
            value = _imported(_same_file(one, folder), one["python"])
        else:
            value = _refused(name, one["python"])
        if one["per"] not in PARAMETERS:
            raise BadExpression(f"effects.{name}: per '{one['per']}' is not known")
        effects[name] = user_effect(name, value, one["per"], one["unit"], triad, _shape(shapes))
    return effects


def _refused(name: str, python: str) -> ValueOf:
    def value(_at: Conditions, *_shape: float) -> FloatArray:
        path = Path(python.partition(":")[0])
        raise Undetermined(f"effects.{name}: {_not_allowed(python, path)}.")

    return value


def _same_file(stored: Mapping[str, Any], folder: Path) -> Path:
    """The file that was fitted: beside the results, beside the configuration, or here."""
    python, expected = stored["python"], stored.get("python_sha256")
    places = [folder, folder.parent, Path()]
    for place in places:
        if (place / python.partition(":")[0]).is_file():
            path = require_function(place, python)
            if python_sha256(place, python) != expected:
                raise UnreadableInput(
                    f"{path}: is not the file that was fitted (its hash is another). Put that one "
                    f"there, or run the calibration anew."
                )
            return path
    looked = ", ".join(str(place) for place in places)
    raise UnreadableInput(
        f"'{python}' was not found in {looked}. Put the file that was fitted into one of them."
    )


