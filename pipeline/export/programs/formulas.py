"""The errors of the sensor as expressions, for programs that cannot call the effects themselves.

Each is the sum over the parameters of the effect in its :attr:`calib.effects.effect.Effect.columns`
again, in the language of :mod:`calib.effects.expression`; a test holds the two against each other
for every effect of the catalogue. ``s`` and ``f`` are the axis's own components.
"""

import ast
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from calib.effects.effect import EFFECTS, REFERENCE_TEMPERATURE_C, Effect
from calib.effects.expression import Expression, read_expression
from calib.fit.triad.rotation import cross_matrix
from calib.numbers import SECONDS_PER_HOUR
from calib.poses.imu_log import AXES, FloatArray
from pipeline.results.read import StoredTriad

WARMTH = f"(temperature_c - {REFERENCE_TEMPERATURE_C})"
HOURS = f"time_s / {SECONDS_PER_HOUR}"
OWN = {"s": AXES, "f": tuple(f"f{axis}" for axis in AXES), "p": tuple(f"p{axis}" for axis in AXES)}

#: Effects with one parameter for each axis: the value that it multiplies.
PER_AXIS: Mapping[str, str] = {
    "quadratic": "s**2",
    "cubic": "s**3",
    "asymmetry": "abs(s)",
    "temperature_bias": WARMTH,
    "temperature_scale": f"{WARMTH} * s",
    "bias_drift": HOURS,
    "scale_drift": f"{HOURS} * s",
    "warm_up": "exp(-time_s / tau_s)",
    "g_squared_sensitivity": "f**2",
}
#: Effects with three parameters for each axis, row by row: the values that they multiply.
MATRIX: Mapping[str, tuple[str, str, str]] = {
    "g_sensitivity": ("fx", "fy", "fz"),
    "cross_quadratic": ("x*y", "y*z", "z*x"),
}


@dataclass(frozen=True)
class Product:
    """``factor * value``, value an expression of numbers and names."""

    factor: float
    value: ast.expr


@dataclass(frozen=True)
class ErrorFormula:
    """The error that an effect adds to each axis, SI, as sums of products.

    ``x``, ``y``, ``z`` are what the sensitive axes feel. ``names`` are the other names of the
    expressions: conditions that a caller passes.
    """

    effect: str
    axes: tuple[tuple[Product, ...], ...]
    names: tuple[str, ...]


def formula_of(
    effect: Effect, theta: FloatArray, shape: float | None, stored: Mapping[str, Any] | None,
    each: StoredTriad,
) -> ErrorFormula | None:
    """The error of one effect of a calibration.

    Parameters
    ----------
    effect : Effect
    theta : array, shape (k,)
        Its parameters, SI.
    shape : float or None
        The value of its shape parameter.
    stored : mapping or None
        A user's effect as results.json has it.
    each : StoredTriad

    Returns
    -------
    ErrorFormula or None
        None where samples do not determine it (hysteresis, vibration, the bench), or where it is
        a Python function.
    """
    if effect.belongs_to == "bench" or effect.acts_on != "sensor" or {
            "previous", "vibration", "plate"} & {*effect.needs}:
        return None
    if effect.name == "frame_rotation":
        return _rotation(theta, each.alignment)
    columns = _columns(effect, stored)
    if columns is None:
        return None
    per, texts, shapes = columns
    values = {} if shape is None else dict(zip(shapes, (shape,), strict=True))
    read = [_read(text, shapes) for text in texts]
    names = tuple(dict.fromkeys(name for each in read for name in each.names
                                if name not in (*AXES, "s", "pi", *shapes)))
    axes = []
    for k in range(3):
        if per == "matrix":
            pairs = [(theta[3 * k + j], _of_axis(read[j].tree, j, values)) for j in range(3)]
        else:
            pairs = [(theta[k if per == "axis" else 0], _of_axis(read[0].tree, k, values))]
        axes.append(tuple(Product(float(factor), value) for factor, value in pairs))
    formula = ErrorFormula(effect.name, tuple(axes), _resolved(names))
    return _of_the_accelerometer(formula) if each.triad == "accelerometer" else formula


def _columns(
    effect: Effect, stored: Mapping[str, Any] | None
) -> tuple[str, tuple[str, ...], tuple[str, ...]] | None:
    """How the parameters are arranged, the values that they multiply, and the shape's name."""
    shapes = () if effect.shape is None else (effect.shape.name,)
    if stored is not None:
        expression = stored["expression"]
        return None if expression is None else (stored["per"], (expression,) * 3, shapes)
    if effect.names_column is not None and effect.name not in EFFECTS:
        return "axis", (effect.names_column,), shapes
    if effect.name in MATRIX:
        return "matrix", MATRIX[effect.name], shapes
    return ("axis", (PER_AXIS[effect.name],), shapes) if effect.name in PER_AXIS else None


def _read(text: str, shapes: Sequence[str]) -> Expression:
    """The expression; the name of a column need not be one of the language."""
    if not shapes and not set("+-*/()") & set(text):
        return Expression(text, ast.Name(text), (text,))
    return read_expression(text, shapes)


class _OfAxis(ast.NodeTransformer):
    """The axis's own components by their names, shape parameters by their values."""

    def __init__(self, axis: int, values: Mapping[str, float]) -> None:
        self.axis, self.values = axis, values

    def visit_Name(self, node: ast.Name) -> ast.expr:
        """``s`` of axis 0 is ``x``."""
        if node.id in self.values:
            return ast.Constant(self.values[node.id])
        return ast.Name(OWN[node.id][self.axis] if node.id in OWN else node.id)


def _of_axis(tree: ast.expr, axis: int, values: Mapping[str, float]) -> ast.expr:
    copy = ast.parse(ast.unparse(tree), mode="eval").body if not isinstance(
        tree, ast.Name) else tree
    node: ast.expr = _OfAxis(axis, values).visit(copy)
    return node


def _resolved(names: tuple[str, ...]) -> tuple[str, ...]:
    """``f`` stands for the three components of the force."""
    return tuple(dict.fromkeys(each for name in names for each in OWN.get(name, (name,))))


class _ForceIsTheVector(ast.NodeTransformer):
    """The accelerometer measures the specific force itself."""

    def visit_Name(self, node: ast.Name) -> ast.expr:
        """``fx`` is ``x``."""
        return ast.Name(node.id[1:] if node.id in OWN["f"] else node.id)


def _of_the_accelerometer(formula: ErrorFormula) -> ErrorFormula:
    axes = tuple(tuple(Product(each.factor, _ForceIsTheVector().visit(each.value))
                       for each in axis) for axis in formula.axes)
    names = tuple(name for name in formula.names if name not in OWN["f"])
    return ErrorFormula(formula.effect, axes, names)


def _rotation(theta: FloatArray, alignment: FloatArray) -> ErrorFormula:
    """``e = φ × s`` in sensitive axes u, where s is T u: ``T⁻¹ [φ]× T u``."""
    rows = np.linalg.inv(alignment) @ cross_matrix(theta) @ alignment
    axes = tuple(tuple(Product(float(factor), ast.Name(name))
                       for factor, name in zip(row, AXES, strict=True)) for row in rows)
    return ErrorFormula("frame_rotation", axes, ())
