"""How an effect varies about its mean: the part of it that bias and scale do not hold.

With f its factor, which temperature or time changes from pose to pose, an effect that is a bias
where nothing varies errs by f, one that is a gain by f · s, one on the reference by f · m. About
the mean of the poses that is (f − mean f), (f − mean f) · s and (f − mean f) · m.
"""

from typing import TYPE_CHECKING

import numpy as np

from calib.poses.conditions import Conditions
from calib.poses.imu_log import FloatArray

if TYPE_CHECKING:
    from calib.effects.effect import Effect

ROUNDING_OF_MEAN = 1e-12  #: relative; numerical


def about_mean(
    effect: "Effect", sets: int, at: Conditions, shape: float | FloatArray | None = None
) -> FloatArray:
    """The columns of ``effect`` less what they are on average, as a bias or a gain.

    Parameters
    ----------
    effect : Effect
        With a constant part.
    sets : int
        How many sets of n poses ``at`` has, one after another; each has a mean of its own.
    at : Conditions
    shape : float or array, shape (sets n, 1), optional
        Value of the shape parameter, in its unit.

    Returns
    -------
    array, shape (sets n, 3, k), or (sets n, k) for an effect on the reference
        Errors in SI units per unit of each of the k parameters.
    """
    errors = effect.evaluate(at, shape)
    if effect.acts_on == "reference":
        per = np.where(at.magnitude > 0, at.magnitude, 0.0)[:, None]
        factor = errors / np.where(per == 0, 1.0, per)
    elif effect.constant_is == "scale":
        per = at.vector[:, :, None]
        factor = effect.evaluate(at.with_vector(np.ones_like(at.vector)), shape)
    else:
        per, factor = np.ones((len(at), 1, 1)), errors
    counts = (per != 0).any(axis=1, keepdims=True).reshape(sets, -1, *(1,) * (per.ndim - 1))
    of_set = factor.reshape(sets, -1, *factor.shape[1:])
    number = np.maximum(counts.sum(axis=1, keepdims=True), 1)
    mean = np.where(counts, of_set, 0.0).sum(axis=1, keepdims=True) / number
    varying = np.where(counts, of_set - mean, 0.0)
    # The rounding of the mean is no variation.
    varying = np.where(np.abs(varying) > ROUNDING_OF_MEAN * np.abs(mean), varying, 0.0)
    return np.asarray(varying.reshape(factor.shape) * per)
