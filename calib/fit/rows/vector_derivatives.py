"""Derivatives of the corrected vectors by the parameters of the model.

From ``s + C(s; T) theta = M y + c``, C of :mod:`calib.fit.rows.sensitive_axes`:

    (I + C') ds = dv - C dtheta - (dC/dT) dT,    (dC/dT) dT = dT F theta - T F' T⁻¹ dT u

the latter at fixed s. Rows show only a few directions of ds: the two sides stay apart, so that
``I + C'`` is solved for those directions and not for every parameter.
"""

import numpy as np

from calib.fit.rows.model_terms import ModelTerms
from calib.fit.rows.sensitive_axes import NO_GAIN, Axes, Shapes, sensor_slope
from calib.fit.rows.surroundings import Surroundings
from calib.fit.small_systems import combined
from calib.poses.imu_log import FloatArray


def vector_derivatives(
    terms: ModelTerms,
    surroundings: Surroundings,
    theta: FloatArray,
    shapes: Shapes,
    vector: FloatArray,
    columns: FloatArray,
    axes: Axes,
) -> tuple[FloatArray, FloatArray | None]:
    """Both sides of ``-(I + C') ds/dtheta``.

    Parameters
    ----------
    terms : ModelTerms
    surroundings : Surroundings
        Of the poses.
    theta : array, shape (..., p)
    shapes : mapping of effect name to shape parameter
    vector : array, shape (..., n, 3)
        The corrected vectors there, null poses as they should read.
    columns : array, shape (..., n, 3, p)
        Those of the parameters of the reading and of the sensor; changed in place.
    axes : Axes
        The sensitive axes there.

    Returns
    -------
    errors : array, shape (..., n, 3, p)
        By how much less each vector is per unit of each parameter, ahead of the effects that
        follow it.
    slope : array, shape (..., n, 3, 3), or None
        ``I + C'``; None where no effect follows the vector.
    """
    if not terms.on_sensor:
        return columns, None
    probes = surroundings.probes if terms.varying else surroundings.at_start
    on_axes, orthogonal = (
        sensor_slope(effects, theta[..., terms.model.positions(effects)], shapes, probes, vector,
                     axes)
        for effects in (terms.varying_on_axes, terms.varying_orthogonal)
    )
    if terms.reading_index:
        index = terms.on_axes_index
        error = axes.sensed(combined(columns[..., index], theta[..., index]))
        moved = _axes_slopes(terms, theta, axes)  # (..., p', 3, 3)
        turned = np.einsum("...pij,...nj->...nip", moved, error)
        if terms.varying_on_axes:
            turned -= on_axes @ np.einsum("...pij,...nj->...nip", moved, axes.sensed(vector))
        columns[..., terms.reading_index] += turned
    return columns, np.eye(3) + on_axes + orthogonal if terms.varying else None


def _axes_slopes(terms: ModelTerms, theta: FloatArray, axes: Axes) -> FloatArray:
    """dT/dtheta for the parameters of the reading, (..., p', 3, 3)."""
    slopes = terms.matrix_slopes
    diagonal_slopes = np.einsum("pii->pi", slopes)
    diagonal = 1 + theta[..., terms.reading_index] @ diagonal_slopes
    has_gain = (np.abs(diagonal) >= NO_GAIN).all(axis=-1)[..., None, None, None]
    turned = axes.to_orthogonal[..., None, :, :] * diagonal_slopes[:, None, :]
    divisor = np.where(has_gain[..., 0], diagonal[..., None, :], 1.0)[..., None, :]
    # Without a gain the axes are held, see ``axes_of``.
    return np.asarray(np.where(has_gain, (slopes - turned) / divisor, 0.0))
