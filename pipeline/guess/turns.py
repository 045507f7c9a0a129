"""Unit and axes of a gyroscope from the turns of gravity in an accelerometer.

The direction u of gravity in an accelerometer moves as ``du/dt = -ω × u``. Its change from one
rest to the next, at which no hand pushes the sensor, and the integral of ``-ω × u`` show the order,
signs and handedness of the gyroscope's axes; a push between the rests averages out. The size of the
unit (times that of the clock) follows from the whole rotation between two rests. In a log with too
few rests the changes between successive blocks of samples show the axes.
"""

import math
from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import minimize_scalar
from scipy.spatial.transform import Rotation

from calib.poses.imu_log import AXES, FloatArray, IntArray
from pipeline.guess.pool import (
    AT_REST,
    FEWEST_MEANS,
    FLATTEST,
    REST_S,
    are_still,
    block_rows,
    common_mean,
    sphere_through,
    stops_of,
)

AGREEMENT = 0.7
"""Least correlation of the turns by three columns and by gravity that shows a gyroscope whatever
the names. A judgement: the correlations of sound logs in ``tests`` are 0.9 or more."""
LEAST_TURN = 0.02
"""Least change of the direction of gravity in a turn, rad, that is not noise."""

BLOCK_S = 0.1
"""Length of a block, s: a hand turns by less than a right angle in it, and noise averages out.
Tuned: ``tests.bench.study_import``, half changes two and double three of 37 sets."""
FEWEST_TURNS = 8
"""Least number of turns. Derived: among their 24 components a correlation of ``AGREEMENT``
with one of 48 arrangements of axes is chance in one of 300 (t = 4.6)."""
FEWEST_WAYS = 4
"""Least number of rotations between rests that show the size of a unit. Derived: the sd by one is
that of a rest that shifts by a degree over a turn of one radian, 2 %, by four 1 %."""
PUSHED = math.log(1.4)
"""Largest log error of the unit by blocks, in which a hand pushes: four times the error of the
worst of 54 simulated logs, 8 %. A judgement."""
WIDEST_MISS = 0.5
"""Angle, rad, at which the misclosure of a rotation is capped: its clock has a gap. A judgement:
sound rotations close within 0.02."""
LARGEST_MISS = 0.06
"""Largest median misclosure of rotations between rests over their turn of gravity. A judgement: it
is 0.02 at most in 60 logs with rests, and 0.12 to 0.7 in those that never rest, of which the
stillest blocks are none."""
NEAREST = math.cos(math.radians(22.5))
"""Cosine of the largest angle between gravity and a gyroscope's reading on the plate. Derived: half
of the 45° between neighbouring attitudes of a calibration."""
OWN = ", ".join(f"+{axis}" for axis in AXES)  #: axes as those of the accelerometer
WAYS = Rotation.create_group("O").as_matrix().round()
"""Every order and sign of right-handed axes, (24, 3, 3); left-handed ones have the opposite
sign."""


@dataclass(frozen=True)
class Turn:
    """Comparison of three columns with the turns of gravity.

    ``si_per_unit`` is rad/s per unit by the clock of the log, ``axes`` are those of the
    accelerometer about which they turn, and ``agreement`` is the correlation. ``is_exact``: the
    size follows from rotations between rests, to a percent; else a hand's push biases it by 10 %.
    """

    si_per_unit: float
    agreement: float
    axes: str
    is_exact: bool = False

    @property
    def is_sure(self) -> bool:
        """Whether it shows that the columns are a gyroscope."""
        return self.agreement >= AGREEMENT


def turn_of(
    rate: FloatArray, force: FloatArray, table: IntArray, step_s: float | FloatArray
) -> Turn | None:
    """Comparison of a gyroscope with the turns of gravity; None if gravity does not turn.

    The axes are the accelerometer's own if these agree, else those that agree best.

    Parameters
    ----------
    rate : array, shape (t, 3)
        Readings of the gyroscope in its unit.
    force : array, shape (t, 3)
        Readings of the accelerometer in any unit.
    table : array, shape (t,)
        The table of each row.
    step_s : float, or array (t,)
        Time from each row to the next, s: rows are lost, and a logger changes its rate.
    """
    steps = np.broadcast_to(step_s, len(table))[:, None]
    rows, tables = block_rows(table, max(1, round(BLOCK_S / float(np.median(steps)))))
    if len(rows) < FEWEST_TURNS:
        return None
    up = force / np.maximum(np.linalg.norm(force, axis=1, keepdims=True), np.finfo(float).tiny)
    means = up[rows].mean(axis=1)
    moves = _moves(np.flatnonzero(are_still(force[rows])), means, tables)
    moves = moves[:, np.diff(moves, axis=0)[0] > 1]
    between_rests = moves.shape[1] >= FEWEST_WAYS
    begin, end = (moves if moves.shape[1] >= FEWEST_TURNS else
                  _moves(np.arange(len(rows)), means, tables))
    if len(begin) < FEWEST_TURNS:
        return None
    # Just before and after a move a plate stands too.
    rate = rate - np.median(rate[(rows[moves] if between_rests else rows).ravel()], axis=0)
    # The prediction of axes W is the integral of u × (W reading), linear in its nine elements.
    products = up[:, :, None] * (steps * rate)[:, None, :]
    integral = (np.cumsum(products, axis=0) - products / 2)[rows].mean(axis=1)
    cross = np.cross(np.eye(3)[:, None], np.eye(3))
    linear = np.einsum("bda,kbc->kadc", cross, integral[end] - integral[begin]).reshape(-1, 9)
    seen, ways = means[end] - means[begin], WAYS.reshape(-1, 9)
    power = np.einsum("wi,ij,wj->w", ways, linear.T @ linear, ways)
    if not (power > 0).all():
        return None
    common = ways @ (linear.T @ seen.ravel())
    agreement = common / np.sqrt(power * (seen**2).sum())
    same = int(np.argmax(np.trace(WAYS, axis1=1, axis2=2)))
    best = same if agreement[same] >= AGREEMENT else int(np.abs(agreement).argmax())
    hand = math.copysign(1.0, float(agreement[best]))
    axes = ", ".join(f"{'-' if column.sum() < 0 else '+'}{AXES[int(np.abs(column).argmax())]}"
                     for column in WAYS[best].T * hand)
    shown = Turn(float(abs(common[best] / power[best])), float(abs(agreement[best])), axes)
    if not (shown.is_sure and between_rests):
        return shown
    turned = steps * rate @ WAYS[best].T * (hand * shown.si_per_unit)
    size, miss = _size_between_rests(turned, force, rows[moves])
    return shown if miss > LARGEST_MISS else replace(
        shown, si_per_unit=shown.si_per_unit * size, is_exact=True)


