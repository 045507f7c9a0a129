"""The columns of an effect as expressions, for programs that cannot call the effect itself.

The page of an effect of k parameters on m expressions has them in one of three arrangements:

    m = 1      e_a = theta_a value          (theta_0 where k is 1)
    3 m = k    e_a = Σ_j theta_(m a + j) value_j
    m = 3 k    e_a = Σ_p theta_p value_(k a + p)

``s``, ``f`` and ``p`` in a value are those of axis a. A logged column that is itself called ``s``,
``time_s`` or the like is the name ``column:s``, which no expression can hold. A test holds the
expressions of every listed effect against its columns.
"""

import ast
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from calib.effects.effect import OF_COLUMN, Effect
from calib.effects.expression import KNOWN_NAMES, on_axis, read_expression, substituted
from calib.poses.imu_log import AXES


@dataclass(frozen=True)
class ErrorTerm:
    """A part of the error of an axis: ``value`` times the parameter of this number."""

    parameter: int
    value: ast.expr


def axis_terms(effect: Effect, shape: float | None = None) -> tuple[tuple[ErrorTerm, ...], ...]:
    """The error of x, y and z as terms to be summed; none where the effect has no expressions.

    Parameters
    ----------
    effect : Effect
        One on the sensor.
    shape : float or None
        Value of its shape parameter; by default the first of its starts.
    """
    if effect.is_column:  # any text can be the name of a column, also one that means something here
        column = effect.names_column or ""
        has_meaning = column in KNOWN_NAMES or column.startswith(OF_COLUMN)
        values: list[ast.expr] = [ast.Name(effect.name if has_meaning else column)]
    else:
        values = [_value(text, effect, shape) for text in effect.page.expressions]
    if not values:
        return ()
    return tuple(tuple(_terms_on(axis, values, len(effect.parameters)))
                 for axis in range(len(AXES)))


def _value(text: str, effect: Effect, shape: float | None) -> ast.expr:
    if effect.shape is None:
        return read_expression(text).tree
    value = effect.shape.starts[0] if shape is None else shape
    name = effect.shape.name
    return substituted(read_expression(text, (name,)).tree, {name: ast.Constant(value)})


def _terms_on(axis: int, values: Sequence[ast.expr], k: int) -> Iterator[ErrorTerm]:
    m = len(values)
    if m == 1:
        numbered = [(min(axis, k - 1), values[0])]
    elif len(AXES) * m == k:
        numbered = [(m * axis + j, value) for j, value in enumerate(values)]
    else:
        numbered = list(enumerate(values[k * axis : k * (axis + 1)]))
    for parameter, value in numbered:
        if not (isinstance(value, ast.Constant) and value.value == 0):
            yield ErrorTerm(parameter, on_axis(value, axis))
