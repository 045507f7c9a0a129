"""Stretches of a log whose windows stay below one threshold of variance.

A stretch becomes a rest if it is long enough after its ends are cut off. A rest that wanders, or
during which the plate stood still, carries its fault and is not used as a pose.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.special import gammaincinv

from calib.earth import STANDARD_GRAVITY_M_S2
from calib.errors import Undetermined
from calib.numbers import NO_LENGTH
from calib.poses.checks.pose_checks import is_still, stray_of
from calib.poses.data_sheet import Specs
from calib.poses.imu_log import SI_UNIT, TRIADS, BoolArray, FloatArray, ImuLog, Triad
from calib.poses.reference import PLAUSIBLE_RATIO
from calib.poses.rests.still_search import StillSearch
from calib.poses.samples.batches import SHORTEST_SAMPLES
from calib.poses.samples.running_sums import RunningSums

WINDOW_S = 0.5
"""The shortest stop that people make on purpose. In ``tests.bench.study_static_intervals`` a
quarter of a second finds the same stops where a gyroscope was logged beside, and takes movement
for stops (0.5 %) where none was. Tuned."""

FEWEST_WINDOW = 8  #: samples; derived: the sd of a variance is a third of it
QUIETEST_SHARE = 0.05
"""Share of rest in a log below which, a minute of twenty, it never rests. A judgement."""

LARGEST_SWING: dict[Triad, float] = {"accelerometer": 1.0, "gyroscope": 0.09}
"""From peak to peak, m/s² and rad/s: what no stop does. 5 °/s is no turn of a plate either.
Tuned in the study: half of it loses 4 % of the stops, all in trembling hands."""

LARGEST_TURN = 0.18
"""From peak to peak, rad/s (10 °/s), of a gyroscope beside the accelerometer: a turn about the
vertical, which the accelerometer does not sense. Tuned in the study."""

SWING_PER_SD = 2 * math.sqrt(2)
"""Peak to peak of a sinusoid in units of its sd. Definition."""

MARGIN_SHARE, MARGIN_S = 0.1, 0.25
"""Cut off both ends of a stretch, the smaller of the two: a still window may hold the last of a
movement. Tuned."""

SAME_ATTITUDE = math.radians(2.0)
"""Angle below which consecutive rests are pieces of one, unless the sensor was moved between. It is
also the largest wander of an attitude within a rest: its mean then is short by θ²/24. Derived."""

MOST_BLOCKS = 8
"""Parts of a rest whose means are compared: enough of them to see a slow turn, few enough to
average. A judgement."""

WANDER_M_S2 = STANDARD_GRAVITY_M_S2 * SAME_ATTITUDE
"""The same as a change of the accelerometer's reading."""

PLATE_STOOD = "the plate stood still"
OF_ANOTHER_RUN = "the plate turned as in another run"
PLATE_STANDS = 1 / PLAUSIBLE_RATIO
"""Share of the plate's rate. No data sheet is so wrong: below it the plate stood still. Derived."""


@dataclass(frozen=True)
class Rest:
    """Samples ``start`` to ``stop``; ``fault`` is the reason why they cannot be used as a pose."""

    start: int
    stop: int
    fault: str | None = None