def is_along_gravity(
    rate: FloatArray, force: FloatArray, table: IntArray, step_s: float
) -> bool:
    """Whether columns are parallel to gravity on a turning plate, and equal in all poses at rest.

    Both triads are steady in the stops that count. This excludes a magnetometer, which rotates on
    the plate, and an accelerometer, which differs between poses at rest.

    Parameters
    ----------
    rate, force : array, shape (t, 3)
        Readings of the gyroscope and the accelerometer in any unit.
    table : array, shape (t,)
        The table of each row.
    step_s : float
        Time from row to row, s.
    """
    rows, tables = block_rows(table, max(1, round(REST_S / step_s)))
    if not len(rows):
        return False
    at = np.flatnonzero(are_still(rate[rows]))
    both = np.concatenate([rate, force], axis=1)[rows[at]]
    # The force may be a field that goes round; a stop ends with its table.
    stops = [both[stop].reshape(-1, 6) for stop in stops_of(
        at + tables[at], both[..., :3].mean(axis=1))]
    mean = np.array([stop.mean(axis=0) for stop in stops])
    zero = common_mean(mean[:, :3]) if len(mean) >= FEWEST_MEANS else None
    if zero is None:
        return False
    vectors = np.stack([mean[:, :3] - zero, mean[:, 3:]])
    size = np.linalg.norm(vectors, axis=2)
    turning = size[0] > AT_REST * size[0].max()
    sd = np.array([stop.std(axis=0) for stop in stops]).reshape(-1, 2, 3).max(axis=2).T
    turning &= (sd < AT_REST * size).all(axis=0)  # a hand turns gravity too
    if turning.sum() < FEWEST_MEANS:
        return False
    moved, up = vectors[:, turning] / size[:, turning, None]
    extent = np.linalg.svd(up, compute_uv=False)
    along = np.abs(np.einsum("ki,wij,kj->wk", moved, WAYS, up)).min(axis=1)
    return bool(along.max() > NEAREST and extent[-1] > FLATTEST * extent[0])


def _moves(nodes: IntArray, means: FloatArray, tables: IntArray) -> IntArray:
    """Begins and ends (2, n), of successive ``nodes`` (r,) of one table between which gravity
    turns; ``means`` (k, 3) and ``tables`` (k,) are those of all blocks."""
    begin, end = nodes[:-1], nodes[1:]
    turn = np.linalg.norm(means[end] - means[begin], axis=1)
    return np.stack([begin, end])[:, (turn > LEAST_TURN) & (tables[end] == tables[begin])]


def _size_between_rests(
    turned: FloatArray, force: FloatArray, rests: IntArray
) -> tuple[float, float]:
    """The factor by which turns from row to row (t, 3), rad, are too small, and the median
    misclosure of the rotations with it, over their turns of gravity.

    ``rests`` (2, n, size) are the rows of the still blocks before and after each of n moves.
    """
    means = force[rests].mean(axis=2)
    sphere = sphere_through(means.reshape(-1, len(AXES)))
    up = means - (0 if sphere is None else sphere.centre)
    before, after = up / np.linalg.norm(up, axis=2, keepdims=True)
    middle = rests[:, :, rests.shape[2] // 2]
    lengths = middle[1] - middle[0]
    whole = 1 << int(lengths.max() - 1).bit_length()
    steps = np.zeros((len(lengths), whole, 3))
    for way, length, first in zip(steps, lengths, middle[0], strict=True):
        way[:length] = turned[first : first + length]

    def away(size: float) -> FloatArray:
        turns = Rotation.from_rotvec(-math.exp(size) * steps.reshape(-1, 3))
        for _ in range(whole.bit_length() - 1):
            turns = turns[1::2] * turns[::2]
        return np.asarray(np.linalg.norm(turns.apply(before) - after, axis=1))

    size = minimize_scalar(lambda size: np.minimum(away(size), WIDEST_MISS).sum(),
                           bounds=(-PUSHED, PUSHED), method="bounded").x
    share = away(size) / np.linalg.norm(after - before, axis=1)
    return math.exp(size), float(np.median(share))
