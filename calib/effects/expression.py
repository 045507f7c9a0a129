"""Expressions in what was logged: read by Python's parser, evaluated here node by node.

Nothing runs but what is listed: numbers, names, + - * / **, a few functions of one argument, and
``run('NAME')``, which is 1 in the poses of that run and 0 elsewhere, and ``lag(COLUMN, SECONDS)``,
what follows a logged column with a time constant.

    x, y, z, s                     components of the vector; s is the axis's own
    fx, fy, fz, f                  specific force, likewise
    others                         product of the other two components of the vector
    px, py, pz, p                  what the axes sensed in the pose before
    other_x, other_y, other_z      nominal reading of the other triad, SI
    vibration                      variance of the accelerometer within the pose, axes summed
    time_s, spin_rad_s, magnitude, pi, every logged column and every shape parameter by its name
"""

import ast
import copy
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from calib.effects.effect import Need
from calib.errors import CalibrationError
from calib.poses.conditions import OTHER_TRIAD, RUN_COLUMN, Conditions
from calib.poses.imu_log import FloatArray
from calib.poses.lagged import Lag, lag_name

LONGEST_EXPRESSION = 500  #: characters; a limit of time and memory
LARGEST_POWER = 8  #: so that LARGEST_NUMBER to this power is a number; numerical
LARGEST_NUMBER = 1e30  #: its eighth power is still a number; numerical

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
RUN, LAGGED = "run", "lag"
#: Name -> field of the conditions and, of one axis, its column.
VECTORS: dict[str, tuple[str, int | None]] = {
    f"{letter}{axis}" if letter else axis: (field, "xyz".index(axis))
    for letter, field in (("", "vector"), ("f", "force"), ("p", "previous"))
    for axis in "xyz"
} | {"s": ("vector", None), "f": ("force", None), "p": ("previous", None)}
OF_POSE = ("time_s", "spin_rad_s", "magnitude")
NEEDS: dict[str, Need] = {
    **dict.fromkeys(("f", "fx", "fy", "fz"), "force"),
    **dict.fromkeys(("p", "px", "py", "pz"), "previous"),
    "vibration": "vibration",
    "time_s": "time",
    "spin_rad_s": "plate",
    "magnitude": "plate",
}
OTHERS = "others"
OF_AXIS = {
    "s": "xyz",
    OTHERS: ("y*z", "z*x", "x*y"),
    **{letter: tuple(f"{letter}{axis}" for axis in "xyz") for letter in "fp"},
}
"""Names of an axis's own components, and which they are on x, y and z."""

KNOWN_NAMES = (*VECTORS, OTHERS, *OTHER_TRIAD, "vibration", *OF_POSE, "pi")
"""Names of an expression that are neither logged columns nor shape parameters."""


class BadExpression(CalibrationError):
    """An expression that cannot be read, with what is wrong and what is allowed.

    Where it is a name, ``wrong`` is that name and ``right`` are those that it could be.
    """

    def __init__(self, message: str, wrong: str = "", right: Sequence[str] = ()) -> None:
        super().__init__(message)
        self.wrong = wrong
        self.right = tuple(right)


@dataclass(frozen=True)
class Expression:
    """A checked expression.

    Attributes
    ----------
    text : str
        As the user wrote it.
    tree : ast.expr
    names, runs, shapes : tuple of str
        The columns, runs and shape parameters that it uses.
    lags : tuple of (str, float)
        The columns that it uses with a time constant, s.
    """

    text: str
    tree: ast.expr
    names: tuple[str, ...]
    runs: tuple[str, ...] = ()
    shapes: tuple[str, ...] = ()
    lags: tuple[Lag, ...] = ()

    @property
    def columns(self) -> tuple[str, ...]:
        """The logged columns it uses."""
        known = (*KNOWN_NAMES, *self.shapes)
        return tuple(name for name in self.names if name not in known)

    def __call__(self, at: Conditions, *shape: float) -> FloatArray:
        """Value for every row and axis, shape (n, 3), with these values of the shape parameters."""
        shapes = dict(zip(self.shapes, shape, strict=True))
        with np.errstate(all="ignore"):  # what is not finite is reported as such, with its name
            value = _evaluate(self.tree, at, shapes)
        return np.broadcast_to(value, at.vector.shape).astype(float)


def read_expression(text: str, shapes: Sequence[str] = ()) -> Expression:
    """Read and check an expression.

    Parameters
    ----------
    text : str
        The expression.
    shapes : sequence of str
        The names of its shape parameters.

    Returns
    -------
    Expression

    Raises
    ------
    BadExpression
        It is not an expression, is too long, uses something that is not allowed, lacks a shape
        parameter, or a shape parameter has a name that means something else.
    """
    if len(text) > LONGEST_EXPRESSION:
        raise BadExpression(
            f"the expression is {len(text)} characters long, at most {LONGEST_EXPRESSION} are "
            f"read. Write it as a Python function instead"
        )
    try:
        tree = ast.parse(text.strip(), mode="eval").body
    except (SyntaxError, ValueError, RecursionError, MemoryError) as error:
        problem = getattr(error, "msg", error)
        raise BadExpression(f"'{text}' is not an expression ({problem})") from error
    names: dict[str, None] = {}
    runs: dict[str, None] = {}
    lags: dict[Lag, None] = {}
    _check(tree, names, runs, lags)
    for shape in shapes:
        if shape in KNOWN_NAMES or shape in FUNCTIONS or shape == RUN:
            raise BadExpression(f"the shape parameter '{shape}' has a name that means something "
                                f"else already; choose another")
        if shape not in names:
            raise BadExpression(f"the shape parameter '{shape}' is not used in '{text}'", shape,
                                [name for name in names if name not in KNOWN_NAMES])
    return Expression(text, tree, tuple(names), tuple(runs), tuple(shapes), tuple(lags))


