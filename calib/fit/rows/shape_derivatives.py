"""Derivatives of the rows by the shape parameters, in which the columns are not linear.

With l the logarithm of a shape parameter, from ``s + C(s; l) theta = M y + c``:

    (I + C') ds/dl          = -(dC/dl) theta
    (I + C') d²s/dl dtheta  = -(dC/dl)
    (I + C') d²s/dl²        = -(d²C/dl²) theta

where what the second derivatives have of C' beside is left out: it is as small as the effect.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from calib.effects.effect import Effect
from calib.fit.rows.residuals import Equations
from calib.fit.rows.sensitive_axes import sensor_columns
from calib.fit.rows.whitened_rows import WhitenedRows
from calib.poses.imu_log import FloatArray

DIFFERENCE_STEP = 1e-4
"""Of the logarithm of a shape parameter: central differences are exact to 1e-8 of themselves.
Numerical."""


@dataclass(frozen=True, eq=False)
class ShapeDerivatives:
    """Derivatives of the r whitened rows by the logarithms of h shape parameters.

    ``slope`` (r, h) the first, ``curvature`` (r, h) the second, ``mixed`` (r, p, h) the second by
    theta and the shape.
    """

    slope: FloatArray
    curvature: FloatArray
    mixed: FloatArray


def shape_derivatives(
    equations: Equations,
    theta: FloatArray,
    eta: FloatArray,
    shapes: Mapping[str, float],
    rows: WhitenedRows,
    names: Sequence[str],
) -> ShapeDerivatives:
    """Derivatives of the rows by the shape parameters of the effects ``names``.

    Parameters
    ----------
    equations : Equations
    theta, eta : array, shapes (p,) and (q,)
    shapes : mapping of effect name to shape parameter
        All of the model.
    rows : WhitenedRows
        The r rows there.
    names : sequence of str
        h effects of the model that have a shape.

    Returns
    -------
    ShapeDerivatives
    """
    model, k, d = equations.model, len(equations.magnitude), equations.data_count
    r, p, h = len(rows.residual), model.size, len(names)
    result = ShapeDerivatives(np.zeros((r, h)), np.zeros((r, h)), np.zeros((r, p, h)))
    true_share = np.ones(d)
    true_share[:k] = 1 - equations.common_relative @ eta
    for j, effect in enumerate(e for name in names for e in model.effects if e.name == name):
        where = model.positions((effect,))
        if effect.acts_on == "sensor":
            first, second = _of_vectors(equations, shapes, rows, effect)
            first, second = (
                equations.whitened(each, rows.vector) * true_share[:, None]
                for each in (first, second)
            )
        else:
            first, second = np.zeros((2, d, len(where)))
            at = equations.at_reading
            columns = [effect.evaluate(at, value) for value in _beside(shapes[effect.name])]
            sd = equations.magnitude_sd[:, None]
            first[:k], second[:k] = (
                each[equations.magnitude] / sd for each in _differences(columns)
            )
        result.mixed[:d, where, j] = -first
        result.slope[:d, j] = -first @ theta[where]
        result.curvature[:d, j] = -second @ theta[where]
    return result


def _of_vectors(
    equations: Equations,
    shapes: Mapping[str, float],
    rows: WhitenedRows,
    effect: Effect,
) -> tuple[FloatArray, FloatArray]:
    """First and second derivative of the corrected vectors' errors, each (n, 3, k), SI."""
    at = equations.conditions(rows.vector)
    columns = [
        sensor_columns((effect,), at, {effect.name: value}, rows.axes)
        for value in _beside(shapes[effect.name])
    ]
    first, second = _differences(columns)
    if rows.slope is None:
        return first, second
    both = np.linalg.solve(rows.slope, np.concatenate([first, second], axis=2))
    k = first.shape[2]
    return both[:, :, :k], both[:, :, k:]


def _beside(value: float) -> tuple[float, float, float]:
    """A shape parameter a small step down, itself, and a small step up."""
    factor = float(np.exp(DIFFERENCE_STEP))
    return value / factor, value, value * factor


def _differences(columns: Sequence[FloatArray]) -> tuple[FloatArray, FloatArray]:
    """First and second central difference of columns at :func:`_beside`."""
    down, middle, up = columns
    return (up - down) / (2 * DIFFERENCE_STEP), (up + down - 2 * middle) / DIFFERENCE_STEP**2
