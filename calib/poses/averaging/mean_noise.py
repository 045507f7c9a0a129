"""Uncertainty of the mean of a pose: the one place where its sd is computed.

**Many poses of one sensor**: batch means of each pose, combined with those of the run's other
poses, times the correlation that the batches leave out (:mod:`calib.poses.averaging.correlation`).

**One log alone** (an installed sensor): the variance of a mean is the spectral density at frequency
zero over the length of the log. The periodogram estimates it at the lowest frequencies that the log
holds: with X_k the discrete Fourier transform, ``E |X_k|² / t²`` is the variance of the mean of t
samples as long as the spectrum is flat below the k-th harmonic, white or not above it.
"""

from collections.abc import Sequence
from itertools import islice

import numpy as np

from calib.numbers import NO_LENGTH
from calib.poses.averaging.common_course import CommonCourse, common_course, without_course
from calib.poses.averaging.correlation import correlation_of
from calib.poses.averaging.pose_mean import PoseMean, TriadMean
from calib.poses.averaging.sway import shortfall
from calib.poses.imu_log import FloatArray, Triad
from calib.poses.samples.batches import BATCHES
from calib.poses.samples.converter_steps import (
    PRINTED_TOLERANCE,
    same_place,
    step_variance_seen,
)

BATCH_DOF = BATCHES - 1  #: degrees of freedom of one pose's batches; definition
MEDIAN_OF_CHI2_5 = 4.3515  #: median of chi-square with BATCH_DOF; definition
LEAST_BY_CHANCE = 0.042
"""0.1 % quantile of chi-square with BATCH_DOF over BATCH_DOF, a fact: a calmer pose shows a
converter's step or a frozen block, not the similarity of the poses."""
NEWTON_STEPS = 20
"""Steps of the inverse of the trigamma function; it converges quadratically and from one side.
Numerical."""
SIMILAR_LENGTH = 1.3
"""Runs whose poses differ by less than this factor in length share one correlation. Derived: their
correlation times over the length then differ by no more than neighbours of the grid do."""

NOISE_DOF_PER_POSE = 2.0
"""Degrees of freedom that a pose adds to the estimate of the noise. A judgement: its batches have
five on each axis, but poses differ, and with more an error of single poses gets a name."""

LARGEST_FACTOR = 5.0
"""Largest factor, that of noise correlated over 0.3 of a pose: poses show too little of longer
correlation. Derived."""

SHORTEST_S, LONG_ENOUGH_S = 2.0, 8.0
"""With noise correlated over half a second, as low-cost sensors have it, alone or below three times
as much white noise, 90 to 94 % at 1.5 s, 94 to 95 % at 3 s and 95 % at 8 s are within 1.96 sds.
Tuned on ``tests/calib/poses/pose_mean_coverage.py``, 25 sessions each."""

LOWEST_HARMONICS = 4
"""Number of harmonics: slow enough for noise that stays correlated over a tenth of the log, and
with three axes enough degrees of freedom (24) for a small Student's factor. Derived."""


def variance_of_mean(values: FloatArray) -> FloatArray:
    """Variance of the mean of each of k columns of samples.

    The axes of one triad share the spectrum of their noise: its excess over white noise is
    estimated from all of them together, and never as less than 1. Student's factor allows for the
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
    """Sd of each pose mean by its batches, (n, 3), combined with those of the run's other poses.

    A pose's own estimate has 5 degrees of freedom, too few to weight by. The typical variance of
    the run, scaled to the length of the pose, counts for more of them the more similar the poses
    are (:func:`shared_dof`): on a bench it dominates, among poses held in a hand it hardly counts.
    As a median, it does not follow the few disturbed poses. Student's factor allows for few degrees
    of freedom. A pose calmer than the typical one counts as typical: its batches show the fast
    noise only, and slower noise is the same in all poses.
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

    The poses' true variances are assumed to scatter about a typical one by an inverse chi-square.
    The logarithms of their estimates then scatter by trigamma(d/2) for the BATCH_DOF of an estimate
    and trigamma(d0/2) for the unknown d0.

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


