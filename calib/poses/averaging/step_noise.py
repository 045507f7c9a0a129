"""Effect of a converter's steps on the means of one run."""

from collections.abc import Sequence

import numpy as np

from calib.numbers import NO_LENGTH
from calib.poses.averaging.pose_mean import TriadMean
from calib.poses.imu_log import FloatArray
from calib.poses.samples.batches import BATCHES
from calib.poses.samples.converter_steps import PRINTED_TOLERANCE, step_variance_seen


def variance_by_steps(means: Sequence[TriadMean]) -> FloatArray:
    """Variance of the means of one run by the converter's steps, shape (3,), SI squared."""
    scatter = np.array([mean.scatter for mean in means])
    variance = np.array([mean.variance for mean in means])
    step, least = known_step(means), min(len(mean.envelope) for mean in means) or BATCHES
    rounding = np.maximum(PRINTED_TOLERANCE * step**2, NO_LENGTH)  # a constant shows no step
    samples = (scatter.mean(axis=0) + rounding) / (variance.mean(axis=0) + rounding / least)
    logged = [mean.envelope[0, 0] if len(mean.envelope) else mean.mean for mean in means]
    above = np.array([mean.mean for mean in means]) - logged
    return step_variance_seen(step, scatter, above, samples)


def known_step(means: Sequence[TriadMean]) -> FloatArray:
    """The step of a converter, SI, shape (3,): the least that a pose shows, or that is possible."""
    step = np.min([mean.step for mean in means], axis=0)
    unit = np.min([mean.unit for mean in means], axis=0)
    return np.asarray(np.where(np.isfinite(step), step, unit))
