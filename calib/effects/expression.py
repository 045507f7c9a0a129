"""Expressions in what was logged: read by Python's parser, evaluated here node by node.

Nothing runs but what is listed: numbers, names, + - * / **, a few functions of one argument, and
``run('NAME')``, which is 1 in the poses of that run and 0 elsewhere; ``column('NAME')`` is the
logged column of any name. What logged columns were until now counts by ``lag(x, SECONDS)``, what
follows x with a time constant, ``play(x, HALF_WIDTH)``, what follows it across a gap, and
``total(x)``, its integral over time; x is made of logged columns.

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
from functools import partial

import numpy as np

from calib.effects.arithmetic import FUNCTIONS, OPERATORS, value_of
from calib.effects.effect import Need
from calib.errors import CalibrationError
from calib.poses.conditions import OTHER_TRIAD, RUN_COLUMN, Conditions
from calib.poses.imu_log import FloatArray
from calib.poses.past import PAST, Past, across_gap, behind, total

LONGEST_EXPRESSION = 500  #: characters; a limit of time and memory
LARGEST_POWER = 8  #: so that LARGEST_NUMBER to this power is a number; numerical
LARGEST_NUMBER = 1e30  #: its eighth power is still a number; numerical

RUN = "run"
PASTS: dict[str, Callable[..., FloatArray]] = {"lag": behind, "play": across_gap, "total": total}
"""Functions of the past: of values, times and, but for a total, one positive number."""

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
    pasts : tuple of Past
        The columns that it uses of the past of others.
    """

    text: str
    tree: ast.expr
    names: tuple[str, ...]
    runs: tuple[str, ...] = ()
    shapes: tuple[str, ...] = ()
    pasts: tuple[Past, ...] = ()

    @property
    def columns(self) -> tuple[str, ...]:
        """The logged columns it uses."""
        known = (*KNOWN_NAMES, *self.shapes)
        return tuple(name for name in self.names if name not in known)

    def __call__(self, at: Conditions, *shape: float) -> FloatArray:
        """Value for every row and axis, shape (n, 3), with these values of the shape parameters."""
        shapes = dict(zip(self.shapes, shape, strict=True))
        with np.errstate(all="ignore"):  # what is not finite is reported as such, with its name
            value = value_of(self.tree, partial(_leaf, at=at, shapes=shapes))
        return np.broadcast_to(value, at.vector.shape).astype(float)


def read_expression(text: str, shapes: Sequence[str] = ()) -> Expression:
    """Read and check an expression.

    Parameters
    ----------
    text : str
        The expression.
    shapes : sequence of str
        The names of its shape parameters.

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
        tree = _ColumnsByName().visit(ast.parse(text.strip(), mode="eval").body)
    except (SyntaxError, ValueError, RecursionError, MemoryError) as error:
        problem = getattr(error, "msg", error)
        raise BadExpression(f"'{text}' is not an expression ({problem})") from error
    names: dict[str, None] = {}
    runs: dict[str, None] = {}
    pasts: dict[Past, None] = {}
    _check(tree, names, runs, pasts)
    for shape in shapes:
        if shape in KNOWN_NAMES or shape in FUNCTIONS or shape == RUN:
            raise BadExpression(f"the shape parameter '{shape}' has a name that means something "
                                f"else already; choose another")
        if shape not in names:
            raise BadExpression(f"the shape parameter '{shape}' is not used in '{text}'", shape,
                                [name for name in names if name not in KNOWN_NAMES])
    return Expression(text, tree, tuple(names), tuple(runs), tuple(shapes), tuple(pasts))


class _ColumnsByName(ast.NodeTransformer):
    """Makes ``column('NAME')`` a name, which may then be any text."""

    def visit_Call(self, node: ast.Call) -> ast.AST:
        match node:
            case ast.Call(func=ast.Name(id="column"), keywords=[],
                          args=[ast.Constant(value=str() as name)]) if name not in KNOWN_NAMES:
                return ast.Name(name)
        return self.generic_visit(node)


def substituted(tree: ast.expr, values: Mapping[str, ast.expr]) -> ast.expr:
    """A copy of ``tree`` with these expressions in the place of names."""

    class Substitution(ast.NodeTransformer):
        def visit_Name(self, node: ast.Name) -> ast.expr:
            return copy.deepcopy(values.get(node.id, node))

    result: ast.expr = Substitution().visit(copy.deepcopy(tree))
    return result


def on_axis(tree: ast.expr, axis: int) -> ast.expr:
    """``tree`` on axis 0, 1 or 2: the axis's own components by their names."""
    return substituted(tree, {name: ast.parse(names[axis], mode="eval").body
                              for name, names in OF_AXIS.items()})