def by_length(runs: Sequence[Sequence[PoseMean]]) -> list[list[int]]:
    """Groups of ``runs`` with poses of equal length, which share one correlation."""
    length = [float(np.median([mean.duration_s for mean in means])) for means in runs]
    groups: list[list[int]] = []
    for i in sorted(range(len(runs)), key=lambda i: length[i]):
        if groups and length[i] <= SIMILAR_LENGTH * length[groups[-1][0]]:
            groups[-1].append(i)
        else:
            groups.append([i])
    return groups


def _together(runs: Sequence[Sequence[PoseMean]], group: Sequence[int]) -> list[PoseMean]:
    return [mean for i in group for mean in runs[i]]


def common_courses(
    runs: Sequence[Sequence[PoseMean]], triad: Triad
) -> tuple[CommonCourse, ...]:
    """The course that the poses of each length have in common, where they show one."""
    courses = (common_course(_together(runs, group), triad) for group in by_length(runs))
    return tuple(course for course in courses if course is not None)


def sd_dof(runs: Sequence[Sequence[PoseMean]], triad: Triad) -> float | None:
    """Degrees of freedom of the sds of all runs; None where there are none.

    The variance of each group of poses has an uncertainty by their number and by their correlation.
    """
    scatter, total = 0.0, 0
    for group in by_length(runs):
        means = without_course(_together(runs, group), triad)
        total += len(means)
        by_number = NOISE_DOF_PER_POSE * len(means)
        scatter += len(means) ** 2 * (1 / correlation_of(means, triad).dof + 1 / by_number)
    return total**2 / scatter if total else None


def too_short(means: Sequence[PoseMean], triad: Triad, run: str) -> str | None:
    """Reason why the sds of these pose means may not hold, or None where they do.

    Means over a few correlation times follow the noise itself: the poses do not show its extent.
    """
    lengths = np.sort([mean.duration_s for mean in means])
    total = np.cumsum(lengths)  # half of the recorded time is in poses no longer than:
    seconds = float(lengths[np.searchsorted(total, total[-1] / 2)])
    wanders = correlation_of(without_course(means, triad), triad).factor > LARGEST_FACTOR
    if not wanders and seconds >= SHORTEST_S:
        return None
    seen = (
        f"within them the {triad}'s readings wander as a whole (their noise stays correlated over "
        f"a third of a pose and longer)"
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
    parts = [np.zeros((0, 3))] * len(runs)
    for group in by_length(runs):
        bare = without_course(_together(runs, group), triad)
        widening, of_group = correlation_of(bare, triad).widening, iter(bare)
        for i in group:
            run = list(islice(of_group, len(runs[i])))
            parts[i] = pooled_sd(run, triad) * np.sqrt(widening)
    return np.concatenate(parts)


def pose_mean_sd(runs: Sequence[Sequence[PoseMean]], triad: Triad) -> FloatArray:
    """Sd (n, 3), nominal m/s² or rad/s, of every pose mean of all runs, one after another.

    It combines noise and converter steps; for a gyroscope also the rate at which a pose at rest
    crept, for an accelerometer the gravity lost by rocking.

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


def variance_by_steps(means: Sequence[TriadMean]) -> FloatArray:
    """Variance of the means of one run by the converter's steps, shape (3,), SI squared."""
    scatter = np.array([mean.scatter for mean in means])
    variance = np.array([mean.variance for mean in means])
    step, least = known_step(means), min(len(mean.envelope) for mean in means) or BATCHES
    rounding = np.maximum(PRINTED_TOLERANCE * step**2, NO_LENGTH)  # a constant shows no step
    ratio = (scatter + rounding) / (variance + rounding / least)
    samples = np.array([np.median(axis[shows]) if shows.any() else least
                        for axis, shows in zip(ratio.T, (scatter > rounding).T, strict=True)])
    logged = [mean.envelope[0, 0] if len(mean.envelope) else mean.mean for mean in means]
    above = np.array([mean.mean for mean in means]) - logged
    return step_variance_seen(step, scatter, above, samples)


def known_step(means: Sequence[TriadMean]) -> FloatArray:
    """The step of a converter, SI, shape (3,): the least that a pose shows, or that is possible."""
    step = np.min([mean.step for mean in means], axis=0)
    unit = np.min([mean.unit for mean in means], axis=0)
    return np.asarray(np.where(np.isfinite(step), step, unit))
