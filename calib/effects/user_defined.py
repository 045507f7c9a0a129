"""User-defined effects: an expression in logged columns, or a Python function.

Both give a value (n, 3) for the conditions of n rows, and for the shape parameter where there is
one. A Python function has the signature ``f(at)`` or ``f(at, shape)``; it sees copies that it
cannot write to.
"""

import ast
from collections.abc import Callable, Mapping
from dataclasses import fields, replace
from types import TracebackType
from typing import Literal

import numpy as np

from calib.effects.effect import Effect, Page, Shape, per_axis
from calib.effects.expression import NEEDS, Expression, on_axis
from calib.errors import CalibrationError, Undetermined
from calib.poses.conditions import Conditions
from calib.poses.imu_log import AXES, FloatArray, Triad

Per = Literal["axis", "common", "matrix", "reference"]
ValueOf = Callable[..., FloatArray]

START_SHARES = (0.5, 0.05, 0.15, 0.25, 0.35, 0.65, 0.75, 0.85, 0.95)
"""Shares between the bounds, on a logarithmic scale, at which a shape parameter is tried, in order.
Numerical: every value between the bounds has a start within 0.08 of them; within 0.1, three of 16
supply knees (``tests/calib/diagnosis/test_naming_rules.py``) end at a straight line."""

PARAMETERS: Mapping[Per, tuple[str, ...]] = {
    "axis": AXES,
    "common": ("common",),
    "matrix": tuple(f"{k}{j}" for k in AXES for j in AXES),
    "reference": ("common",),
}

FORMULAS: Mapping[Per, str] = {
    "axis": "e_k = c_k · ({})",
    "common": "e = c · ({})",
    "matrix": "e_k = Σ_j c_kj · ({})_j",
    "reference": "m → m + c · ({})",
}
"""The error as a formula, to be completed with the expression or the name of the function."""


def shape_between(name: str, unit: str, low: float, high: float) -> Shape:
    """A shape parameter with positive bounds.

    Parameters
    ----------
    name, unit : str
    low, high : float
        The bounds, in ``unit``.

    Returns
    -------
    Shape
        Its starts divide the bounds by their logarithm (``START_SHARES``).

    Raises
    ------
    CalibrationError
        The bounds are not positive, or not in order.
    """
    if not 0 < low < high:
        raise CalibrationError(
            f"the shape parameter '{name}' lies between {low:g} and {high:g}; two positive bounds "
            f"are expected, the lower first"
        )
    starts = tuple(float(low * (high / low) ** share) for share in START_SHARES)
    return Shape(name, unit, starts, (low, high))


def user_effect(
    name: str,
    value: ValueOf,
    per: Per,
    unit: str,
    triad: Triad | None,
    shape: Shape | None = None,
) -> Effect:
    """An effect made of ``value``.

    On the accelerometer the specific force is the very vector that it measures, when it is fitted
    as when it corrects.

    Parameters
    ----------
    name : str
    value : Expression or callable
        Gives (n, 3) for the conditions of n rows, and the shape parameter where there is one.
    per : str
        ``axis``, one parameter for each axis times its own value; ``common``, one for all three;
        ``matrix``, nine, ``e_k = Σ_j c_kj · value_j``; ``reference``, one on the reference
        magnitude (the value of the x axis).
    unit : str
        Of every parameter, ``{u}`` standing for the SI unit of the triad.
    triad : str or None
        The triad it is for, None for both.
    shape : Shape or None

    Returns
    -------
    Effect
        Evaluating it raises :class:`calib.errors.Undetermined` where a Python function fails.
    """
    names, runs = (value.names, value.runs) if isinstance(value, Expression) else ((), ())
    columns = value.columns if isinstance(value, Expression) else ()
    measures_force = triad == "accelerometer"
    checked = value if isinstance(value, Expression) else _guarded(name, value)

    def values(at: Conditions, *shapes: float) -> FloatArray:
        return checked(replace(at, force=at.vector) if measures_force else at, *shapes)

    arranged: Mapping[Per, Callable[[FloatArray, Conditions], FloatArray]] = {
        "axis": lambda v, _: per_axis(v),
        "common": lambda v, _: v[:, :, None],
        "matrix": lambda v, _: np.einsum("ki,nj->nkij", np.eye(3), v).reshape(len(v), 3, 9),
        "reference": lambda v, at: v[:, :1] * (at.magnitude > 0)[:, None],
    }
    of_bench = per == "reference" or bool(runs)
    return Effect(
        name=name,
        parameters=PARAMETERS[per],
        unit=unit,
        columns=lambda at, *shapes: arranged[per](values(at, *shapes), at),
        acts_on="reference" if per == "reference" else "sensor",
        only_for=() if triad is None else (triad,),
        needs=tuple(dict.fromkeys(need for each, need in NEEDS.items()
                                  if each in names and not (measures_force and need == "force"))),
        logged=columns,
        pasts=value.pasts if isinstance(value, Expression) else (),
        belongs_to="bench" if of_bench else "session" if "time_s" in names else "sensor",
        physics="Your own effect.",
        shape=shape,
        follows_words=value.text if isinstance(value, Expression) else "",
        page=Page(
            formula=FORMULAS[per].format(value.text if isinstance(value, Expression) else name),
            typical={},
            source="your configuration",
            confounded="see the aliases that the diagnosis lists",
            separates="poses in which its columns change while everything else stays",
            expressions=_expressions(value, per),
        ),
    )


