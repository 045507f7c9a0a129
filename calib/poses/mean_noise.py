"""How well the mean of a pose is known: the one room for its sd.

**Many poses of one sensor**: batch means of each pose (:mod:`calib.poses.averaging`), steadied by
those of the run's other poses, times what correlation the batches leave out.

**One log alone** (an installed sensor): the variance of a mean is the spectral density at frequency
zero over the length of the log. The periodogram estimates it at the lowest frequencies that the log
holds: with X_k the discrete Fourier transform, ``E |X_k|² / t²`` is the variance of the mean of t
samples as long as the spectrum is flat below the k-th harmonic, white or not above it.
"""

from collections.abc import Sequence

import numpy as np

from calib.poses.averaging import BATCHES, PoseMean
from calib.poses.imu_log import FloatArray, Triad

OWN_DOF = BATCHES - 1
POOLED_DOF = 2 * OWN_DOF
"""How many degrees of freedom the other poses' scatter counts for in the sd of one pose."""
LARGEST_TYPICAL = 10.0
"""Poses noisier than this many times the typical variance were disturbed; they say nothing of the
sensor's correlation."""
SIMILAR_LENGTH = 1.3
"""Runs whose poses differ by less than this factor in length share one correlation."""
NOISE_DOF_PER_POSE = 2.0
"""Degrees of freedom that a pose adds to the estimate ``2 v3 - v6`` over three axes."""
MEDIAN_OF_CHI2_5 = 4.3515
"""Median of chi-square with OWN_DOF = 5, to turn a median of variances into a variance."""

HARMONICS = 4
"""Slow enough for noise that stays correlated over a tenth of the log, and with three axes enough
degrees of freedom (24) that Student's factor is small."""


def variance_of_mean(values: FloatArray) -> FloatArray:
    """Variance of the mean of each column of ``values`` (t, k), shape (k,).

    The axes of one triad share the colour of their noise: by how much it exceeds white noise is
    taken from all of them together, and never as less than 1. Student's factor allows for the
    degrees of freedom of that estimate.
    """
    samples, axes = values.shape
    centred = values - values.mean(axis=0)
    white = (centred**2).sum(axis=0) / (samples - 1) / samples
    if not (white > 0).any():
        return np.zeros(axes)
    time = np.arange(samples) / samples
    waves = np.exp(-2j * np.pi * np.outer(np.arange(1, HARMONICS + 1), time))  # (h, t)
    power = (np.abs(waves @ centred) ** 2).mean(axis=0) / samples**2  # (k,)
    alive = white > 0
    colour = max(1.0, float((power[alive] / white[alive]).mean()))
    dof = 2 * HARMONICS * int(alive.sum())
    return np.asarray(white * colour * dof / (dof - 2))


def pooled_sd(means: Sequence[PoseMean], triad: Triad) -> FloatArray:
    """Sd of each pose mean by its batches, (n, 3), steadied by those of the run's other poses.

    A pose's own estimate has 5 degrees of freedom, too few to weight by. The typical variance of
    the run, scaled to the length of the pose, is mixed in with twice that weight; being a median,
    it does not follow the few poses that were disturbed.
    """
    own = np.array([getattr(mean, triad).variance for mean in means])
    duration = np.array([mean.duration_s for mean in means])[:, None]
    typical = np.median(own * duration, axis=0) * OWN_DOF / MEDIAN_OF_CHI2_5 / duration
    mixed = (OWN_DOF * own + POOLED_DOF * typical) / (OWN_DOF + POOLED_DOF)
    return np.asarray(np.sqrt(mixed))


def correlation_factor(runs: Sequence[Sequence[PoseMean]], triad: Triad) -> float:
    """By how much the variance of a pose mean exceeds what its BATCHES batches say.

    Where samples stay correlated over a time short against the pose, batches of length L have
    ``V(L) = A/L - B/L²``, and cutting a pose in 6 and in 3 gives estimates v6 and v3 of the
    variance of its mean that fall short by 6 and 3 times the same amount, so that
    ``V = 2 v3 - v6``. The ratio belongs to the sensor and the length of the pose: it is taken over
    all ``runs``, whose poses are alike in length. The last factor is Student's: an sd known with
    few degrees of freedom is wider than it says.
    """
    fine, coarse = 0.0, 0.0
    for means in runs:
        v6 = np.array([getattr(mean, triad).variance for mean in means])
        v3 = np.array([getattr(mean, triad).coarse_variance for mean in means])
        typical = np.maximum(np.median(v6, axis=0), 1e-300)
        disturbed = np.maximum(v6, v3) > LARGEST_TYPICAL * typical
        fine += float(np.where(disturbed, 0.0, v6 / typical).sum())
        coarse += float(np.where(disturbed, 0.0, v3 / typical).sum())
    dof = NOISE_DOF_PER_POSE * sum(len(means) for means in runs)
    student = dof / max(dof - 2, 1.0)
    return student * max(1.0, 2 * coarse / fine - 1) if fine > 0 else 1.0


def correlated_sd(runs: Sequence[Sequence[PoseMean]], triad: Triad) -> FloatArray:
    """Sd of every pose mean of all runs, one after another, correlation included, (n, 3)."""
    length = [float(np.median([mean.duration_s for mean in means])) for means in runs]
    parts = []
    for means, own in zip(runs, length, strict=True):
        alike = [
            other
            for other, its in zip(runs, length, strict=True)
            if 1 / SIMILAR_LENGTH < its / own < SIMILAR_LENGTH
        ]
        parts.append(pooled_sd(means, triad) * np.sqrt(correlation_factor(alike, triad)))
    return np.concatenate(parts)
