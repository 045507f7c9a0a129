"""Users' own effects: an expression in what was logged, or a function of their own.

An expression is read by Python's parser and evaluated here, node by node, from a short list of
what is allowed: numbers, names, + - * / **, and a few functions. Nothing else runs.

    x, y, z        components of the corrected vector      s     the axis's own component
    fx, fy, fz     specific force                          f     along the axis
    time_s, spin_rad_s, magnitude, and every logged column by its name; pi
"""

import ast
from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

import numpy as np

from calib.effects.effect import Effect, Need, Page, per_axis
from calib.errors import CalibrationError
from calib.poses.conditions import Conditions
from calib.poses.imu_log import AXES, TRIADS, FloatArray, Triad

Per = Literal["axis", "common", "reference"]

LONGEST_EXPRESSION = 500
LARGEST_POWER = 8

FUNCTIONS: dict[str, Callable[..., FloatArray]] = {
    "abs": np.abs,
    "cos": np.cos,
    "exp": np.exp,
    "log": np.log,
    "sign": np.sign,
    "sin": np.sin,
    "sqrt": np.sqrt,
    "tanh": np.tanh,
}
OPERATORS: dict[type[ast.operator], Callable[[FloatArray, FloatArray], FloatArray]] = {
    ast.Add: np.add,
    ast.Sub: np.subtract,
    ast.Mult: np.multiply,
    ast.Div: np.divide,
    ast.Pow: np.power,
}
COMPONENTS = {"x": 0, "y": 1, "z": 2}
FORCE_COMPONENTS = {"fx": 0, "fy": 1, "fz": 2}
NEEDS: dict[str, Need] = {
    **dict.fromkeys(("f", *FORCE_COMPONENTS), "force"),
    "time_s": "time",
    "spin_rad_s": "plate",
    "magnitude": "plate",
}
KNOWN_NAMES = (*NEEDS, *COMPONENTS, "s", "pi")
"""Names of an expression that are no logged columns."""


class BadExpression(CalibrationError):
    """An expression that cannot be read, with what is wrong and what is allowed."""


@dataclass(frozen=True)
class Expression:
    """A checked expression; ``names`` are those it uses."""

    text: str
    tree: ast.expr
    names: tuple[str, ...]

    def __call__(self, at: Conditions) -> FloatArray:
        """Value for every row and axis, shape (n, 3)."""
        with np.errstate(all="ignore"):  # what is not finite is reported as such, with its name
            value = _evaluate(self.tree, at)
        return np.broadcast_to(value, at.vector.shape).astype(float)


def read_expression(text: str) -> Expression:
    """Read and check an expression.

    Raises
    ------
    BadExpression
        It is not an expression, or uses something that is not allowed.
    """
    if len(text) > LONGEST_EXPRESSION:
        raise BadExpression(
            f"the expression is {len(text)} characters long, at most {LONGEST_EXPRESSION} are "
            f"read. Write it as a Python function instead"
        )
    try:
        tree = ast.parse(text.strip(), mode="eval").body
    except (SyntaxError, ValueError, RecursionError, MemoryError) as error:
        raise BadExpression(f"'{text}' is not an expression ({error})") from error
    names: dict[str, None] = {}
    _check(tree, names)
    return Expression(text, tree, tuple(names))


def _check(node: ast.expr, names: dict[str, None]) -> None:
    match node:
        case ast.Constant(value=int() | float()) if not isinstance(node.value, bool):
            return
        case ast.Name(id=name):
            names[name] = None
        case ast.UnaryOp(op=ast.USub() | ast.UAdd(), operand=operand):
            _check(operand, names)
        case ast.BinOp(left=left, op=operator, right=right) if type(operator) in OPERATORS:
            if isinstance(operator, ast.Pow):
                _check_power(right)
            _check(left, names)
            _check(right, names)
        case ast.Call(func=ast.Name(id=name), args=[argument], keywords=[]) if name in FUNCTIONS:
            _check(argument, names)
        case _:
            raise BadExpression(
                f"'{ast.unparse(node)}' is not allowed in an expression; allowed are numbers, "
                f"names of columns, + - * / ** and {', '.join(FUNCTIONS)}"
            )


