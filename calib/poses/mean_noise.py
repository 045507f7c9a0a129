"""How well the mean of one still log is known, from the lowest frequencies of its own samples.

The variance of a mean is the spectral density at frequency zero over the length of the log. The
periodogram estimates it at the lowest frequencies that the log holds: with X_k the discrete Fourier
transform, ``E |X_k|² / t²`` is the variance of the mean of t samples as long as the spectrum is
flat below the k-th harmonic, white or not above it. Batch means (:mod:`calib.poses.pose_set`) need
many poses to be known well; one installed log has to do alone.
"""

import numpy as np

from calib.poses.imu_log import FloatArray

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
