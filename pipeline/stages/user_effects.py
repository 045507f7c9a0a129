"""Users' own effects, from the ``effects:`` section of a configuration.

An expression is parsed, never run as code. A Python file runs only when the configuration names
it and the command was given ``--allow-python``.
"""

import importlib.util
from collections.abc import Callable, Mapping
from pathlib import Path

from calib.effects.effect import Effect
from calib.effects.user_defined import own_effect, read_expression
from calib.errors import CalibrationError
from calib.poses.conditions import Conditions
from calib.poses.imu_log import FloatArray
from pipeline.config.load import Config
from pipeline.config.schema import EffectSection
from pipeline.errors import ConfigError

RAISED_BY_USERS_CODE = (
    ArithmeticError,
    AttributeError,
    ImportError,
    LookupError,
    NameError,
    OSError,
    RuntimeError,
    SyntaxError,
    TypeError,
    ValueError,
)
"""What a user's own file can be expected to raise; it is named, like any other bad input."""

ValueOf = Callable[[Conditions], FloatArray]


def own_effects(config: Config, allow_python: bool) -> dict[str, Effect]:
    """The effects that ``config`` defines, by name.

    Raises
    ------
    ConfigError
        An expression cannot be read, or a Python function cannot be had; with the line of each.
    """
    found: dict[str, Effect] = {}
    problems = []
    for name, asked in config.effects.items():
        try:
            value = (
                read_expression(asked.expression)
                if asked.expression is not None
                else _python_function(config.source.path.parent, asked, allow_python)
            )
        except CalibrationError as error:
            problems.append(config.source.problem(("effects", name), f"{error}."))
            continue
        found[name] = own_effect(name, value, asked.per, asked.unit, asked.triad)
    if problems:
        raise ConfigError(*problems)
    return found


def stored_effects(given: Mapping[str, Mapping[str, str]]) -> dict[str, Effect]:
    """The effects that a results.json carries as expressions, by name."""
    return {
        name: own_effect(
            name,
            read_expression(each["expression"]),
            each["per"],  # type: ignore[arg-type]
            each["unit"],
            None,
        )
        for name, each in given.items()
    }


def _python_function(folder: Path, asked: EffectSection, allow_python: bool) -> ValueOf:
    assert asked.python is not None  # the rules of the section: an expression or a function
    file, _, function = asked.python.partition(":")
    path = folder / file
    if not allow_python:
        raise CalibrationError(
            f"'{asked.python}' is Python code, which runs only when you allow it: add "
            f"--allow-python to the command if you trust {path}"
        )
    if not function or not path.is_file():
        raise CalibrationError(
            f"'{asked.python}' does not name a function; write FILE.py:FUNCTION with a file "
            f"beside the configuration"
        )
    spec = importlib.util.spec_from_file_location(path.stem, path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    try:
        spec.loader.exec_module(module)
        found = getattr(module, function)
    except RAISED_BY_USERS_CODE as error:
        raise CalibrationError(f"{path} cannot be used: {type(error).__name__}: {error}") from error
    if not callable(found):
        raise CalibrationError(f"{path}: '{function}' is not a function")
    return found  # type: ignore[no-any-return]