@dataclass(frozen=True, eq=False)
class DecidingTriad:
    """The triad that decides where a log rests.

    Parameters
    ----------
    label : str
    triad : str
    values : array, shape (t, 3)
        Nominal readings, SI.
    sums : RunningSums
        Of the readings.
    time_s : array, shape (t,)
    step_s : float
    variance : array, shape (t - window + 1,)
        Of every window, summed over the axes, in the square of the readings' unit.
    window, shortest : int
        Samples of a window, and of the shortest rest.
    rate_rad_s : float
        Rate of the plate, 0 at rest.
    smallest_variance : float
        What a converter's step makes by itself, in the same unit.
    turning : array, shape (t - window + 1,)
        Windows in which a gyroscope beside a deciding accelerometer speeds up or slows down.
    step : float
        Of the converter, SI; 0 where it is not known.
    force : RunningSums or None
        Of an accelerometer beside a deciding gyroscope: it shows the direction of the plate.
    signed_rad_s : tuple of float
        Rate of the plate, then those at which other runs use the log.
    """

    label: str
    triad: Triad
    values: FloatArray
    sums: RunningSums
    time_s: FloatArray
    step_s: float
    variance: FloatArray
    window: int
    shortest: int
    rate_rad_s: float
    smallest_variance: float
    turning: BoolArray
    step: float = 0.0
    force: RunningSums | None = None
    signed_rad_s: tuple[float, ...] = (0.0,)

    @property
    def unit(self) -> str:
        """SI unit of the readings."""
        return SI_UNIT[self.triad]

    @property
    def quietest(self) -> float:
        """Variance of white noise whose quietest windows are like these."""
        positive = self.variance[self.variance > 0]
        if positive.size == 0:
            return self.smallest_variance
        dof = 3 * (self.window - 1)
        quantile = 2 * float(gammaincinv(dof / 2, QUIETEST_SHARE))  # of chi-square
        white = quantile / (dof + 3)
        return max(float(np.quantile(positive, QUIETEST_SHARE)) / white, self.smallest_variance)

    @property
    def ceiling(self) -> float:
        """Largest variance of a window within a rest."""
        return (LARGEST_SWING[self.triad] / SWING_PER_SD) ** 2

    @property
    def magnitude(self) -> float | None:
        """Expected magnitude of all poses, SI; None for a gyroscope at rest."""
        return STANDARD_GRAVITY_M_S2 if self.triad == "accelerometer" else self.rate_rad_s or None

    @property
    def largest_wander(self) -> float:
        """Largest movement of the mean within a rest, SI."""
        if self.magnitude is None:
            return LARGEST_SWING[self.triad]
        return self.magnitude * SAME_ATTITUDE

    def mean(self, rest: Rest) -> FloatArray:
        """Mean reading (3,), SI."""
        return self.sums.mean(rest.start, rest.stop)

    def stray(self, rest: Rest) -> float:
        """Largest wander of a rest over its three axes, SI."""
        return float(stray_of(self.values[rest.start : rest.stop]).max())

    def span(self, rest: Rest) -> str:
        """Time of a rest since the log began, in words."""
        begun, ended = self.time_s[[rest.start, rest.stop - 1]] - self.time_s[0]
        return f"{begun:.1f}-{ended:.1f} s"


def deciding_triad(
    log: ImuLog,
    specs: Specs,
    rate_rad_s: float,
    search: StillSearch,
    elsewhere_rad_s: Sequence[float] = (),
) -> DecidingTriad:
    """The accelerometer at rest, the gyroscope on the turning plate, or the one that was logged.

    Raises
    ------
    Undetermined
        The log is too short, or holds no triad with a data sheet.
    """
    signed, rate_rad_s = (rate_rad_s, *elsewhere_rad_s), abs(rate_rad_s)
    logged = [triad for triad in TRIADS if triad in specs and log.has(triad)]
    if not logged:
        raise Undetermined(
            f"{log.label}: holds no triad that the sensor's data sheet describes. Name its "
            f"columns, or describe the other triad under sensor."
        )
    triad = logged[-1] if rate_rad_s > 0 else logged[0]
    spec = specs[triad]
    step_s = float(np.median(np.diff(log.time_s)))
    seconds = WINDOW_S if search.seconds is None else search.seconds
    window = max(FEWEST_WINDOW, round(min(WINDOW_S, seconds) / step_s))
    turn_s = 2 * math.pi / rate_rad_s if rate_rad_s else 0.0  # its mean is taken over whole turns
    shortest = max(SHORTEST_SAMPLES, math.ceil((1 - 2 * MARGIN_SHARE) * seconds / step_s),
                   math.ceil(turn_s / step_s) + 1)
    if len(log.time_s) < 2 * max(window, shortest):
        raise Undetermined(
            f"{log.label}: {len(log.time_s)} samples ({log.time_s[-1] - log.time_s[0]:.1f} s) are "
            f"too few to look for still poses; each pose needs {shortest} samples or more."
        )
    values = spec.nominal(log.readings(triad))
    step = 0.0 if spec.encoding == "si" else spec.nominal_scale
    rounding = np.finfo(float).eps * float(np.square(values).max())
    smallest = max(3 * step**2 / 12, rounding, NO_LENGTH)
    sums = RunningSums.of(values)
    variance = sums.window_variance(window)
    turning = np.zeros(len(variance), dtype=bool)
    beside = {other: RunningSums.of(specs[other].nominal(log.readings(other)))
              for other in logged if other != triad}
    if "gyroscope" in beside:
        rate = beside["gyroscope"].window_variance(window)
        turning = rate > (LARGEST_TURN / SWING_PER_SD) ** 2
    return DecidingTriad(log.label, triad, values, sums, log.time_s, step_s, variance, window,
                         shortest, rate_rad_s, smallest, turning, step,
                         beside.get("accelerometer"),
                         signed if beside else tuple(map(abs, signed)))


