"""What any nine parameters leave of a set of poses at least, by linear least squares.

Where ``|M y + c| = m``, the readings y lie on a quadric, ``yᵀA y + bᵀy + d = λ m²`` with A = MᵀM,
linear in its coefficients once its size is fixed by ``trace A = 3``. To first order
``(|s|² - m²) / (2 m) = |s| - m``. Free d and λ, all common errors free of cost and no null rows
leave less than the fit does, so what they leave bounds its chi-square from below.
"""

from collections.abc import Sequence

import numpy as np

from calib.poses.imu_log import FloatArray
from calib.poses.pose_set import PoseSet


def least_chi2(sets: Sequence[PoseSet]) -> FloatArray:
    """Chi-square, no unit, that a fit of bias, scale and misalignment leaves at least, (k,).

    Parameters
    ----------
    sets : sequence of PoseSet, length k
        The same poses with other readings or references.

    Returns
    -------
    array, shape (k,)
        To first order of the misfit over the reference, and for gains that are those of the data
        sheet. Sds count as the largest of the three axes.
    """
    turning = ~sets[0].reference.is_null
    y = np.array([poses.reading[turning] for poses in sets])  # (k, n, 3)
    magnitude = np.array([poses.reference.magnitude[turning] for poses in sets])  # (k, n)
    sd = np.array([np.hypot(poses.sd[turning].max(axis=1), poses.reference.sd[turning])
                   for poses in sets])
    common = np.array([poses.reference.common[turning] for poses in sets])  # (k, n, q)
    squares = y**2
    differences = squares[..., :2] - squares[..., 2:]
    products = y * np.roll(y, 1, axis=-1)
    size = magnitude[..., None]
    columns = np.concatenate(
        [differences, products, y, np.ones_like(size), size**2, size * common], axis=-1)
    weight = (1 / (2 * magnitude * sd))[..., None]
    q, _ = np.linalg.qr(columns * weight)
    target = squares.sum(axis=-1, keepdims=True) * weight
    rest = target - q @ (np.swapaxes(q, -1, -2) @ target)
    return np.asarray((rest**2).sum(axis=(1, 2)))
