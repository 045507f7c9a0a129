"""The errors of the sensor as expressions, from the pages of its effects."""

import ast
from dataclasses import dataclass

import numpy as np

from calib.effects.effect import Effect
from calib.effects.expression import substituted
from calib.effects.formula import axis_terms
from calib.poses.imu_log import AXES, FloatArray
from pipeline.results.read import StoredTriad

FORCE = tuple(f"f{axis}" for axis in AXES)
WHOLE_POSES = {"previous", "vibration", "plate"}  #: needs that the samples of a log do not meet


@dataclass(frozen=True)
class Product:
    """``factor * value``, value an expression of numbers and names."""

    factor: float
    value: ast.expr


@dataclass(frozen=True)
class ErrorFormula:
    """The error that an effect adds to each axis, SI, as sums of products.

    ``x``, ``y``, ``z`` are the vector in the sensitive axes. ``names`` are the other names of the
    expressions: conditions that a caller passes.
    """

    effect: str
    axes: tuple[tuple[Product, ...], ...]
    names: tuple[str, ...]


def error_formula(
    effect: Effect, theta: FloatArray, shape: float | None, calibrated: StoredTriad
) -> ErrorFormula | None:
    """The error of one effect of a calibration.

    Parameters
    ----------
    effect : Effect
    theta : array, shape (k,)
        Its parameters, SI.
    shape : float or None
        The value of its shape parameter.
    calibrated : StoredTriad

    Returns
    -------
    ErrorFormula or None
        None where samples do not determine it (hysteresis, vibration, the bench), or where its
        page has no expressions.
    """
    if effect.belongs_to == "bench" or effect.acts_on != "sensor" or WHOLE_POSES & {*effect.needs}:
        return None
    terms = axis_terms(effect, shape)
    if not terms:
        return None
    axes = tuple(tuple(Product(float(theta[term.parameter]), term.value) for term in axis)
                 for axis in terms)
    if effect.orthogonal:
        axes = _turned_to_sensitive_axes(axes, calibrated.alignment)
    if calibrated.name == "accelerometer":  # which measures the specific force itself
        vector = {name: ast.Name(axis) for name, axis in zip(FORCE, AXES, strict=True)}
        axes = tuple(tuple(Product(one.factor, substituted(one.value, vector)) for one in axis)
                     for axis in axes)
    names = dict.fromkeys(name for axis in axes for one in axis for name in _names(one.value))
    return ErrorFormula(effect.name, axes, tuple(names))


def _names(tree: ast.expr) -> list[str]:
    called = {id(node.func) for node in ast.walk(tree) if isinstance(node, ast.Call)}
    return [node.id for node in ast.walk(tree)
            if isinstance(node, ast.Name) and id(node) not in called
            and node.id not in (*AXES, "pi")]


def _turned_to_sensitive_axes(
    axes: tuple[tuple[Product, ...], ...], alignment: FloatArray
) -> tuple[tuple[Product, ...], ...]:
    """``T⁻¹ e(T u)`` of an error e(s) in orthogonal axes, which are ``s = T u``."""
    inverse = np.linalg.inv(alignment)
    orthogonal = {name: _weighted(row) for name, row in zip(AXES, alignment, strict=True)}
    return tuple(
        tuple(Product(float(inverse[i, j]) * axis.factor, substituted(axis.value, orthogonal))
              for j in range(len(AXES)) if inverse[i, j] != 0 for axis in axes[j])
        for i in range(len(AXES)))


def _weighted(row: FloatArray) -> ast.expr:
    """The sum of x, y, z with the weights of a row of T."""
    parts: list[ast.expr] = [
        ast.BinOp(ast.Constant(float(weight)), ast.Mult(), ast.Name(axis))
        for weight, axis in zip(row, AXES, strict=True) if weight != 0]
    total = parts[0]
    for part in parts[1:]:
        total = ast.BinOp(total, ast.Add(), part)
    return total