def _check_power(exponent: ast.expr) -> None:
    value = exponent.operand if isinstance(exponent, ast.UnaryOp) else exponent
    if not (isinstance(value, ast.Constant) and isinstance(value.value, int | float)):
        raise BadExpression("an exponent must be a number, as in time_s**2")
    if abs(value.value) > LARGEST_POWER:
        raise BadExpression(f"the exponent {value.value:g} is larger than {LARGEST_POWER}")


def _evaluate(node: ast.expr, at: Conditions) -> FloatArray:
    match node:
        case ast.Constant(value=int() | float() as number):
            return np.asarray(float(number))
        case ast.Name(id=name):
            return _named(name, at)
        case ast.UnaryOp(op=operator, operand=operand):
            inner = _evaluate(operand, at)
            return np.negative(inner) if isinstance(operator, ast.USub) else inner
        case ast.BinOp(left=left, op=operator, right=right):
            return OPERATORS[type(operator)](_evaluate(left, at), _evaluate(right, at))
        case ast.Call(func=ast.Name(id=name), args=[argument]):
            return FUNCTIONS[name](_evaluate(argument, at))
    raise AssertionError(ast.dump(node))  # _check has let through what is not evaluated


def _named(name: str, at: Conditions) -> FloatArray:
    """A name's value: (n, 3) where each axis has its own, else (n, 1)."""
    if name == "s":
        return at.vector
    if name == "f":
        return at.force
    if name in COMPONENTS:
        return at.vector[:, [COMPONENTS[name]]]
    if name in FORCE_COMPONENTS:
        return at.force[:, [FORCE_COMPONENTS[name]]]
    if name == "pi":
        return np.asarray(np.pi)
    of_pose = {"time_s": at.time_s, "spin_rad_s": at.spin_rad_s, "magnitude": at.magnitude}
    return (of_pose[name] if name in of_pose else at.column(name))[:, None]


def own_effect(
    name: str, value: Callable[[Conditions], FloatArray], per: Per, unit: str, triad: Triad | None
) -> Effect:
    """An effect made of ``value``, which gives (n, 3) for the conditions of n rows.

    ``per``: ``axis``, one parameter for each axis times its own value; ``common``, one for all
    three; ``reference``, one on the reference magnitude (the value of the x axis).
    """
    names = value.names if isinstance(value, Expression) else ()
    columns: dict[Per, Callable[[Conditions], FloatArray]] = {
        "axis": lambda at: per_axis(value(at)),
        "common": lambda at: value(at)[:, :, None],
        "reference": lambda at: value(at)[:, :1] * (at.magnitude > 0)[:, None],
    }
    return Effect(
        name=name,
        acts_on="reference" if per == "reference" else "sensor",
        triads=TRIADS if triad is None else (triad,),
        parameters=AXES if per == "axis" else ("common",),
        unit=unit,
        columns=columns[per],
        needs=tuple(dict.fromkeys(NEEDS[name] for name in names if name in NEEDS)),
        logged=tuple(name for name in names if name not in KNOWN_NAMES),
        belongs_to="bench" if per == "reference" else "session" if "time_s" in names else "sensor",
        physics="Your own effect.",
        page=Page(
            formula=name,
            typical={},
            source="your configuration",
            confounded="see the aliases that the diagnosis lists",
            separates="poses in which its columns change while everything else stays",
        ),
    )


def check_own(effect: Effect, at: Conditions) -> str | None:
    """What is wrong with the columns of a user's effect on these rows, or None.

    Checked are the shape, finite values, and that every row depends on itself only.
    """
    n, k = len(at.time_s), len(effect.parameters)
    expected = (n, k) if effect.acts_on == "reference" else (n, 3, k)
    columns = effect.evaluate(at)
    if columns.shape != expected:
        return f"gives an array of shape {columns.shape}, {expected} is expected"
    bad = ~np.isfinite(columns.reshape(n, -1)).all(axis=1)
    if bad.any():
        return (
            f"is not a number in {int(bad.sum())} of {n} poses. Are all its columns logged, and "
            f"is it defined there (logarithms, roots, divisions)?"
        )
    if n > 1 and not np.allclose(effect.evaluate(at.take(slice(None, None, 2))), columns[::2]):
        return "changes in a pose when other poses are left out; each must depend on itself only"
    return None

