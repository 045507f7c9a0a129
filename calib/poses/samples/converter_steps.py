"""The steps of a converter, as the values of a log show them, and what they do to a mean."""

import numpy as np

from calib.numbers import NO_LENGTH
from calib.poses.data_sheet import TriadSpec
from calib.poses.imu_log import FloatArray

MOST_DECIMALS = 9  #: decimals of a value in a log or a certificate; more are exact; numerical
PRINTED_TOLERANCE = 1e-6
"""Tolerance in units of the last decimal: far above the rounding of a double, far below one."""

STEP_TERMS = 100
"""The series is within 0.6 % of Δ²/12 without noise, and exact with any. Numerical."""


SAME_PLACE = 0.25
"""Share of a step. Derived: the error of a mean returns with every step, and its parts a quarter
apart have no correlation."""


def value_steps(values: FloatArray) -> FloatArray:
    """The step between neighbouring values of each axis of a log (t, 3), in its units, (3,).

    A converter steps by one count, or by more where the log was shifted or rounded; of a log in
    physical units the values themselves show it. Infinite where all are the same.
    """
    steps = []
    for axis in values.T:
        whole = np.rint(axis)
        if np.array_equal(axis, whole):
            step = float(np.gcd.reduce((whole - whole[0]).astype(np.int64)))
        else:
            gaps = np.diff(np.unique(axis))
            step = float(gaps.min()) if gaps.size else 0.0
        steps.append(step or np.inf)
    return np.array(steps)


def least_steps(values: FloatArray, spec: TriadSpec) -> FloatArray:
    """One count, or one of the last decimal that the first of ``values`` (t, 3) has, (3,).

    In the same unit.
    """
    return printed_unit(values[:1]) if spec.encoding == "si" else np.ones(3)


def printed_unit(values: FloatArray) -> FloatArray:
    """One of the last decimal that the values of each column have.

    Parameters
    ----------
    values : array, shape (n, k)
        In any unit.

    Returns
    -------
    array, shape (k,)
        In the same unit: a power of ten, at most 1; 0 for a column that is not rounded.
    """
    scaled = values[..., None] * 10.0 ** np.arange(MOST_DECIMALS)  # (n, k, decimals)
    is_whole = (np.abs(scaled - np.rint(scaled)) < PRINTED_TOLERANCE).all(axis=0)
    return np.where(is_whole.any(axis=1), 10.0 ** -np.argmax(is_whole, axis=1).astype(float), 0.0)


def step_variance(step: FloatArray, scatter: FloatArray) -> FloatArray:
    """Variance of a mean by the converter's steps, over where between two steps the truth lies.

    The mean of rounded samples with noise of sd σ misses the truth x by a periodic function of x
    (Widrow & Kollár, *Quantization Noise*, 2008, its Fourier series), of the variance

        Σ_k Δ² / (2π² k²) · exp(−4π² k² σ² / Δ²),

    which is Δ²/12 without noise and vanishes once σ exceeds half a step. It does not fall with the
    length of the pose.

    Parameters
    ----------
    step : array, shape (3,)
        Δ; 0 where there is none.
    scatter : array, shape (3,)
        Variance of the logged samples, rounding included: σ² + Δ²/12.

    Returns
    -------
    array, shape (3,)
        In the square of their unit.
    """
    square = np.maximum(step**2, NO_LENGTH)[:, None]
    dither = np.maximum(scatter - step**2 / 12, 0.0)[:, None]
    k = np.arange(1, STEP_TERMS + 1)
    terms = np.exp(-4 * np.pi**2 * k**2 * dither / square) / (2 * np.pi**2 * k**2)
    return np.asarray(step**2 * terms.sum(axis=1))


def same_place(values: FloatArray, step: FloatArray) -> FloatArray:
    """Number of poses that lie in the same place between two steps of their axis, (n, 3).

    What the steps do to their means is common to them and does not average down: the bias of a
    gyroscope is read in one place in all poses at rest. Multiplied by this number, the variance of
    each is that of a common error, as far as their mean goes.

    Parameters
    ----------
    values : array, shape (n, 3)
        Means of the poses of one run.
    step : array, shape (3,)
        In the same unit.

    Returns
    -------
    array, shape (n, 3)
        Counts, no unit; at least 1, the pose itself.
    """
    apart = np.abs(values[:, None, :] - values[None, :, :])  # (n, n, 3)
    return np.asarray((apart < SAME_PLACE * step).sum(axis=1).clip(min=1), dtype=float)