def rests_below(triad: DecidingTriad, threshold: float) -> list[Rest]:
    """All stretches whose windows stay below a variance, in time order; samples are used once."""
    still = (triad.variance <= threshold) & ~triad.turning
    edges = np.flatnonzero(np.diff(np.concatenate([[0], still.astype(np.int8), [0]])))
    rests: list[Rest] = []
    free = 0  # a window that is still may begin inside the stretch before
    for first, last in zip(edges[::2], edges[1::2], strict=True):
        start, stop = max(int(first), free), int(last) - 1 + triad.window
        margin = round(min(MARGIN_SHARE * (stop - start), MARGIN_S / triad.step_s))
        if stop - start - 2 * margin >= triad.shortest:
            free = stop
            rest = Rest(start + margin, stop - margin)
            rests.append(replace(rest, fault=_fault(triad, rest)))
    return rests


def _fault(triad: DecidingTriad, rest: Rest) -> str | None:
    """Reason why a quiet stretch is not a pose: it turned slowly, or the plate stood still or at
    another run's rate."""
    samples = rest.stop - rest.start
    count = min(max(2, samples // triad.window), MOST_BLOCKS)
    means = triad.sums.means(rest.start + samples // count * np.arange(count + 1))
    wander = float(np.linalg.norm(np.ptp(means, axis=0)))
    if wander > triad.largest_wander:
        return f"moved slowly (by up to {wander:.2g} {triad.unit})"
    if triad.triad == "accelerometer":
        return None
    turn = triad.mean(rest)
    up = turn if triad.force is None else triad.force.mean(rest.start, rest.stop)
    rate = math.copysign(float(np.linalg.norm(turn)), turn @ up)
    if min(triad.signed_rad_s, key=lambda one: abs(rate - one)) != triad.signed_rad_s[0]:
        return OF_ANOTHER_RUN
    return PLATE_STOOD if abs(rate) < PLATE_STANDS * triad.rate_rad_s else None


def longest_pieces(triad: DecidingTriad, rests: Sequence[Rest]) -> list[Rest]:
    """The longest rest of each group of pieces: the others add no information.

    A gyroscope at rest reads the same in every attitude: there all pieces are used.
    """
    if triad.magnitude is None:
        return list(rests)
    groups: list[list[Rest]] = []
    for rest in rests:
        if groups and not _moved_between(triad, groups[-1][-1], rest):
            groups[-1].append(rest)
        else:
            groups.append([rest])
    return [max(pieces, key=lambda rest: rest.stop - rest.start) for pieces in groups]


def _moved_between(triad: DecidingTriad, one: Rest, other: Rest) -> bool:
    between = slice(one.stop, max(one.stop + 1, other.start - triad.window + 1))
    if bool((triad.variance[between] > triad.ceiling).any() or triad.turning[between].any()):
        return True
    change = float(np.linalg.norm(triad.mean(other) - triad.mean(one)))
    return change > triad.largest_wander


def steady_part(triad: DecidingTriad, rest: Rest, largest_shift: float) -> Rest:
    """The longest part of a rest, at least half of it, whose stray is within ``largest_shift``.

    A hand lets go late, and foam settles. The whole rest if there is no such part.
    """
    step = (rest.stop - rest.start) // MOST_BLOCKS
    for cut in range(MOST_BLOCKS // 2 + 1):
        for head in range(cut, -1, -1):
            part = Rest(rest.start + head * step, rest.stop - (cut - head) * step)
            if part.stop - part.start < triad.shortest:
                return rest
            if is_still(triad.values[part.start : part.stop], triad.step, largest_shift):
                return part
    return rest
