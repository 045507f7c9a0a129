"""How well the mean of a pose is known: the one room for its sd.

**Many poses of one sensor**: batch means of each pose, steadied by those of the run's other poses,
times what correlation the batches leave out.

**One log alone** (an installed sensor): the variance of a mean is the spectral density at frequency
zero over the length of the log. The periodogram estimates it at the lowest frequencies that the log
holds: with X_k the discrete Fourier transform, ``E |X_k|² / t²`` is the variance of the mean of t
samples as long as the spectrum is flat below the k-th harmonic, white or not above it.
"""

from collections.abc import Sequence

import numpy as np

from calib.numbers import NO_LENGTH
from calib.poses.averaging.pose_mean import PoseMean
from calib.poses.averaging.step_noise import known_step, variance_by_steps
from calib.poses.averaging.sway import shortfall
from calib.poses.imu_log import FloatArray, Triad
from calib.poses.samples.batches import BATCHES, COARSE_BATCHES
from calib.poses.samples.converter_steps import same_place

BATCH_DOF = BATCHES - 1  #: degrees of freedom of one pose's batches; definition
MEDIAN_OF_CHI2_5 = 4.3515  #: median of chi-square with BATCH_DOF; definition
LEAST_BY_CHANCE = 0.042
"""0.1 % quantile of chi-square with BATCH_DOF over BATCH_DOF, a fact: a pose calmer than that shows
a converter's step or a frozen block, not how alike the poses are."""
NEWTON_STEPS = 20
"""Steps of the inverse of the trigamma function; it converges quadratically and from one side.
Numerical."""
LARGEST_TYPICAL = 10.0
"""Poses noisier than this many times the typical variance were disturbed; they say nothing of the
sensor's correlation. Derived: white noise exceeds it in 1 of 6000 poses and axes."""
SIMILAR_LENGTH = 1.3
"""Runs whose poses differ by less than this factor in length share one correlation. Derived: the
factor 2 ratio - 1 then differs by 6 to 10 % at ratios of 1.1 to 1.5."""
NOISE_DOF_PER_POSE = 2.0
"""Degrees of freedom that a pose adds to the estimate ``2 v3 - v6`` over three axes. Derived:
twice its squared mean over its variance is 2.1 in white noise."""

LARGEST_RATIO = 1.7
"""Correlated over a quarter of the pose (x = 0.25): beyond, the factor, 4.4, runs away. Derived."""

FIRST_ORDER_S = 6.0
"""Twelve times half a second, the correlation time of low-cost sensors' noise: the first order is
within 10 % of the variance there (x = 0.08), and 30 % short of it at 3 s. Derived."""

UNCERTAIN_RATIO = 1.5
"""Beyond what RATIO_SD makes of it by chance: from x = 0.13 on 93 % and fewer of the means lie
within 1.96 stated sds, 88 % at 0.33 (``python -m tests.bench.study_pose_means``). Derived."""

RATIO_SD = 0.4
"""Sd of the ratio that one pose of three axes gives, by the same bench. Derived."""

SHORTEST_S, LONG_ENOUGH_S = 2.0, 8.0
"""With noise correlated over half a second, as low-cost sensors have it, 85 to 88 % at 1.5 s, 92 to
93 % at 3 s, 95 % at 8 s, by the same bench. Derived."""

LOWEST_HARMONICS = 4
"""Slow enough for noise that stays correlated over a tenth of the log, and with three axes enough
degrees of freedom (24) that Student's factor is small. Derived."""


def variance_of_mean(values: FloatArray) -> FloatArray:
    """Variance of the mean of each of k columns of samples.

    The axes of one triad share the colour of their noise: by how much it exceeds white noise is
    taken from all of them together, and never as less than 1. Student's factor allows for the
    degrees of freedom of that estimate.

    Parameters
    ----------
    values : array, shape (t, k)

    Returns
    -------
    array, shape (k,)
        In the square of their unit.
    """
    samples, axes = values.shape
    centred = values - values.mean(axis=0)
    white = (centred**2).sum(axis=0) / (samples - 1) / samples
    if not (white > 0).any():
        return np.zeros(axes)
    time = np.arange(samples) / samples
    waves = np.exp(-2j * np.pi * np.outer(np.arange(1, LOWEST_HARMONICS + 1), time))  # (h, t)
    power = (np.abs(waves @ centred) ** 2).mean(axis=0) / samples**2  # (k,)
    alive = white > 0
    colour = max(1.0, float((power[alive] / white[alive]).mean()))
    dof = 2 * LOWEST_HARMONICS * int(alive.sum())
    return np.asarray(white * colour * dof / (dof - 2))


