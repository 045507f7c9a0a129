"""Pooled tables of one logger: what they have in common is decided once, on all their rows."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from calib.numbers import MEDIAN_OF_NORMAL
from calib.poses.imu_log import BoolArray, FloatArray, IntArray
from pipeline.guess.clocks import ClockGuess
from pipeline.guess.raw_tables import RawTable
from pipeline.logs.clock import ASSUMED_HZ, FEWEST_ROWS, USUAL_STEPS, unwrapped_ticks

REST_S = 0.5
"""Length of the blocks that are tested for rest, s. A judgement: shorter than a rest in a hand, and
long enough that noise averages out."""
STILLEST, STILL = 0.2, 3.0
"""Share of the blocks that are certainly at rest, and the largest scatter of a block at rest over
theirs. A judgement: a log for a calibration is at rest for a fifth of its time or more."""
MEANS_APART = np.radians(5.0)
"""Least median angle, rad, between successive rows of a table of pose means; no sensor is turned so
fast that its samples lie so far apart in half of the log."""
FEWEST_MEANS = 6  #: fact: number of parameters of bias and scale, with one equation per pose
FLATTEST = 0.2
"""Least ratio of the smallest to the largest extent of points that determine a sphere. A judgement:
it is 0 for two faces and the edges between them, 0.3 for six faces and a cone of 30 degrees."""
LARGEST_CENTRE, ROUNDEST = 0.7, 0.03
"""Largest distance of the centre over the radius, and the misfit above which it limits a sphere: a
bias of 0.7 g, or of 70 °/s at 17 rpm. Points that fit better may be volts, whose zero is far from
0. A judgement."""
LEAST_APART = 0.5
"""Least ratio of the distance of the readings at rest from their median to the scatter of a log. A
judgement: gravity in the attitudes of a calibration gives 1, a log of which it was removed 0.35."""
AT_REST = 0.1
"""Distance of two mean rates over the largest, below which both are at rest or in one attitude.
A judgement: on the plate the attitudes of a calibration lie 45 or 90 degrees apart."""


@dataclass(frozen=True, eq=False)
class PooledTables:
    """The rows of tables with the same columns, concatenated.

    Parameters
    ----------
    columns : mapping of str to array, shape (t,)
        All columns but those of times, and others that only grow.
    table : array, shape (t,)
        Index of the table of each row, from 0, or of its part between gaps of the clock; no unit.
    time_s : array, shape (t,)
        Times by the clock of each table.
    step_s : float
        Mean time from one row to the next, s, without gaps.
    has_clock : bool
        Whether ``step_s`` is known.
    hint : str
        ``acc`` or ``gyr``, if the file names state that all columns belong to that sensor.
    """

    columns: Mapping[str, FloatArray]
    table: IntArray
    time_s: FloatArray
    step_s: float
    has_clock: bool
    hint: str

    def readings(self, names: Sequence[str]) -> tuple[FloatArray, IntArray]:
        """The rows (t, k) in which all of these columns hold numbers, in their units, and
        the table index (t,) of each row."""
        values = np.column_stack([self.columns[name] for name in names])
        whole = np.isfinite(values).all(axis=1)
        return values[whole], self.table[whole]

    def steps(self, names: Sequence[str]) -> FloatArray:
        """Time (t,) from each row that :meth:`readings` gives to the next of its table, s."""
        whole = np.isfinite([self.columns[name] for name in names]).all(axis=0)
        steps = np.diff(self.time_s[whole], append=0.0)
        steps[np.diff(self.table[whole], append=-1) != 0] = self.step_s
        return np.asarray(steps)


def pooled(tables: Sequence[RawTable], clocks: Sequence[ClockGuess], hint: str) -> PooledTables:
    """The pool of tables with the same columns."""
    times = {clock.column for clock in clocks}
    counts = sum(table.rows for table in tables) >= FEWEST_ROWS  # means may be sorted by a reading
    names = [name for name in tables[0].columns if name not in times and not (
        counts and all(_only_grows(table.columns[name]) for table in tables))]
    columns = {name: np.concatenate([table.columns[name] for table in tables]) for name in names}
    steps = [usual_step(clock.time_s) for clock in clocks if len(clock.time_s) > 1]
    begins = [begins_of(clock.time_s if clock.column is None else
                        unwrapped_ticks(table.columns[clock.column]))
              for table, clock in zip(tables, clocks, strict=True)]
    return PooledTables(
        columns, np.cumsum(np.concatenate(begins)) - 1,
        np.concatenate([clock.time_s for clock in clocks]),
        float(np.median(steps)) if steps else 1 / ASSUMED_HZ,
        all(clock.is_known for clock in clocks), hint)


def _only_grows(values: FloatArray) -> bool:
    """Whether a column (t,) counts time or rows, as a second clock does and no reading."""
    step = np.diff(values)
    return bool(len(step) and (step >= 0).all() and np.median(step) > 0)


def begins_of(ticks: FloatArray) -> BoolArray:
    """Whether each row is first in a table, after a gap or a backward step of its ``ticks`` (t,).
    """
    begins = np.ones(len(ticks), bool)
    step = np.diff(ticks)
    if step.size:
        begins[1:] = (step < 0) | (step > USUAL_STEPS * np.median(step))
    return begins


def usual_step(time_s: FloatArray) -> float:
    """Mean step of times (t,), s, without gaps."""
    step = np.diff(time_s)
    return float(step[step <= USUAL_STEPS * np.median(step)].mean())


def block_rows(table: IntArray, size: int) -> tuple[IntArray, IntArray]:
    """Row indices (k, size) of all complete blocks within one table, and the table (k,) of each."""
    ends = [*(np.flatnonzero(np.diff(table)) + 1), len(table)]
    begins = [0, *ends[:-1]]
    starts = np.concatenate([np.arange(begin, end - size + 1, size)
                             for begin, end in zip(begins, ends, strict=True)])
    starts = starts.astype(np.int64)
    return starts[:, None] + np.arange(size), table[starts] if len(table) else starts


def are_apart(values: FloatArray) -> bool:
    """Whether readings (t, 3) turn from row to row, so that each row is a pose."""
    if len(values) < FEWEST_MEANS:
        return False
    unit = values / np.maximum(np.linalg.norm(values, axis=1, keepdims=True), 1e-12)
    apart = np.arccos(np.clip((unit[1:] * unit[:-1]).sum(axis=1), -1, 1))
    return bool(np.median(apart) > MEANS_APART)


def still_means(values: FloatArray, table: IntArray, step_s: float) -> FloatArray:
    """Means (k, 3) of the blocks of readings (t, 3) that are at rest, in their unit."""
    if are_apart(values):
        return values
    rows_a_table = np.bincount(table)
    usual = int(np.median(rows_a_table[rows_a_table > 0])) if len(table) else 1
    rows, _ = block_rows(table, max(1, min(round(REST_S / step_s), usual)))
    if not len(rows):
        return values
    blocks = values[rows]
    return np.asarray(blocks.mean(axis=1)[are_still(blocks)])


def reads_alike(force: FloatArray, step_s: float) -> bool:
    """Whether an accelerometer (t, 3) reads nearly the same in every rest."""
    means = still_means(force, np.zeros(len(force), np.int64), step_s)
    apart = np.linalg.norm(means - np.median(means, axis=0), axis=1)
    return bool(np.median(apart) <= LEAST_APART * float(np.linalg.norm(force.std(axis=0))))


def are_still(blocks: FloatArray) -> BoolArray:
    """Whether each block of readings (k, size, 3) is at rest: its scatter is near the least, or
    that of three axes between two neighbouring levels, where noise is less than one."""
    scatter = np.sqrt(blocks.var(axis=1).sum(axis=1))
    coarse = least_step(np.abs(np.diff(blocks, axis=1))) * math.sqrt(3) / 2
    return np.asarray(scatter <= max(STILL * np.quantile(scatter, STILLEST), coarse))


def least_step(steps: FloatArray) -> float:
    """The least of absolute ``steps`` that is not 0, as of a converter of few levels, else 0."""
    return float(steps[steps > 0].min(initial=np.inf)) if steps.any() else 0.0


def stops_of(at: IntArray, *means: FloatArray) -> list[IntArray]:
    """Indices of the still blocks ``at`` (k,) of each stop: neighbours in one attitude and motion
    by the means (k, 3) of the blocks, in their units.

    At rest a gyroscope reads its bias in stops of every attitude; on the plate it reads no vector
    in as many, however long each turn lasts.
    """
    moved = np.diff(at) > 1
    for mean in means:
        step = np.linalg.norm(np.diff(mean, axis=0), axis=1)
        moved |= step > AT_REST * np.linalg.norm(mean.std(axis=0))
    return np.split(np.arange(len(at)), 1 + np.flatnonzero(moved))


@dataclass(frozen=True, eq=False)
class Sphere:
    """A sphere through points: ``centre`` (3,), ``radius``, and ``misfit``, their sd over it."""

    centre: FloatArray
    radius: float
    misfit: float

    @property
    def is_far(self) -> bool:
        """Whether its centre is too far for a bias, as the zero of an analog output in volts."""
        return bool(np.linalg.norm(self.centre) > LARGEST_CENTRE * self.radius)


def sphere_through(points: FloatArray) -> Sphere | None:
    """The sphere through the points (k, 3); None if they do not determine one.

    Vectors of constant length lie on it: its radius is the unit, its centre the bias.
    """
    if len(points) < FEWEST_MEANS:
        return None
    extent = np.linalg.svd(points - points.mean(axis=0), compute_uv=False)
    if not extent[-1] > FLATTEST * extent[0]:
        return None
    known = np.column_stack([2 * points, np.ones(len(points))])
    solution = np.linalg.lstsq(known, (points**2).sum(axis=1), rcond=None)[0]
    centre = solution[:3]
    radius = float(np.sqrt(max(solution[3] + centre @ centre, 0.0)))
    off = np.abs(np.linalg.norm(points - centre, axis=1) - radius)
    sd = max(float(np.median(off)) / MEDIAN_OF_NORMAL, radius * np.finfo(float).eps)
    if sd > ROUNDEST * radius and np.linalg.norm(centre) > LARGEST_CENTRE * radius:
        return None
    return Sphere(centre, radius, sd / radius)


def common_mean(means: FloatArray) -> FloatArray | None:
    """Mean of the largest cluster of pose means (n, 3), in their unit: a gyroscope at rest.

    Of clusters as large the nearest to zero, as poses of one attitude on the plate are one too.
    None if the cluster has too few poses. Where all are at rest they differ by noise alone, which
    is little beside a bias that could be taken for the rate of a plate.
    """
    middle = (means.min(axis=0) + means.max(axis=0)) / 2
    largest = max(2 * np.linalg.norm(means - middle, axis=1).max(),
                  np.linalg.norm(means, axis=1).max())
    tree = cKDTree(means)
    near = tree.query_ball_point(means, AT_REST * largest, return_length=True)
    rows = np.flatnonzero(near == max(FEWEST_MEANS, near.max()))
    centres = []
    while len(rows):
        apart = np.linalg.norm(means - means[rows[0]], axis=1) <= AT_REST * largest
        centres.append(means[apart].mean(axis=0))
        rows = rows[~apart[rows]]  # in a ball with the first of them: the same cluster
    return min(centres, key=lambda mean: float(np.linalg.norm(mean)), default=None)
