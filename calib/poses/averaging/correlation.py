"""Correlation of the noise within poses, and the part of it that the batches of a pose leave out.

Noise that stays correlated over a part of a pose gives batches a variance below six times that of
the mean. It is modelled as the sum of white noise and slow noise with one correlation time
(Gauss-Markov), of unknown shares, in addition to a drift. The means y of the ``PARTS`` of each pose
and axis, about their mean, have the covariance s² Σ(share, time, drift) with a size s of their own;
with Jeffreys' prior of s their density is

    |Σ|^(-1/2) (yᵀ Σ⁻¹ y)^(-c/2)

for c contrasts. A disturbed pose thus counts as one pose. A priori, white noise alone is as likely
as all mixtures with slow noise together; of these every share and, on a logarithmic scale, every
time is equally likely; no drift is as likely as a drift of any size.
"""

from collections.abc import Sequence
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from calib.poses.averaging.pose_mean import PoseMean
from calib.poses.imu_log import FloatArray, Triad
from calib.poses.samples.batches import BATCHES, PARTS

SHARES = np.linspace(0.0, 1.0, 7)  #: part of slow noise in what the batches state; numerical
TIMES = np.geomspace(0.03, 0.35, 8)
"""Correlation times over the length of a pose: from a third of a part, which is white noise to the
parts, to a third of the pose. Tuned: longer ones can hardly be told from a drift within the pose
and a wander between poses. With half or all of the pose as the longest time ``study_pose_means``
covers short poses better, and a step of the bias that a real sensor has is left open."""

DRIFTS = np.array([0.0, *4.0 ** np.arange(7)])
"""Variances of a steady drift along the parts, in units of that of white noise. Numerical."""

ROUNDING = 1e-12  #: relative; smaller contrasts belong to a constant reading; numerical


class Correlation(NamedTuple):
    """Ratio of the variance of a pose mean to that by its batches: the most likely ``factor``, and
    the degrees of freedom ``dof`` by which it is known.
    """

    factor: float
    dof: float

    @property
    def widening(self) -> float:
        """The factor with Student's allowance for its uncertainty."""
        return self.factor * self.dof / max(self.dof - 2, 1.0)


class _Mixtures(NamedTuple):
    """The g mixtures: ``whitening`` (g, c, PARTS) makes c unit contrasts of the parts, with
    ``log_det`` (g,); ``log_prior`` (g,) is their prior.
    """

    whitening: FloatArray
    log_det: FloatArray
    log_prior: FloatArray
    factor: FloatArray


@lru_cache(maxsize=1)
def _mixtures() -> _Mixtures:
    slow = np.array([_slow(time) for time in TIMES])
    share = SHARES[:, None, None, None]
    noise = (share * slow + (1 - share) * PARTS * np.eye(PARTS)).reshape(-1, 1, PARTS, PARTS)
    line = np.arange(PARTS) - (PARTS - 1) / 2
    drift = PARTS * np.outer(line, line) / (line @ line)
    covariance = (noise + DRIFTS[:, None, None] * drift).reshape(-1, PARTS, PARTS)
    contrasts = np.linalg.qr(np.ones((PARTS, 1)), mode="complete")[0][:, 1:].T
    root = np.linalg.cholesky(contrasts @ covariance @ contrasts.T)
    log_det = 2 * np.log(np.einsum("gcc->gc", root)).sum(axis=1)
    prior = np.multiply.outer(_half_first(np.repeat(SHARES, len(TIMES))), _half_first(DRIFTS))
    return _Mixtures(np.linalg.solve(root, contrasts[None]), log_det, np.log(prior.ravel()),
                     np.repeat(noise.mean(axis=(1, 2, 3)), len(DRIFTS)))


def _half_first(sizes: FloatArray) -> FloatArray:
    """Prior of half for those of ``sizes`` (k,) that are zero, half for the others."""
    nothing = sizes == 0
    return np.asarray(0.5 / np.where(nothing, nothing.sum(), (~nothing).sum()))


def _slow(time: float) -> FloatArray:
    """Covariance (PARTS, PARTS) of parts' means by slow noise, scaled to the batches' variance.

    ``time`` is its correlation time over the length of the pose.
    """
    part = 1 / PARTS
    fall = np.exp(-part / time)
    apart = np.abs(np.subtract.outer(np.arange(PARTS), np.arange(PARTS)))
    inside = 2 * time / part * (1 - time / part * (1 - fall))
    across = (time / part * (1 - fall)) ** 2 * fall ** (np.maximum(apart, 1) - 1.0)
    covariance = np.where(apart == 0, inside, across)
    batches = covariance.reshape(BATCHES, 2, BATCHES, 2).mean(axis=(1, 3))
    stated = (np.trace(batches) / BATCHES - batches.mean()) / (BATCHES - 1)
    return np.asarray(covariance / stated)


def correlation_of(means: Sequence[PoseMean], triad: Triad) -> Correlation:
    """Ratio of the variance of pose means to that by their batches.

    Parameters
    ----------
    means : sequence of PoseMean
        Poses of one length.
    triad : str
        ``accelerometer`` or ``gyroscope``.

    Returns
    -------
    Correlation
        Its factor is one over the mean of 1/factor, since precisions have a chi-square
        distribution; the scatter of that gives the degrees of freedom.
    """
    known = [mean.of(triad).parts.T for mean in means if len(mean.of(triad).parts)]
    parts = np.concatenate([np.zeros((0, PARTS)), *known])
    mixtures = _mixtures()
    whitened = mixtures.whitening @ parts.T  # (g, c, n)
    square = (whitened**2).sum(axis=1)
    alive = square.min(axis=0, initial=np.inf) > ((ROUNDING * parts) ** 2).sum(axis=1)
    contrasts = whitened.shape[1]
    log_density = -0.5 * (alive.sum() * mixtures.log_det
                          + contrasts * np.log(square[:, alive]).sum(axis=1))
    log_density += mixtures.log_prior
    probability = np.exp(log_density - log_density.max())
    probability /= probability.sum()
    precision = float(probability @ (1 / mixtures.factor))
    scatter = float(probability @ (1 / mixtures.factor - precision) ** 2) / precision**2
    return Correlation(1 / precision, 2 / scatter if scatter > 0 else np.inf)