def pooled_sd(means: Sequence[PoseMean], triad: Triad) -> FloatArray:
    """Sd of each pose mean by its batches, (n, 3), steadied by those of the run's other poses.

    A pose's own estimate has 5 degrees of freedom, too few to weight by. The typical variance of
    the run, scaled to the length of the pose, counts for as many more as the poses are alike
    (:func:`shared_dof`): on a bench it decides, among poses held in a hand hardly. Being a median,
    it does not follow the few poses that were disturbed. Student's factor allows for what is known
    by few degrees of freedom. A pose calmer than the typical one counts as typical: its batches
    show the fast noise only, and what is slower is in all poses alike.
    """
    variance = np.array([mean.of(triad).variance for mean in means])
    duration = np.array([mean.duration_s for mean in means])[:, None]
    typical = np.median(variance * duration, axis=0) * BATCH_DOF / MEDIAN_OF_CHI2_5 / duration
    shared = shared_dof(variance / np.maximum(typical, np.finfo(float).tiny))
    weight = BATCH_DOF / (BATCH_DOF + shared)
    student = 1 / (1 - 2 / (BATCH_DOF + shared))
    disturbed = student * (weight * variance + (1 - weight) * typical)
    return np.asarray(np.sqrt(np.maximum(disturbed, typical)))


def shared_dof(ratio: FloatArray) -> float:
    """Degrees of freedom that the typical variance of a run counts for in that of one pose.

    The poses' true variances are taken as scattered about a typical one like its inverse by
    chi-square. The logarithms of their estimates then scatter by trigamma(d/2) for the BATCH_DOF of
    an estimate and trigamma(d0/2) for the d0 sought.

    Parameters
    ----------
    ratio : array, shape (n, 3)
        Estimated over typical variance of every pose.

    Returns
    -------
    float
        Infinite where the poses scatter no more than their estimates do by chance, 0 for one pose.

    Source: Smyth, *Linear models and empirical Bayes methods*, Stat. Appl. Genet. Mol. Biol. 3
    (2004), section 6.2.
    """
    from scipy.special import polygamma  # measuring a clip loads this module and needs no SciPy

    if len(ratio) < 2:
        return 0.0
    logs = np.log(np.maximum(ratio, LEAST_BY_CHANCE))
    excess = float(logs.var(axis=0, ddof=1).mean() - polygamma(1, BATCH_DOF / 2))
    if excess <= 0:
        return np.inf
    half = 0.5 + 1 / excess
    for _ in range(NEWTON_STEPS):
        at = float(polygamma(1, half))
        half += at * (1 - at / excess) / float(polygamma(2, half))
    return 2 * half


def _mean_variance(x: FloatArray) -> FloatArray:
    """Variance of a mean over T of noise with the correlation time x T, in that of the noise."""
    return np.asarray(2 * x * (1 + x * np.expm1(-1 / x)))


def _batch_variance(x: FloatArray, batches: int) -> FloatArray:
    """What so many batches of that mean would state on average, (V(T/m) - V(T)) / (m - 1)."""
    return np.asarray((_mean_variance(batches * x) - _mean_variance(x)) / (batches - 1))


# Of noise with one correlation time x: the ratio that COARSE_BATCHES and BATCHES state, and the
# factor that is missing.
_SHARES = np.geomspace(1e-4, 3.0, 300)
_RATIOS = _batch_variance(_SHARES, COARSE_BATCHES) / _batch_variance(_SHARES, BATCHES)
_FACTORS = _mean_variance(_SHARES) / _batch_variance(_SHARES, BATCHES)


def correlation_ratio(runs: Sequence[Sequence[PoseMean]], triad: Triad) -> float:
    """Variance of pose means by COARSE_BATCHES over that by BATCHES, over all poses of ``runs``."""
    fine, coarse = 0.0, 0.0
    for means in runs:
        v6 = np.array([mean.of(triad).variance for mean in means])
        v3 = np.array([mean.of(triad).coarse_variance for mean in means])
        typical = np.maximum(np.median(v6, axis=0), NO_LENGTH)
        disturbed = np.maximum(v6, v3) > LARGEST_TYPICAL * typical
        fine += float(np.where(disturbed, 0.0, v6 / typical).sum())
        coarse += float(np.where(disturbed, 0.0, v3 / typical).sum())
    return coarse / fine if fine > 0 else 1.0


