"""The arithmetic of expressions: operators, functions of one argument, and their values."""

import ast
from collections.abc import Callable

import numpy as np

from calib.poses.imu_log import FloatArray

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

LeafValue = Callable[[ast.expr], FloatArray]
"""Evaluates a leaf: a node that is not an operation, a name or a call of the past."""


def value_of(node: ast.expr, leaf: LeafValue) -> FloatArray:
    """The value of an expression, shape (n, 3), (n, 1) or (), in the SI or logged units it is of.

    ``leaf`` evaluates the nodes that are not operations.
    """
    match node:
        case ast.Constant(value=int() | float() as number):
            return np.asarray(float(number))
        case ast.UnaryOp(op=operator, operand=operand):
            inner = value_of(operand, leaf)
            return np.negative(inner) if isinstance(operator, ast.USub) else inner
        case ast.BinOp(left=left, op=operator, right=right):
            return np.asarray(OPERATORS[type(operator)](
                value_of(left, leaf), value_of(right, leaf)))
        case ast.Call(func=ast.Name(id=name), args=[argument]) if name in FUNCTIONS:
            return np.asarray(FUNCTIONS[name](value_of(argument, leaf)))
    return leaf(node)
