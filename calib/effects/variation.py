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


def about_mean(
    effect: Effect, fitted: Sequence[str], over: Conditions, sets: int = 1
) -> Effect:
    """The part of an effect that the base does not hold: how it varies about its mean.

    What an effect is while nothing varies is a bias or a gain, and where it is counted from
    (25 °C, 5 V, power-on) adds no more than that: what poses see of it must not depend on it.

    Parameters
    ----------
    effect : Effect
    fitted : sequence of str
        The effects of the model; without what it is at rest, all of it can be seen.
    over : Conditions
        The poses that the mean is taken over.
    sets : int
        ``over``, and the rows that it will be evaluated on, are those of so many sets of poses,
        one after another, each with a mean of its own.
    """
    if effect.constant_is not in fitted:
        return effect
    return replace(effect, columns=partial(_columns_about_mean, effect, over, sets))


def _columns_about_mean(
    effect: Effect, over: Conditions, sets: int, at: Conditions, shape: ShapeValue | None = None
) -> FloatArray:
    """The columns of ``effect`` less what they are on average, as a bias or a gain."""
    of_over = shape if not isinstance(shape, np.ndarray) else np.repeat(
        shape.reshape(sets, -1)[:, :1], len(over) // sets, axis=0)
    factor, per = _as_factor(effect, at, shape)
    other, shown = _as_factor(effect, over, of_over)
    counts = (shown != 0).any(axis=1).reshape(sets, -1, *(1,) * (factor.ndim - 1))
    number = np.maximum(counts.sum(axis=1, keepdims=True), 1)
    whole = np.where(counts, other.reshape(sets, -1, *other.shape[1:]), 0.0)
    mean = whole.sum(axis=1, keepdims=True) / number
    varying = factor.reshape(sets, -1, *factor.shape[1:]) - mean
    varying[np.abs(varying) <= ROUNDING_OF_MEAN * np.abs(mean)] = 0.0  # its rounding is none
    return np.asarray(varying.reshape(factor.shape) * per)


def _as_factor(
    effect: Effect, at: Conditions, shape: ShapeValue | None
) -> tuple[FloatArray, FloatArray]:
    """The columns of ``effect`` per what they multiply (a bias one), and that."""
    if effect.constant_is == "bias":
        errors = effect.evaluate(at, shape)
        return errors, np.ones((len(errors), 1, 1))
    if effect.acts_on == "reference":
        per = np.where(at.magnitude > 0, at.magnitude, 0.0)[:, None]
        return effect.evaluate(at, shape) / np.where(per == 0, 1.0, per), per
    return effect.evaluate(at.with_vector(np.ones_like(at.vector)), shape), at.vector[:, :, None]
