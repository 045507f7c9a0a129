"""Static intervals in one long log: by hand, on a gimbal, on a table, on the turning plate.

The variance of a sliding window, summed over the axes, is compared with a threshold. No threshold
suits every log: on a table a sensor shows its own noise, in a hand many times as much. So
thresholds are searched (Tedaldi, Pretto, Menegatti, ICRA 2014), from the variance of the quietest
twentieth of the log upwards by factors of THRESHOLD_STEP, and the one whose rests make the best
calibration is taken (:mod:`calib.poses.rests.attitude_fit`). A rest that a threshold cuts into
pieces counts once. A stretch that swings by metres per second squared is never at rest, whatever
the search gives.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from calib.errors import Undetermined
from calib.poses.checks.pose_checks import LARGEST_STILL_SHIFT, WANDERS
from calib.poses.checks.stray_samples import far_samples
from calib.poses.data_sheet import Specs
from calib.poses.imu_log import TRIADS, FloatArray, ImuLog, Triad
from calib.poses.rests.attitude_fit import best_threshold
from calib.poses.rests.rest_candidates import (
    QUIETEST_SHARE,
    WANDER_M_S2,
    DecidingTriad,
    Rest,
    deciding_triad,
    longest_pieces,
    rests_below,
    steady_part,
)
from calib.poses.rests.still_search import StillSearch

STILL_RATIO = 4.0
"""Twice the noise amplitude of the quietest rest: below it noise alone cuts rests to pieces. Half
or twice of it moves 0.1 % of the stops in ``tests.bench.study_static_intervals``. Derived."""

MOMENTS, MOMENT_SHARE, MOMENT_S = 0.25, 0.2, 1.0
"""Largest share of the stops that are moments of a hand between the rests; their length over that
of the shortest rests, and their length, s. A judgement: who lays a sensor down lets go of it for
seconds, and a moment just exceeds the shortest stop that is looked for."""

THRESHOLD_STEP = 2.0  #: factor of a variance: 1.4 of an amplitude; a judgement
SEARCH = StillSearch()


@dataclass(frozen=True, eq=False)
class StaticIntervals:
    """The rests of a log, in time order, each as a log of its own.

    Parameters
    ----------
    logs : tuple of ImuLog
    triad : str
        The triad that decided.
    threshold : float
        The multiple of the quietest rest's noise amplitude up to which a stop is a rest.
    largest_shift : float
        By how much a rest may stray, m/s² or rad/s (:mod:`calib.poses.checks.pose_checks`); of one
        that strays by more the part is taken that does not, if it is half of it or more.
    skipped : tuple of (str, str)
        Stops that are not among the rests: when they were, and why.
    """

    logs: tuple[ImuLog, ...]
    triad: Triad
    threshold: float
    largest_shift: float
    skipped: tuple[tuple[str, str], ...] = ()


def find_still(
    log: ImuLog,
    specs: Specs,
    rate_rad_s: float = 0.0,
    search: StillSearch = SEARCH,
    elsewhere_rad_s: Sequence[float] = (),
) -> StaticIntervals:
    """The static intervals of a log; on a plate that turns at ``rate_rad_s``, the steady ones.

    Parameters
    ----------
    log : ImuLog
    specs : mapping of triad to TriadSpec
        The data sheets; a triad without one is not looked at.
    rate_rad_s : float
        Rate of the plate, of either sign; 0 where the log was taken at rest.
    search : StillSearch
        What the user overrules.
    elsewhere_rad_s : sequence of float
        Rates, signed alike, at which other runs use the same log; what turned so is theirs.

    Raises
    ------
    Undetermined
        The log is too short, or never rests.
    """
    triad = deciding_triad(log, specs, rate_rad_s, search, elsewhere_rad_s)
    thresholds = _thresholds(triad, search)
    sets = [rests_below(triad, threshold) for threshold in thresholds]
    poses = [_on_purpose(triad, search, longest_pieces(
        triad, [rest for rest in rests if rest.fault is None])) for rests in sets]
    best = _best(triad, poses, thresholds)
    if not poses[best]:
        raise Undetermined(_no_pose(triad, sets[best]))
    faulty = [rest for rest in sets[best] if rest.fault is not None]
    skipped = [rest for rest in (*faulty, *_noisier(triad, sets[best], thresholds[best]))
               if rest.stop - rest.start >= _longest_moment(triad, search, poses[best])]
    usual = float(np.median([triad.stray(rest) for rest in poses[best]]))
    largest = max(LARGEST_STILL_SHIFT[triad.triad], min(WANDERS * usual, WANDER_M_S2))
    rests = poses[best]
    if triad.triad == "accelerometer":  # a gyroscope's rests show how the plate turned
        rests = [steady_part(triad, rest, largest) for rest in rests]
    rests = _on_purpose(triad, search, [_without_moving_ends(log, rest) for rest in rests])
    return StaticIntervals(
        logs=tuple(log.between(rest.start, rest.stop, f"{log.label} {triad.span(rest)}")
                   for rest in rests),
        triad=triad.triad,
        threshold=math.sqrt(thresholds[best] / triad.quietest),
        largest_shift=largest,
        skipped=tuple((triad.span(rest), str(rest.fault))
                      for rest in sorted(skipped, key=lambda rest: rest.start)),
    )


def _on_purpose(
    triad: DecidingTriad, search: StillSearch, rests: Sequence[Rest]
) -> list[Rest]:
    """The rests without the moments between them in which a hand moves slowly."""
    longest = _longest_moment(triad, search, rests)
    return [rest for rest in rests if rest.stop - rest.start >= longest]


def _longest_moment(
    triad: DecidingTriad, search: StillSearch, rests: Sequence[Rest]
) -> float:
    """Samples below which a stop is too short beside ``rests`` to be made on purpose; 0 if the user
    states the shortest one."""
    if search.seconds is not None or not rests:
        return 0.0
    usual = float(np.quantile([rest.stop - rest.start for rest in rests], MOMENTS))
    return min(MOMENT_SHARE * usual, MOMENT_S / triad.step_s)


def _without_moving_ends(log: ImuLog, rest: Rest) -> Rest:
    """A rest without the samples at its ends at which either triad moved already."""
    parts = [still_part(log.readings(triad)[rest.start : rest.stop])
             for triad in TRIADS if log.has(triad)]
    return replace(rest, start=rest.start + max(part.start for part in parts),
                   stop=rest.start + min(part.stop for part in parts))


def still_part(values: FloatArray) -> slice:
    """The samples of one triad, of shape (t, 3), without those at either end that moved already.

    What moves a sensor begins slowly, so that a window that is still may hold its start. Where
    samples at an end are far from the median, as many before them, in which the motion does not yet
    exceed the noise, go too. All samples where less than half would remain: the checks of the pose
    speak of what moves throughout.
    """
    start, stop = 0, len(values)
    while 2 * (stop - start) > len(values):
        near = np.flatnonzero(~far_samples(values[start:stop]))
        first, last = int(near[0]), stop - start - 1 - int(near[-1])
        if first == last == 0:
            return slice(start, stop)
        start, stop = start + 2 * first, stop - 2 * last
    return slice(0, len(values))


def _thresholds(triad: DecidingTriad, search: StillSearch) -> list[float]:
    """The variances to try, the lowest first."""
    level, ceiling = triad.quietest, triad.ceiling
    if search.threshold is not None:
        return [level * search.threshold**2]
    if level > ceiling:
        raise Undetermined(_never_rests(triad))
    steps = max(0, math.ceil(math.log(ceiling / level / STILL_RATIO, THRESHOLD_STEP)))
    return [min(level * STILL_RATIO * THRESHOLD_STEP**k, ceiling) for k in range(steps + 1)]


def _best(
    triad: DecidingTriad, poses: Sequence[Sequence[Rest]], thresholds: Sequence[float]
) -> int:
    """Index of the threshold whose rests make the best calibration.

    If none makes one, and at rest if a gyroscope has nothing to measure, the common noise of the
    log decides: STILL_RATIO times the most common variance of the quieter half.
    """
    means = [np.array([triad.mean(rest) for rest in rests]).reshape(-1, 3) for rests in poses]
    best = None if triad.magnitude is None else best_threshold(means, triad.magnitude)
    if best is None:
        common = max(STILL_RATIO * quiet_level(triad.variance), triad.smallest_variance)
        best = int(np.argmin(np.abs(np.log(np.array(thresholds) / common))))
    return best


def quiet_level(variance: FloatArray) -> float:
    """The most common variance among the quieter half: the half-sample mode of its logarithm.

    The halving is that of Robertson and Cryer (JASA 69, 1974); it ends at 50 values, with their
    median.

    Parameters
    ----------
    variance : array, shape (n,)
        Variances of the windows, in any unit.

    Returns
    -------
    float
        In the same unit; 0 where no variance is positive.
    """
    positive = variance[variance > 0]
    if positive.size == 0:
        return 0.0
    sample = np.sort(np.log(positive))[: max(1, positive.size // 2)]
    while sample.size > 50:
        half = sample.size // 2
        narrowest = int(np.argmin(sample[half:] - sample[:-half]))
        sample = sample[narrowest : narrowest + half + 1]
    return float(np.exp(np.median(sample)))


def _noisier(triad: DecidingTriad, rests: Sequence[Rest], threshold: float) -> Iterator[Rest]:
    """Stops that a higher threshold would give, apart from those among ``rests``."""
    if threshold >= triad.ceiling:
        return
    for stop in rests_below(triad, triad.ceiling):
        if stop.fault is None and not any(
            rest.start < stop.stop and stop.start < rest.stop for rest in rests
        ):
            yield replace(stop, fault=f"noisier than {math.sqrt(threshold):.2g} {triad.unit} (sd)")


def _never_rests(triad: DecidingTriad) -> str:
    least, often = np.sqrt(np.quantile(triad.variance, [QUIETEST_SHARE, 0.5]))
    return (
        f"{triad.label}: the sensor never rests. The {triad.triad} scatters by more than "
        f"{least:.2g} {triad.unit} (sd over {triad.window} samples) in {1 - QUIETEST_SHARE:.0%} of "
        f"the log and by more than {often:.2g} {triad.unit} in half of it; in a rest it stays "
        f"below {math.sqrt(triad.ceiling):.2g} {triad.unit} for "
        f"{triad.shortest * triad.step_s:.2g} s or more. Let the sensor lie untouched for a few "
        f"seconds in every pose; `still: {{threshold: ...}}` beside `find: still` overrules this."
    )


def _no_pose(triad: DecidingTriad, rests: Sequence[Rest]) -> str:
    if not rests:
        return _never_rests(triad)
    listed = list_stops([(triad.span(rest), str(rest.fault)) for rest in rests])
    return (
        f"{triad.label}: none of its quiet stretches is a pose: {listed}. If that is wrong, the "
        f"data sheet's range or unit of the {triad.triad} is another, or its columns are."
    )


def list_stops(stops: Sequence[tuple[str, str]]) -> str:
    """List of stops as one phrase, those with the same reason together.

    Parameters
    ----------
    stops : sequence of (str, str)
        When each stop was, and the reason why it was left out.
    """
    reasons = dict.fromkeys(reason for _, reason in stops)
    return "; ".join(
        f"{', '.join(span for span, why in stops if why == reason)}: {reason}"
        for reason in reasons
    )