def correlation_factor(runs: Sequence[Sequence[PoseMean]], triad: Triad) -> float:
    """Ratio of the variance of a pose mean to what its BATCHES batches say.

    Noise that stays correlated over x T of a pose of length T gives batches a variance that falls
    short, and the more batches the more: the ratio of the estimates from 3 and from 6 of them is
    between 1 (white noise) and 2 (x without limit). For small x the factor is ``2 ratio - 1``,
    whatever the shape of the correlation; in poses shorter than ``FIRST_ORDER_S``, where noise over
    half a second is no longer short, and beyond ``UNCERTAIN_RATIO``, it is that of noise with one
    correlation time (Gauss-Markov). The ratio belongs to the sensor and the length of the pose: it
    is taken over all ``runs``, whose poses are alike in length. The last factor is Student's: an sd
    known with few degrees of freedom is wider than it says.
    """
    ratio, poses = correlation_ratio(runs, triad), sum(map(len, runs))
    seconds = float(np.median([mean.duration_s for means in runs for mean in means]))
    factor = 2 * ratio - 1
    if seconds < FIRST_ORDER_S or ratio > UNCERTAIN_RATIO:
        factor = float(np.interp(min(ratio, LARGEST_RATIO), _RATIOS, _FACTORS))
    dof = NOISE_DOF_PER_POSE * poses
    student = dof / max(dof - 2, 1.0)
    return student * max(1.0, factor)


def sd_dof(runs: Sequence[Sequence[PoseMean]], triad: Triad) -> float | None:
    """Degrees of freedom of the sds of all runs where readings wander; None where none do.

    The steeper the factor at the ratio that the poses show, the less is known by it.
    """
    ratios = [correlation_ratio([means], triad) for means in runs]
    if not runs or max(ratios) <= UNCERTAIN_RATIO:
        return None
    steep = np.gradient(np.log(_FACTORS), _RATIOS)
    sds = RATIO_SD * np.interp(np.minimum(ratios, LARGEST_RATIO), _RATIOS, steep)
    per_pose = np.minimum(NOISE_DOF_PER_POSE, 2 / sds**2)
    return float(per_pose @ [len(means) for means in runs])


def too_short(means: Sequence[PoseMean], triad: Triad, run: str) -> str | None:
    """Why the sds of these pose means may not hold, or None where they do.

    Means over a few correlation times follow the noise itself: how far it goes is not in the poses.
    """
    ratio = correlation_ratio([means], triad)
    seconds = float(np.median([mean.duration_s for mean in means]))
    wanders = ratio > UNCERTAIN_RATIO + 2 * RATIO_SD / np.sqrt(len(means))
    if not wanders and seconds >= SHORTEST_S:
        return None
    seen = (
        f"within them the {triad}'s readings wander as a whole (their noise stays correlated over "
        f"a sixth of a pose and longer, or they drift)"
        if wanders
        else f"slow noise of the {triad}, correlated over half a second, does not show in so few"
    )
    return (
        f"{run}: poses of {seconds:.2g} s are short: {seen}. The sds of the pose means are lower "
        f"bounds; log each pose for {max(LONG_ENOUGH_S, 5 * seconds):.0f} s."
    )


def noise_sd(runs: Sequence[Sequence[PoseMean]], triad: Triad) -> FloatArray:
    """Sd of every pose mean by its noise, correlation included.

    Returns
    -------
    array, shape (n, 3)
        For the n poses of all runs in their order, nominal m/s² or rad/s.
    """
    length = [float(np.median([mean.duration_s for mean in means])) for means in runs]
    parts = []
    for means, seconds in zip(runs, length, strict=True):
        alike = [
            other
            for other, its in zip(runs, length, strict=True)
            if 1 / SIMILAR_LENGTH < its / seconds < SIMILAR_LENGTH
        ]
        parts.append(pooled_sd(means, triad) * np.sqrt(correlation_factor(alike, triad)))
    return np.concatenate(parts)


def pose_mean_sd(runs: Sequence[Sequence[PoseMean]], triad: Triad) -> FloatArray:
    """Sd (n, 3), nominal m/s² or rad/s, of every pose mean of all runs, one after another.

    Noise and converter steps; of a gyroscope the rate at which a pose at rest gave way, of an
    accelerometer by how much it rocked short of gravity.

    Parameters
    ----------
    runs : sequence of sequences of PoseMean
        Averaged poses of one sensor, run by run.
    triad : str
        ``accelerometer`` or ``gyroscope``.
    """
    other = []
    for means in runs:
        motion = (np.array([mean.creep_rad_s for mean in means]) if triad == "gyroscope"
                  else shortfall(means))
        values = np.array([mean.of(triad).mean for mean in means])
        places = same_place(values, known_step([mean.of(triad) for mean in means]))
        steps = variance_by_steps([mean.of(triad) for mean in means]) * places
        other.append(steps + np.square(motion)[:, None])
    return np.asarray(np.sqrt(noise_sd(runs, triad) ** 2 + np.concatenate(other)))
