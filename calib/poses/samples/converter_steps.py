"""The steps of a converter, as the values of a log show them, and their effect on a mean."""

from functools import lru_cache

import numpy as np

from calib.numbers import NO_LENGTH
from calib.poses.data_sheet import TriadSpec
from calib.poses.imu_log import FloatArray

MOST_DECIMALS = 9  #: decimals of a value in a log or a certificate; more are exact; numerical
PRINTED_TOLERANCE = 1e-6
"""Tolerance in units of the last decimal: far above the rounding of a double, far below one."""

STEP_TERMS = 100
"""The series is within 0.6 % of Δ²/12 without noise, and exact with any. Numerical."""

LEAST_NOISE, MOST_NOISE, NOISES = 0.001, 0.9, 100
"""Noises of a sample in steps, all equally likely, 7 % apart: from none to where steps have no
effect. Numerical."""
BY_CHANCE = 0.1
"""Samples of a pose that are a step off in any noise: one in ten poses has one. A judgement."""
MOVED = 9.2
"""Largest misfit of a pose that scatters more than its noise would: one in a hundred may have
moved, -2 ln 0.01. A judgement: those that lay still then outweigh as many that did not."""
PLACES = 100  #: within half a step; the scatter is tabulated there; numerical

SAME_PLACE = 0.25
"""Share of a step. Derived: the error of a mean returns with every step, and its parts a quarter
apart have no correlation."""


def value_steps(values: FloatArray) -> FloatArray:
    """The step between neighbouring values of each axis of a log (t, 3), in its units, (3,).

    A converter steps by one count, or by more where the log was shifted or rounded; of a log in
    physical units the values themselves show it. Infinite where all are the same.
    """
    whole = np.rint(values)
    is_whole = (values == whole).all(axis=0)
    steps = np.zeros(values.shape[1])
    steps[is_whole] = np.gcd.reduce((whole - whole[0])[:, is_whole].astype(np.int64), axis=0)
    for k in np.flatnonzero(~is_whole):
        steps[k] = np.diff(np.unique(values[:, k])).min(initial=np.inf)
    return np.where(steps == 0, np.inf, steps)


def least_steps(values: FloatArray, spec: TriadSpec) -> FloatArray:
    """One count, or one unit of the last decimal of the first of ``values`` (t, 3), (3,).

    In the same unit.
    """
    return printed_unit(values[:1]) if spec.encoding == "si" else np.ones(3)


def printed_unit(values: FloatArray) -> FloatArray:
    """One unit of the last decimal of the values of each column.

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


def step_variance(step: FloatArray, noise: FloatArray) -> FloatArray:
    """Variance of a mean by the converter's steps, over positions of the truth between two steps.

    The mean of rounded samples with noise of sd σ misses the truth x by a periodic function of x
    (Widrow & Kollár, *Quantization Noise*, 2008, its Fourier series), of the variance

        Σ_k Δ² / (2π² k²) · exp(−4π² k² σ² / Δ²),

    which is Δ²/12 without noise and vanishes once σ exceeds half a step. It does not fall with the
    length of the pose.

    Parameters
    ----------
    step : array, shape (3,)
        Δ; 0 where there is none.
    noise : array, shape (..., 3)
        Variance of the samples before they were rounded, σ².

    Returns
    -------
    array, shape (..., 3)
        In the square of their unit.
    """
    square = np.maximum(step**2, NO_LENGTH)[:, None]
    k = np.arange(1, STEP_TERMS + 1)
    terms = np.exp(-4 * np.pi**2 * k**2 * noise[..., None] / square) / (2 * np.pi**2 * k**2)
    return np.asarray(step**2 * terms.sum(axis=-1))


def step_variance_seen(
    step: FloatArray, scatter: FloatArray, above: FloatArray, samples: FloatArray
) -> FloatArray:
    """Variance of the means of a run by the converter's steps, averaged over its possible noise.

    The scatter of a pose's samples depends on the position of its mean between two steps: in the
    middle they show nothing of a noise below a third of a step, near a step all of it. The samples
    of all poses of the run give one likelihood of the noise; a pose that moved scatters more, and
    none less.

    Parameters
    ----------
    step : array, shape (3,)
        Δ; 0 where there is none.
    scatter : array, shape (n, 3)
        Variance of the logged samples of each pose, in the square of its unit.
    above : array, shape (n, 3)
        The means of the poses, less any value that was logged.
    samples : array, shape (3,)
        Number of independent samples that a scatter rests on.

    Returns
    -------
    array, shape (3,)
        In the square of their unit.
    """
    from scipy.special import xlogy  # measuring a clip loads this module and needs no SciPy

    unit = np.where(step > 0, step, 1.0)
    noises, table = _scatters()
    off = np.abs(above / unit - np.rint(above / unit))
    expected = table[:, np.rint(2 * PLACES * off).astype(int)]  # (noises, n, 3)
    expected = expected + BY_CHANCE / samples
    excess = np.minimum(scatter / unit**2, expected[-1]) / expected
    misfit = 2 * samples * expected * (1 - excess + xlogy(excess, excess))
    misfit = np.where(excess > 1, np.minimum(misfit, MOVED), misfit).sum(axis=1)
    likelihood = np.exp((misfit.min(axis=0) - misfit) / 2)
    stated = step_variance(np.ones(3), np.tile(noises[:, None] ** 2, 3))
    return np.asarray(step**2 * (likelihood * stated).sum(axis=0) / likelihood.sum(axis=0))


@lru_cache(maxsize=1)
def _scatters() -> tuple[FloatArray, FloatArray]:
    """Noises (s,) in steps, and scatter (s, PLACES + 1) of samples by position of their mean."""
    from scipy.special import ndtr  # measuring a clip loads this module and needs no SciPy

    noises = np.geomspace(LEAST_NOISE, MOST_NOISE, NOISES)
    truth = np.linspace(0, 0.5, 20 * PLACES + 1)[:, None]
    value = np.arange(-5, 7)
    places = np.linspace(0, 0.5, PLACES + 1)
    table = []
    for noise in noises:
        share = ndtr((value + 0.5 - truth) / noise) - ndtr((value - 0.5 - truth) / noise)
        mean = share @ value
        table.append(np.interp(places, mean, share @ value**2 - mean**2))
    return noises, np.array(table)


def same_place(values: FloatArray, step: FloatArray) -> FloatArray:
    """Number of poses at the same position between two steps of their axis, (n, 3).

    The effect of the steps on their means is common to them and does not average down: the bias of
    a gyroscope is read at one position in all poses at rest. Multiplied by this number, the
    variance of each is that of a common error, as far as their mean is concerned.

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
