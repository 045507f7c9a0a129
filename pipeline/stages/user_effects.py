"""User-defined effects, from the ``effects:`` section of a configuration.

An expression is parsed, never run as code. A Python file runs only when the configuration names
it and the command was given ``--allow-python``; results.json keeps its hash, and a file that has
changed since is refused.
"""

import ast
import hashlib
import importlib.util
from collections.abc import Mapping
from dataclasses import replace
from importlib.machinery import SourceFileLoader
from pathlib import Path
from typing import Any

from calib.effects.effect import Effect, Shape
from calib.effects.expression import (
    BadExpression,
    Expression,
    read_expression,
)
from calib.effects.user_defined import (
    UsersCode,
    ValueOf,
    shape_between,
    user_effect,
)
from calib.errors import CalibrationError
from calib.poses.imu_log import Triad
from pipeline.config.load import Config
from pipeline.config.messages import ConfigProblem, config_error
from pipeline.config.schema import EffectSection
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
                expression_of(section)
                if section.expression is not None
                else _python_function(config.source.path.parent, section, allow_python)
            )
            effects[name] = replace(user_effect(
                name, value, section.per, section.unit, triad, shape_of(section.shapes)),
                alike=section.alike)
        except CalibrationError as error:
            problems.append(ConfigProblem(("effects", name), error))
    if problems:
        raise config_error(config.source, problems)
    return effects


def expression_of(section: EffectSection) -> Expression:
    """The expression of an effect that has one.

    Raises
    ------
    BadExpression
        It cannot be read; with the nearest right name.
    """
    assert section.expression is not None
    try:
        return read_expression(section.expression, tuple(section.shapes))
    except BadExpression as error:
        meant = nearest_name(error.wrong, error.right)
        raise BadExpression(f"{error}{meant}") from error


def shape_of(shapes: Mapping[str, tuple[str, float, float]]) -> Shape | None:
    """The shape parameter of an effect, None where it has none, by its name, unit and bounds.

    Raises
    ------
    CalibrationError
        The bounds are none.
    """
    for name, (unit, low, high) in shapes.items():
        return shape_between(name, unit, low, high)
    return None


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
    """Hash of the bytes of a user's file, which identifies its version."""
    return hashlib.sha256((folder / python.partition(":")[0]).read_bytes()).hexdigest()


def _python_function(folder: Path, section: EffectSection, allow_python: bool) -> ValueOf:
    assert section.python is not None  # the rules of the section: an expression or a function
    if not allow_python:
        file = folder / section.python.partition(":")[0]
        raise CalibrationError(why_not_run(section.python, file))
    return users_function(require_function(folder, section.python), section.python)


def why_not_run(python: str, path: Path) -> str:
    """Reason why the code in ``path`` is not run, and how to allow it."""
    return (f"'{python}' is Python code, which runs only when you allow it: add --allow-python to "
            f"the command if you trust {path}")


class SourceOnly(SourceFileLoader):
    """Reads and writes no bytecode: what runs is the file whose hash the results store."""

    def path_stats(self, path: str) -> Mapping[str, Any]:
        """Raises OSError: without times of the file there is no bytecode of it."""
        raise OSError(path)


def users_function(path: Path, python: str) -> ValueOf:
    """The function that ``python`` names in the file ``path``, which is run.

    Raises
    ------
    CalibrationError
        The file cannot be run.
    """
    loader = SourceOnly(path.stem, str(path))
    spec = importlib.util.spec_from_file_location(path.stem, path, loader=loader)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    with UsersCode(lambda raised: CalibrationError(f"{path} cannot be used: {raised}")):
        spec.loader.exec_module(module)
    function: ValueOf = getattr(module, python.partition(":")[2])
    return function