def _expressions(value: ValueOf, per: Per) -> tuple[str, ...]:
    """The columns as expressions; none for a Python function, or where the past counts."""
    if not isinstance(value, Expression) or value.pasts:
        return ()
    if per == "matrix":
        return tuple(ast.unparse(on_axis(value.tree, j)) for j in range(len(AXES)))
    return (value.text,)


class UsersCode:
    """A stretch in which a user's own code runs: whatever it raises is named, like bad input.

    An interrupt passes, and so do a want of memory and an error that has words of its own.

    Parameters
    ----------
    said : callable
        From the exception's type and words to the error that is raised instead.
    """

    def __init__(self, said: Callable[[str], CalibrationError]) -> None:
        self._said = said

    def __enter__(self) -> None:
        pass

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None,
                 _trace: TracebackType | None) -> None:
        passing = KeyboardInterrupt, MemoryError, CalibrationError
        if kind is not None and not issubclass(kind, passing):
            raise self._said(f"{kind.__name__}: {error}") from error


def _guarded(name: str, function: ValueOf) -> ValueOf:
    """A user's function, whose faults are named and which cannot write to what it is given."""

    def value(at: Conditions, *shapes: float) -> FloatArray:
        with UsersCode(lambda raised: Undetermined(
                f"effects.{name}: the Python function raised {raised}.")):
            values = np.asarray(function(read_only(at), *shapes), dtype=float)
        if values.shape != at.vector.shape:
            raise Undetermined(
                f"effects.{name}: the Python function gives an array of shape {values.shape}, "
                f"{at.vector.shape} is expected: a value for each row and axis."
            )
        return values

    return value


def read_only(at: Conditions) -> Conditions:
    """Copies of the conditions that cannot be written to."""
    arrays = {each.name: _unwritable(getattr(at, each.name)) for each in fields(at)
              if each.name != "columns"}
    return Conditions(**arrays, columns={name: _unwritable(values)
                                         for name, values in at.columns.items()})


def _unwritable(values: FloatArray) -> FloatArray:
    copy = np.array(values)
    copy.setflags(write=False)
    return copy


def fault_of_user_effect(effect: Effect, at: Conditions) -> str | None:
    """Fault of the columns of a user's effect on these rows, or None.

    Checked are finite values, and that every row depends on itself only.

    Parameters
    ----------
    effect : Effect
    at : Conditions
        Of n rows.

    Returns
    -------
    str or None
        The predicate of a sentence about the effect.

    Raises
    ------
    Undetermined
        The effect's Python function raised, or gives an array of another shape than (n, 3).
    """
    n = len(at)
    columns = effect.evaluate(at)
    bad = ~np.isfinite(columns.reshape(n, -1)).all(axis=1)
    if bad.any():
        absent = [name for name in effect.logged if not np.isfinite(at.column(name)).all()]
        why = (f"The column {absent[0]} is not complete there" if absent else
               "A logarithm, a root or a quotient may have no value there")
        return f"is not a number in {int(bad.sum())} of {n} poses. {why}"
    if n > 1 and not np.allclose(effect.evaluate(at.take(slice(None, None, 2))), columns[::2]):
        return "changes in a pose when other poses are left out; each must depend on itself only"
    return None
