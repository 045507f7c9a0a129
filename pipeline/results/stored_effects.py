"""User-defined effects stored in a results.json."""

from collections.abc import Mapping
from pathlib import Path

from calib.effects.effect import Effect
from calib.effects.expression import BadExpression, read_expression
from calib.effects.user_defined import ValueOf, user_effect
from calib.errors import Undetermined
from calib.poses.conditions import Conditions
from calib.poses.imu_log import FloatArray, Triad
from pipeline.errors import UnreadableInput
from pipeline.results.schema.triad import UserEffect
from pipeline.stages.user_effects import (
    python_sha256,
    require_function,
    shape_of,
    users_function,
    why_not_run,
)


def stored_effects(
    stored: Mapping[str, UserEffect], triad: Triad, folder: Path, allow_python: bool
) -> dict[str, Effect]:
    """The user-defined effects stored in a results.json for ``triad``, by name.

    ``folder`` is that of the results. Without ``allow_python`` a Python effect is present by its
    name, parameters and unit; its evaluation is refused.

    Raises
    ------
    UnreadableInput
        The Python file is not there, or not the one that was fitted.
    CalibrationError
        An expression or a file cannot be read.
    """
    effects = {}
    for name, one in stored.items():
        shapes = one.shapes or {}
        if one.expression is not None:
            value: ValueOf = read_expression(one.expression, tuple(shapes))
        elif one.python is None:
            raise BadExpression(f"effects.{name}: neither an expression nor a function is stated")
        elif allow_python:
            value = users_function(_same_file(one.python, one.python_sha256, folder), one.python)
        else:
            value = _refused(name, one.python)
        effects[name] = user_effect(name, value, one.per, one.unit, triad, shape_of(shapes))
    return effects


def _refused(name: str, python: str) -> ValueOf:
    def value(_at: Conditions, *_shape: float) -> FloatArray:
        path = Path(python.partition(":")[0])
        raise Undetermined(f"effects.{name}: {why_not_run(python, path)}.")

    return value


def _same_file(python: str, expected: str | None, folder: Path) -> Path:
    """The file that was fitted: beside the results, beside the configuration, or here."""
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
