"""Derivatives of the rows by the shape parameters, in which the columns are not linear.

With l the logarithm of a shape parameter, from ``s + C(s; l) theta = M y + c``:

    (I + C') ds/dl          = -(dC/dl) theta
    (I + C') d²s/dl dtheta  = -(dC/dl)
    (I + C') d²s/dl²        = -(d²C/dl²) theta

where the contribution of C' to the second derivatives is neglected: it is as small as the effect.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from calib.effects.effect import Effect
from calib.fit.linear import solutions, times
from calib.fit.rows.residuals import Equations
from calib.fit.rows.sensitive_axes import Shapes, evaluate_for, sensor_columns
from calib.fit.rows.whitened_rows import WhitenedRows
from calib.poses.imu_log import FloatArray

DIFFERENCE_STEP = 1e-4
"""Step of the logarithm of a shape parameter: central differences are exact to 1e-8 of themselves.
Numerical."""


@dataclass(frozen=True, eq=False)
class ShapeDerivatives:
    """Derivatives of the r whitened rows by the logarithms of h shape parameters.

    ``slope`` (..., r, h) the first, ``curvature`` (..., r, h) the second, ``mixed`` (..., r, p, h)
    the second by theta and the shape.
    """

    slope: FloatArray
    curvature: FloatArray
    mixed: FloatArray


def shape_derivatives(
    equations: Equations,
    theta: FloatArray,
    eta: FloatArray,
    shapes: Shapes,
    rows: WhitenedRows,
    names: Sequence[str],
) -> ShapeDerivatives:
    """Derivatives of the rows by the shape parameters of the effects ``names``.

    Parameters
    ----------
    equations : Equations
    theta, eta : array, shapes (..., p) and (..., q)
    shapes : mapping of effect name to shape parameter
        All of the model.
    rows : WhitenedRows
        The r rows there.
    names : sequence of str
        h effects of the model that have a shape.
    """
    model, k, d = equations.model, len(equations.magnitude), equations.data_count
    (*lead, r), p, h = rows.residual.shape, model.size, len(names)
    slope, curvature = np.zeros((2, *lead, r, h))
    mixed = np.zeros((*lead, r, p, h))
    true_share = 1 - times(equations.row_common, eta)
    effects = {effect.name: effect for effect in model.effects}
    for j, effect in enumerate(effects[name] for name in names):
        where = model.positions((effect,))
        first, second = np.zeros((2, *lead, d, len(where)))
        if effect.acts_on == "sensor":
            first, second = (
                equations.whitened(errors, rows.vector) * true_share[..., None]
                for errors in _of_vectors(equations, shapes, rows, effect)
            )
        else:
            at = equations.at_reading
            columns = [evaluate_for(tuple(lead), effect, at, beside)
                       for beside in _beside(effect, shapes)]
            sd = equations.magnitude_sd[..., None]
            first[..., :k, :], second[..., :k, :] = (
                errors[..., equations.magnitude, :] / sd for errors in _differences(columns)
            )
        mixed[..., :d, where, j] = -first
        slope[..., :d, j] = -times(first, theta[..., where])
        curvature[..., :d, j] = -times(second, theta[..., where])
    return ShapeDerivatives(slope, curvature, mixed)


def _of_vectors(
    equations: Equations, shapes: Shapes, rows: WhitenedRows, effect: Effect
) -> tuple[FloatArray, FloatArray]:
    """First and second derivative of the corrected vectors' errors, each (..., n, 3, k), SI."""
    at = equations.conditions(rows.vector)
    columns = [sensor_columns((effect,), at, beside, rows.axes)
               for beside in _beside(effect, shapes)]
    first, second = _differences(columns)
    if rows.slope is None:
        return first, second
    both = solutions(rows.slope, np.concatenate([first, second], axis=-1))
    k = first.shape[-1]
    return both[..., :k], both[..., k:]


def _beside(effect: Effect, shapes: Shapes) -> tuple[Shapes, Shapes, Shapes]:
    """A shape parameter one small step down, unchanged, and one small step up."""
    value, factor = np.asarray(shapes[effect.name]), float(np.exp(DIFFERENCE_STEP))
    return ({effect.name: value / factor}, {effect.name: value}, {effect.name: value * factor})


def _differences(columns: Sequence[FloatArray]) -> tuple[FloatArray, FloatArray]:
    """First and second central difference of columns at :func:`_beside`."""
    down, middle, up = columns
    return (up - down) / (2 * DIFFERENCE_STEP), (up + down - 2 * middle) / DIFFERENCE_STEP**2