def substituted(tree: ast.expr, values: Mapping[str, ast.expr]) -> ast.expr:
    """A copy of ``tree`` with these expressions in the place of names."""

    class Substitution(ast.NodeTransformer):
        def visit_Name(self, node: ast.Name) -> ast.expr:
            return copy.deepcopy(values.get(node.id, node))

    result: ast.expr = Substitution().visit(copy.deepcopy(tree))
    return result


def on_axis(tree: ast.expr, axis: int) -> ast.expr:
    """What ``tree`` is on axis 0, 1 or 2: the axis's own components by their names."""
    return substituted(tree, {name: ast.parse(names[axis], mode="eval").body
                              for name, names in OF_AXIS.items()})


def _check(
    node: ast.expr, names: dict[str, None], runs: dict[str, None], lags: dict[Lag, None]
) -> None:
    match node:
        case ast.Constant(value=int() | float() as number) if not isinstance(number, bool):
            if abs(number) > LARGEST_NUMBER:
                raise BadExpression(f"a number in the expression is larger than {LARGEST_NUMBER:g}")
        case ast.Name(id=name):
            names[name] = None
        case ast.UnaryOp(op=ast.USub() | ast.UAdd(), operand=operand):
            _check(operand, names, runs, lags)
        case ast.BinOp(left=left, op=operator, right=right) if type(operator) in OPERATORS:
            if isinstance(operator, ast.Pow):
                _check_power(right)
            _check(left, names, runs, lags)
            _check(right, names, runs, lags)
        case ast.Call(
            func=ast.Name(id="run"), args=[ast.Constant(value=str() as run)], keywords=[]
        ):
            runs[run] = None
        case ast.Call(
            func=ast.Name(id="lag"), keywords=[],
            args=[ast.Name(id=name), ast.Constant(value=int() | float() as tau)],
        ) if tau > 0 and name not in KNOWN_NAMES:
            names[name] = None
            lags[name, float(tau)] = None
        case ast.Call(func=ast.Name(id=name), args=[argument], keywords=[]) if name in FUNCTIONS:
            _check(argument, names, runs, lags)
        case _:
            called = node.func if isinstance(node, ast.Call) else None
            raise BadExpression(
                f"'{ast.unparse(node)}' is not allowed in an expression; allowed are numbers, "
                f"names of columns, + - * / **, {', '.join(FUNCTIONS)}, run('NAME') and "
                f"lag(COLUMN, SECONDS)",
                called.id if isinstance(called, ast.Name) else "", (*FUNCTIONS, RUN, LAGGED),
            )


def _check_power(exponent: ast.expr) -> None:
    value = exponent.operand if isinstance(exponent, ast.UnaryOp) else exponent
    if not (isinstance(value, ast.Constant) and isinstance(value.value, int | float)):
        raise BadExpression("an exponent must be a number, as in time_s**2")
    if abs(value.value) > LARGEST_POWER:
        raise BadExpression(f"the exponent {value.value:g} is larger than {LARGEST_POWER}")


def _evaluate(node: ast.expr, at: Conditions, shapes: Mapping[str, float]) -> FloatArray:
    match node:
        case ast.Constant(value=int() | float() as number):
            return np.asarray(float(number))
        case ast.Name(id=name):
            return np.asarray(shapes[name]) if name in shapes else _named(name, at)
        case ast.UnaryOp(op=operator, operand=operand):
            inner = _evaluate(operand, at, shapes)
            return np.negative(inner) if isinstance(operator, ast.USub) else inner
        case ast.BinOp(left=left, op=operator, right=right):
            return np.asarray(OPERATORS[type(operator)](
                _evaluate(left, at, shapes), _evaluate(right, at, shapes)))
        case ast.Call(func=ast.Name(id="run"), args=[ast.Constant(value=str() as run)]):
            elsewhere = np.zeros(len(at))
            return np.asarray(at.columns.get(RUN_COLUMN + run, elsewhere)[:, None])
        case ast.Call(
            func=ast.Name(id="lag"),
            args=[ast.Name(id=name), ast.Constant(value=int() | float() as tau)],
        ):
            return at.column(lag_name(name, float(tau)))[:, None]
        case ast.Call(func=ast.Name(id=name), args=[argument]):
            return np.asarray(FUNCTIONS[name](_evaluate(argument, at, shapes)))
    raise AssertionError(ast.dump(node))  # _check has let through what is not evaluated


def _named(name: str, at: Conditions) -> FloatArray:
    """A name's value: (n, 3) where each axis has its own, else (n, 1)."""
    if name in VECTORS:
        field, axis = VECTORS[name]
        vectors: FloatArray = getattr(at, field)
        return vectors if axis is None else vectors[:, [axis]]
    if name == OTHERS:
        return np.roll(at.vector, 1, axis=1) * np.roll(at.vector, 2, axis=1)
    if name == "pi":
        return np.asarray(np.pi, float)
    if name == "vibration":
        return np.asarray(at.vibration.sum(axis=1)[:, None])
    if name in OF_POSE:
        values: FloatArray = getattr(at, name)
        return np.asarray(values[:, None])
    return at.column(name)[:, None]
