"""The course of the readings within a pose that all poses of one length have in common.

A sensor that is switched on for each log settles alike in every pose, and a cable that winds slows
the plate alike. The poses do not show where such a course would end: their means have one error,
which no scatter between them contains. With y_i the contrasts of the parts of pose i, along the
polynomials of degree 1 to ``DEGREES``, and u_i its mean reading,

    y_i = b + g (u_i - mean(u)) + e_i

axis by axis: b is a bias that has a course, g a relative course of gain or reference, the same on
all axes. The scatter e between the poses gives their sds, however the noise is correlated.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from calib.numbers import NO_LENGTH
from calib.poses.averaging.pose_mean import PoseMean
from calib.poses.imu_log import FloatArray, Triad
from calib.poses.samples.batches import BATCHES, PARTS

DEGREES = 3
"""Polynomials along a pose: what settles within a quarter of it has a line, a curve and a cubic.
Numerical: the sixth part of such a course is beyond them."""

FEWEST_POSES = 4
"""Poses that show a course and its scatter on each axis. Numerical: the scatter of fewer has one or
two degrees of freedom, and shows none."""


def polynomials(values: FloatArray) -> FloatArray:
    """Contrasts (..., DEGREES) of the parts (..., PARTS), in their unit."""
    return np.asarray(values @ CONTRASTS.T)


CONTRASTS = np.linalg.qr(
    np.vander(np.linspace(-1.0, 1.0, PARTS), DEGREES + 1, increasing=True))[0][:, 1:].T
"""Orthonormal polynomials of degree 1 to ``DEGREES`` along the parts, (DEGREES, PARTS)."""


@dataclass(frozen=True, eq=False)
class CommonCourse:
    """What the n poses of one length have in common.

    Attributes
    ----------
    poses : int
    duration_s : float
        Of one pose.
    bias, bias_sd : array, shape (DEGREES, 3)
        Contrasts of the bias and their sds, SI.
    gain, gain_sd : array, shape (DEGREES,)
        Contrasts of the relative gain and their sds.
    """

    poses: int
    duration_s: float
    bias: FloatArray
    bias_sd: FloatArray
    gain: FloatArray
    gain_sd: FloatArray


def common_course(means: Sequence[PoseMean], triad: Triad) -> CommonCourse | None:
    """The course that poses of one length have in common; None where too few show one.

    Parameters
    ----------
    means : sequence of PoseMean
    triad : str
        ``accelerometer`` or ``gyroscope``.
    """
    seen = _with_parts(means, triad)
    if len(seen) < FEWEST_POSES:
        return None
    course = _Course.of(seen, triad)
    rest = polynomials(np.moveaxis(course.rest, 1, 2))  # (n, 3, DEGREES)
    of_bias, of_gain = (((rest * share[..., None]) ** 2).sum(axis=0)
                        for share in (course.share, course.share_of_gain))
    return CommonCourse(len(seen), float(np.median([mean.duration_s for mean in seen])),
                        CONTRASTS @ course.bias, _sd(of_bias.T),
                        CONTRASTS @ course.gain, _sd(of_gain.sum(axis=0)))


def without_course(means: Sequence[PoseMean], triad: Triad) -> list[PoseMean]:
    """Poses of one length with the noise of their parts and means about the common course.

    Poses without parts, and so few that they show no course, are as they were.
    """
    seen = _with_parts(means, triad)
    if len(seen) < FEWEST_POSES:
        return list(means)
    rest = iter(_Course.of(seen, triad).rest)
    return [_about(mean, triad, next(rest)) if len(mean.of(triad).parts) else mean
            for mean in means]


def _sd(variance: FloatArray) -> FloatArray:
    """Sds; infinite where nothing scatters, as on an axis that gives one value in all poses."""
    return np.asarray(np.sqrt(np.where(variance > 0, variance, np.inf)))


def _with_parts(means: Sequence[PoseMean], triad: Triad) -> list[PoseMean]:
    return [mean for mean in means if len(mean.of(triad).parts)]


@dataclass(frozen=True, eq=False)
class _Course:
    """The course of n poses at their parts, SI: ``bias`` (PARTS, 3), ``gain`` (PARTS,), and what is
    left, ``rest`` (n, PARTS, 3), of the variance of the noise.

    ``share`` and ``share_of_gain`` (n, 3) are what the contrasts of a pose count for: the calmer,
    the more, but none for more than a typical one.
    """

    bias: FloatArray
    gain: FloatArray
    rest: FloatArray
    share: FloatArray
    share_of_gain: FloatArray

    @classmethod
    def of(cls, means: Sequence[PoseMean], triad: Triad) -> "_Course":
        parts = np.array([mean.of(triad).parts for mean in means])
        parts -= parts.mean(axis=1, keepdims=True)
        square = (parts**2).mean(axis=1)  # (n, 3)
        weight = 1 / np.maximum(np.maximum(square, np.median(square, axis=0)), NO_LENGTH)
        share = weight / weight.sum(axis=0)
        u = np.array([mean.of(triad).mean for mean in means])
        u -= (share * u).sum(axis=0)
        share_of_gain = weight * u / max(float((weight * u**2).sum()), NO_LENGTH)
        bias = np.einsum("na,npa->pa", share, parts)
        gain = np.einsum("na,npa->p", share_of_gain, parts)
        rest = parts - bias - gain[:, None] * u[:, None]
        lost = share + 1 / u.size  # of the variance: to the bias, on average to the gain
        return cls(bias, gain, rest / np.sqrt(1 - lost)[:, None], share, share_of_gain)


def _about(mean: PoseMean, triad: Triad, rest: FloatArray) -> PoseMean:
    """A pose whose parts are ``rest`` (PARTS, 3), and whose variance is by its batches in it."""
    of_triad = mean.of(triad)
    before, after = (
        parts.reshape(BATCHES, -1, 3).mean(axis=1).var(axis=0) for parts in (of_triad.parts, rest))
    ratio = np.divide(after, before, out=np.ones(3), where=before > 0)
    return mean.with_triad(
        triad, replace(of_triad, parts=rest, variance=of_triad.variance * ratio))