def _check(
    node: ast.expr, names: dict[str, None], runs: dict[str, None], pasts: dict[Past, None]
) -> None:
    match node:
        case ast.Constant(value=int() | float() as number) if not isinstance(number, bool):
            if abs(number) > LARGEST_NUMBER:
                raise BadExpression(f"a number in the expression is larger than {LARGEST_NUMBER:g}")
        case ast.Name(id=name):
            names[name] = None
        case ast.UnaryOp(op=ast.USub() | ast.UAdd(), operand=operand):
            _check(operand, names, runs, pasts)
        case ast.BinOp(left=left, op=operator, right=right) if type(operator) in OPERATORS:
            if isinstance(operator, ast.Pow):
                _check_power(right)
            _check(left, names, runs, pasts)
            _check(right, names, runs, pasts)
        case ast.Call(
            func=ast.Name(id="run"), args=[ast.Constant(value=str() as run)], keywords=[]
        ):
            runs[run] = None
        case ast.Call(func=ast.Name(id=name), keywords=[]) if name in PASTS:
            past = _past(node)
            names |= dict.fromkeys(past.logged)
            pasts[past] = None
        case ast.Call(func=ast.Name(id=name), args=[argument], keywords=[]) if name in FUNCTIONS:
            _check(argument, names, runs, pasts)
        case _:
            called = node.func if isinstance(node, ast.Call) else None
            raise BadExpression(
                f"'{ast.unparse(node)}' is not allowed in an expression; allowed are numbers, "
                f"names of columns, + - * / **, {', '.join(FUNCTIONS)}, run('NAME'), "
                f"column('NAME'), lag(x, SECONDS), play(x, HALF_WIDTH) and total(x)",
                called.id if isinstance(called, ast.Name) else "", (*FUNCTIONS, RUN, *PASTS),
            )


def _past(node: ast.Call) -> Past:
    """The column that a call of the past stands for.

    Raises
    ------
    BadExpression
        It is not made of logged columns and, but for a total, one positive number.
    """
    assert isinstance(node.func, ast.Name)
    kind = node.func.id
    numbers = [part.value for part in node.args[1:] if isinstance(part, ast.Constant)
               and isinstance(part.value, int | float) and part.value > 0]
    names: dict[str, None] = {}
    runs: dict[str, None] = {}
    inner: dict[Past, None] = {}
    if node.args:
        _check(node.args[0], names, runs, inner)
    columns = [name for name in names if name != "pi"]
    expected = 0 if kind == "total" else 1
    if not (columns and len(numbers) == len(node.args) - 1 == expected) or (
            runs or inner or {*columns} & {*KNOWN_NAMES}):
        raise BadExpression(
            f"'{ast.unparse(node)}' is not what the past can make; write lag(x, SECONDS), "
            f"play(x, HALF_WIDTH) or total(x), with x made of logged columns and the number above "
            f"zero")
    tree, following = node.args[0], PASTS[kind]

    def values(columns: Mapping[str, FloatArray], time_s: FloatArray) -> FloatArray:
        with np.errstate(all="ignore"):
            driven = value_of(tree, lambda leaf: _pi_or(columns, leaf))
        return following(np.broadcast_to(driven, time_s.shape).astype(float), time_s, *numbers)

    return Past(PAST + ast.unparse(node), tuple(columns), values)


def _pi_or(columns: Mapping[str, FloatArray], leaf: ast.expr) -> FloatArray:
    assert isinstance(leaf, ast.Name)
    return np.asarray(np.pi) if leaf.id == "pi" else columns[leaf.id]


def _check_power(exponent: ast.expr) -> None:
    value = exponent.operand if isinstance(exponent, ast.UnaryOp) else exponent
    if not (isinstance(value, ast.Constant) and isinstance(value.value, int | float)):
        raise BadExpression("an exponent must be a number, as in time_s**2")
    if abs(value.value) > LARGEST_POWER:
        raise BadExpression(f"the exponent {value.value:g} is larger than {LARGEST_POWER}")


def _leaf(node: ast.expr, at: Conditions, shapes: Mapping[str, float]) -> FloatArray:
    """The value of a name, a run or what the past makes, (n, 3), (n, 1) or of no length."""
    match node:
        case ast.Name(id=name):
            return np.asarray(shapes[name]) if name in shapes else _named(name, at)
        case ast.Call(func=ast.Name(id="run"), args=[ast.Constant(value=str() as run)]):
            elsewhere = np.zeros(len(at))
            return np.asarray(at.columns.get(RUN_COLUMN + run, elsewhere)[:, None])
        case ast.Call(func=ast.Name(id=name)) if name in PASTS:
            return at.column(PAST + ast.unparse(node))[:, None]
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
