"""Readings that a logger truncated toward zero, as a conversion to an integer does.

Such readings are half a step nearer to zero than the true ones, on both sides of it: the gains of
an accelerometer that is logged in steps of 0.01 m/s² are 0.06 % off, and hardly anything in the fit
shows it. The value zero does: it stands for the readings from one step below zero to one step above
it, and occurs twice as often as the values beside it. A rounded zero occurs as often as they do.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from calib.numbers import NO_LENGTH
from calib.poses.imu_log import TRIADS, FloatArray, ImuLog, Triad
from calib.poses.samples.batches import PARTS, batch_means
from calib.poses.samples.converter_steps import value_steps

BESIDE_ZERO = {-2: -1 / 6, -1: 2 / 3, 1: 2 / 3, 2: -1 / 6}
"""Values beside zero, in steps, and their weights in the expected share of zero. Derived: they
interpolate a polynomial of third order at its middle."""

SMOOTH = 1.0
"""Noise in steps from which the shares of neighbouring values are interpolated. Derived: the middle
of normal noise then has at most 1.27 of the interpolated share, less than the middle between once
and twice."""

CLEAR = 2.0
"""Sds by which zero must be nearer to twice than to once as frequent. Derived: a rounded log must
then be four of them off."""


def truncation_steps(logs: Sequence[ImuLog], triad: Triad) -> FloatArray | None:
    """The steps of readings that are truncated toward zero; None where nothing shows that.

    Parameters
    ----------
    logs : sequence of ImuLog
        All logs of one logger, signed counts; at least those in which an axis changes its sign tell
        something.
    triad : str

    Returns
    -------
    array, shape (3,), or None
        Counts as logged; 0 for an axis of one value.
    """
    readings = [log.readings(triad) for log in logs if log.has(triad)]
    crossing = [values for values in readings
                if ((values.min(axis=0) <= 0) & (values.max(axis=0) >= 0)).any()]
    if not crossing:
        return None
    steps = np.min([value_steps(values) for values in crossing], axis=0)
    noise = np.median([values.std(axis=0) for values in readings], axis=0)
    shares = [_shares(values[:, k] / steps[k]) for values in crossing
              for k in np.flatnonzero(noise >= SMOOTH * steps)]
    if not shares or not _twice_as_often(*np.vstack(shares).T):
        return None
    steps = np.min([value_steps(values) for values in readings], axis=0)
    return np.where(np.isfinite(steps), steps, 0.0)


def before_truncation(log: ImuLog, steps: Mapping[Triad, FloatArray]) -> ImuLog:
    """A log with its readings in the middle of what they may have been.

    Zero stays: the true reading is as likely below it as above.

    Parameters
    ----------
    log : ImuLog
    steps : mapping of triad to array, shape (3,)
        Of each triad that is truncated, in its unit.
    """
    accelerometer, gyroscope = (
        values + np.sign(values) * steps[triad] / 2 if triad in steps else values
        for triad in TRIADS for values in [log.readings(triad)])
    return replace(log, accelerometer=accelerometer, gyroscope=gyroscope)


def _shares(levels: FloatArray) -> FloatArray:
    """Share of zero in each part of one axis (t,), in steps, and that interpolated, (parts, 2)."""
    if len(levels) < PARTS:
        return np.zeros((0, 2))
    whole = np.rint(levels)
    beside = sum(weight * (whole == level) for level, weight in BESIDE_ZERO.items())
    return batch_means(np.column_stack([whole == 0, beside]), PARTS)


def _twice_as_often(zero: FloatArray, beside: FloatArray) -> bool:
    """Whether zero occurs twice as often as the values ``beside`` it, by parts of logs (b,) each.

    The scatter of the parts gives the sd of the ratio, with Student's quantile for their effective
    number (Kish).
    """
    from scipy.special import ndtr, stdtrit  # measuring a clip loads this package, not SciPy

    total, expected = float(zero.sum()), float(beside.sum())
    if total <= 0 or expected <= 0:
        return False
    dof = total**2 / float(zero @ zero) - 1
    if dof <= NO_LENGTH:
        return False
    ratio = total / expected
    scatter = float(np.square(zero - ratio * beside).sum()) * (1 + 1 / dof)
    limit = float(stdtrit(dof, ndtr(CLEAR))) * np.sqrt(scatter) / total
    return bool(np.log(ratio / np.sqrt(2)) > limit)
