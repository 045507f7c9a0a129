"""Variation of an effect about the part that a bias or a gain would absorb."""

from collections.abc import Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from calib.effects.effect import Effect, ShapeValue
from calib.poses.conditions import Conditions
from calib.poses.imu_log import FloatArray

ROUNDING_OF_MEAN = 1e-12
"""Relative to the mean. Numerical: a mean of some hundred doubles is exact to 1e-14."""


def about_mean(effect: Effect, fitted: Sequence[str], sets: int = 1) -> Effect:
    """The part of an effect that the base does not hold: how it varies about its mean.

    What an effect is while nothing varies is a bias or a gain, and where it is counted from
    (25 °C, 5 V, power-on) adds no more than that: what poses see of it must not depend on it.

    Parameters
    ----------
    effect : Effect
    fitted : sequence of str
        The effects of the model; without what it is at rest, all of it can be seen.
    sets : int
        The rows that it will be evaluated on are those of so many sets of poses, one after
        another, each with a mean of its own.
    """
    if effect.constant_is not in fitted:
        return effect
    return replace(effect, columns=partial(_columns_about_mean, effect, sets))


def _columns_about_mean(
    effect: Effect, sets: int, at: Conditions, shape: ShapeValue | None = None
) -> FloatArray:
    """The columns of ``effect`` less what they are on average, as a bias or a gain."""
    errors = effect.evaluate(at, shape)
    if effect.constant_is == "bias":
        of_set = errors.reshape(sets, -1, *errors.shape[1:])
        return _less(of_set, of_set.mean(axis=1, keepdims=True)).reshape(errors.shape)
    if effect.acts_on == "reference":
        per = np.where(at.magnitude > 0, at.magnitude, 0.0)[:, None]
        factor = errors / np.where(per == 0, 1.0, per)
    else:
        per = at.vector[:, :, None]
        factor = effect.evaluate(at.with_vector(np.ones_like(at.vector)), shape)
    counts = (per != 0).any(axis=1, keepdims=True).reshape(sets, -1, *(1,) * (per.ndim - 1))
    of_set = factor.reshape(sets, -1, *factor.shape[1:])
    number = np.maximum(counts.sum(axis=1, keepdims=True), 1)
    mean = np.where(counts, of_set, 0.0).sum(axis=1, keepdims=True) / number
    varying = np.where(counts, _less(of_set, mean), 0.0)
    return np.asarray(varying.reshape(factor.shape) * per)


def _less(values: FloatArray, mean: FloatArray) -> FloatArray:
    """``values`` less their ``mean``, whose rounding is no variation."""
    varying = values - mean
    varying[np.abs(varying) <= ROUNDING_OF_MEAN * np.abs(mean)] = 0.0
    return varying
