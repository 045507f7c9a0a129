"""Derivatives of the corrected vectors by the parameters of the model.

From ``s + C(s; T) theta = M y + c``, C of :mod:`calib.fit.rows.sensitive_axes`:

    (I + C') ds = dv - C dtheta - (dC/dT) dT,    (dC/dT) dT = dT F theta - T F' T⁻¹ dT u

the latter at fixed s. Rows show only a few directions of ds: the two sides stay apart, so that
``I + C'`` is solved for those directions and not for every parameter.
"""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from calib.effects.effect import Effect
from calib.fit.model import stack_columns
from calib.fit.rows.sensitive_axes import NO_GAIN, Axes, sensor_slope
from calib.poses.conditions import Conditions
from calib.poses.imu_log import FloatArray

if TYPE_CHECKING:
    from calib.fit.rows.residuals import Equations


def vector_derivatives(
    equations: "Equations",
    theta: FloatArray,
    shapes: Mapping[str, float],
    vector: FloatArray,
    columns: FloatArray,
    axes: Axes,
) -> tuple[FloatArray, FloatArray | None]:
    """Both sides of ``-(I + C') ds/dtheta``.

    Parameters
    ----------
    equations : Equations
    theta : array, shape (p,)
    shapes : mapping of effect name to shape parameter
    vector : array, shape (n, 3)
        The corrected vectors there.
    columns : array, shape (n, 3, p'')
        C of the p'' parameters of the sensor.
    axes : Axes
        The sensitive axes there.

    Returns
    -------
    errors : array, shape (n, 3, p)
        By how much less each vector is per unit of each parameter, ahead of the effects that
        follow it.
    slope : array, shape (n, 3, 3), or None
        ``I + C'``; the identity in null poses, which are held at what they should read, and None
        where no effect follows the vector.
    """
    at = equations.conditions(vector).vector
    on_axes = _slope_of(equations, equations.varying_on_axes, theta, shapes, at, axes)
    errors = np.zeros((*vector.shape, equations.model.size))
    errors[:, :, equations.sensor_index] = columns
    of_reading = equations.reading_columns
    if equations.on_sensor and equations.reading_index:
        error = columns[:, :, equations.on_axes_columns] @ theta[equations.on_axes_index]
        moved = _axes_slopes(equations, theta, axes)  # (p', 3, 3)
        of_reading = of_reading + np.einsum("pij,nj->nip", moved, axes.sensed(error))
        if equations.varying_on_axes:
            of_reading -= on_axes @ np.einsum("pij,nj->nip", moved, axes.sensed(at))
    errors[:, :, equations.reading_index] = of_reading
    if not equations.varying:
        return errors, None
    orthogonal = _slope_of(equations, equations.varying_orthogonal, theta, shapes, at, axes)
    slope = np.eye(3) + on_axes + orthogonal
    slope[equations.null] = np.eye(3)
    return errors, slope


def _slope_of(
    equations: "Equations",
    effects: Sequence[Effect],
    theta: FloatArray,
    shapes: Mapping[str, float],
    vector: FloatArray,
    axes: Axes,
) -> FloatArray:
    """C' of some effects of the model, (n, 3, 3)."""
    sizes = theta[equations.model.positions(effects)]
    return sensor_slope(effects, sizes, shapes, equations.probes, vector, axes)


def _axes_slopes(equations: "Equations", theta: FloatArray, axes: Axes) -> FloatArray:
    """dT/dtheta for the parameters of the reading, (p', 3, 3)."""
    diagonal_slopes = np.einsum("pii->pi", equations.matrix_slopes)
    diagonal = 1 + theta[equations.reading_index] @ diagonal_slopes
    if (np.abs(diagonal) < NO_GAIN).any():  # the axes are held there, see ``axes_of``
        return np.zeros_like(equations.matrix_slopes)
    turned = axes.to_orthogonal * diagonal_slopes[:, None, :]
    return np.asarray((equations.matrix_slopes - turned) / diagonal)


def matrix_slopes(on_reading: Sequence[Effect]) -> FloatArray:
    """dM/dtheta of ``M y + c`` for every parameter of the reading, per unit of each, (p', 3, 3)."""
    if not on_reading:
        return np.zeros((0, 3, 3))
    probes = np.vstack([np.zeros(3), np.eye(3)])
    columns = stack_columns(on_reading, Conditions.of_vectors(probes), {})
    return np.asarray((columns[0] - columns[1:]).transpose(2, 1, 0))
