"""When to calibrate again: changes between the sessions of a sensor, and their rate.

From one session to the next the parameters differ by their noise and by changes of the sensor. Both
cause an error of the corrected magnitude m, over all directions of

    D² = |δb|²/3 + m² (2 Σ δs_i² + (Σ δs_i)² + |δα|²) / 15

with δb the change of the biases (SI), δs of the scales (relative), δα of the misalignments (rad).
D² beyond the noise grows like a random walk, in proportion to time: q = Σ (D² - N²) / Σ t over
consecutive sessions. The expected error then passes a limit L at (L² - now²) / q.

A sensor may also move in one direction, by v a day, and pass it at √(L² - now²) / |v|. Steps
of a random walk add up to as much as they scatter about their mean, so that

    F = (|Σδ|² / Σt) / (Σ |δ - v t|² / t / (n - 1)),    v = Σδ / Σt

tells both apart where there are three sessions or more; else v only bounds the time from below.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import datetime
from itertools import pairwise
from operator import itemgetter

import numpy as np
from scipy.special import chdtri, fdtri

from calib.fit.parameters import TriadParameters
from calib.poses.imu_log import AXES, FloatArray
from pipeline.errors import UnreadableInput
from pipeline.results.comparison import ComparedTriad
from pipeline.results.history import read_history
from pipeline.results.read import Stored, StoredTriad
from pipeline.results.schema.triad import TriadSection

DAY_S = 86_400.0  #: definition
EPOCH_S = 1e9  #: fact: clocks that count from 1970 passed it in 2001, others never will
LEAST_DAYS = 0.5  #: between sessions; derived: an evening warms the sensor, it does not age it
FREEDOM = 3.0  #: degrees, of D² of two sessions; derived: three biases, the least it has
TWICE = 2.0  #: times the error to expect, the limit where none is stated. A choice
ONE_SD, CERTAIN = 0.1587, 0.05  #: tail probabilities of a range of one sd and of a bound. A choice


@dataclass(frozen=True)
class Ageing:
    """Changes of a triad between its sessions, in their order in time.

    Attributes
    ----------
    days : float
        From the first session to the last.
    moved, noise : float
        Rms of D beyond what noise explains (0 where it explains all), and of the noise, SI.
    is_steady : bool
        Whether the steps have one direction, and not those of a random walk.
    most : str
        The parameter that moved most between two sessions, in sds of their difference.
    now, limit : float
        Error to expect of the last calibration, and the one that must not be passed, SI.
    due_days : tuple of float
        After the last session: earliest, estimate, latest by one sd; infinite where nothing moved,
        and then the earliest at 95 %.
    """

    days: float
    moved: float
    noise: float
    is_steady: bool
    most: str
    now: float
    limit: float
    due_days: tuple[float, float, float]


def recorded_at(stored: Stored) -> float:
    """Time of recording of a session, s since 1970: by its logs, else its first run; else NaN."""
    start = stored.contents.session_start_s
    if start is not None and start > EPOCH_S:
        return start
    try:
        history = read_history(stored.folder)
    except UnreadableInput:
        return math.nan
    return datetime.fromisoformat(history[0].when).timestamp() if history else math.nan


def ageing_of(
    compared: ComparedTriad, times_s: Sequence[float], limit: float | None = None
) -> Ageing | None:
    """Rate of change of one triad.

    Parameters
    ----------
    compared : ComparedTriad
    times_s : sequence of float
        When each session was recorded.
    limit : float, optional
        SI; by default twice the error to expect of the last session.

    Returns
    -------
    Ageing or None
        None where fewer than two sessions of one model, one data sheet and other poses stand at
        least half a day apart.
    """
    sessions = sorted(
        ((time_s, one) for k, (time_s, one) in enumerate(zip(times_s, compared.stored, strict=True))
         if one is not None and math.isfinite(time_s) and compared.is_same_sheet(k)),
        key=itemgetter(0))
    stored = [one for _, one in sessions]
    if len({tuple(one.section.model) for one in stored}) != 1:
        return None
    sessions = _apart(sessions)
    prediction = stored[-1].section.prediction if stored else None
    if len(sessions) < 2 or prediction is None or prediction.sd_median is None:
        return None
    changes, spans, noise = zip(*(_step(*pair) for pair in pairwise(sessions)), strict=True)
    size = _size(sessions[-1][1].section)
    whole, noise2 = (sum(_squared(one, size) for one in changes),
                     sum(_expected(one, size) for one in noise))
    pairs, days, excess = len(changes), float(sum(spans)), whole - noise2
    now = prediction.sd_median
    limit = TWICE * now if limit is None else limit
    freedom = FREEDOM * pairs
    if excess <= 0 or whole / noise2 * freedom < chdtri(freedom, CERTAIN):
        upper = _variance(noise2, noise2, freedom, CERTAIN)
        return Ageing(days, 0.0, math.sqrt(noise2 / pairs), False, "", now, limit,
                      (_due(limit, now, upper / days), math.inf, math.inf))
    course = Pace.of(np.array(changes), np.array(spans), size)
    steady = course.due_days(limit, now)
    early, due, late = (_due(limit, now, q / days) for q in (
        _variance(whole, noise2, freedom, ONE_SD), excess,
        _variance(whole, noise2, freedom, 1 - ONE_SD)))
    if course.is_steady:
        changes, noise = (sum(changes),), (_step(sessions[0], sessions[-1])[2],)
    return Ageing(days, math.sqrt(excess / pairs), math.sqrt(noise2 / pairs), course.is_steady,
                  _most(changes, noise), now, limit,
                  steady if course.is_steady else (min(early, steady[1]), due, late))


Dated = tuple[float, StoredTriad]  #: a session and its time, s


def _apart(sessions: Sequence[Dated]) -> list[Dated]:
    """The sessions that are far enough from the one before."""
    kept: list[Dated] = []
    for one in sessions:
        if not kept or one[0] - kept[-1][0] >= LEAST_DAYS * DAY_S:
            kept.append(one)
    return kept


def _step(before: Dated, after: Dated) -> tuple[FloatArray, float, FloatArray]:
    """Change (9,) between two sessions, the days, and the variance (9,) of it by noise."""
    return (_change(before[1].parameters, after[1].parameters), (after[0] - before[0]) / DAY_S,
            _sd(before[1]) ** 2 + _sd(after[1]) ** 2)


def _most(changes: Sequence[FloatArray], noise: Sequence[FloatArray]) -> str:
    with np.errstate(divide="ignore", invalid="ignore"):
        sds = np.nan_to_num(np.abs(changes) / np.sqrt(noise))
    return _NAMES[int(sds.max(axis=0).argmax())]


@dataclass(frozen=True)
class Pace:
    """What steps have in common, SI a day, its sd, and whether they are of one direction."""

    per_day: float
    sd: float
    is_steady: bool

    @classmethod
    def of(cls, changes: FloatArray, spans: FloatArray, size: float) -> "Pace":
        """The course of changes (n, 9) over so many days (n,)."""
        total, days, more = changes.sum(axis=0), float(spans.sum()), len(spans) - 1
        together = _squared(total, size) / days
        if not more:
            return cls(math.sqrt(together / days), math.inf, is_steady=False)
        rest = sum(_squared(change - total / days * span, size) / span
                   for change, span in zip(changes, spans, strict=True)) / more
        by_chance = float(fdtri(FREEDOM, FREEDOM * more, 1 - CERTAIN))
        return cls(math.sqrt(together / days), math.sqrt(rest / FREEDOM / days),
                   together > by_chance * rest)

    def due_days(self, limit: float, now: float) -> tuple[float, float, float]:
        """Earliest, estimate and latest day on which the limit is passed at this pace."""
        paces = self.per_day + self.sd, self.per_day, self.per_day - self.sd
        early, due, late = (math.sqrt(max(limit**2 - now**2, 0.0)) / pace if pace > 0 else math.inf
                            for pace in paces)
        return early, due, late


_NAMES = [f"{name} {axis}" for name in ("bias", "scale", "misalignment") for axis in AXES]


def _change(before: TriadParameters, after: TriadParameters) -> FloatArray:
    """Change (9,) from one session to the next: biases in SI, scales relative, misalignments."""
    scale = after.scale_counts_per_unit
    return np.concatenate([(after.bias_counts - before.bias_counts) / scale,
                           np.log(scale / before.scale_counts_per_unit),
                           after.misalignment_rad - before.misalignment_rad])


def _sd(triad: StoredTriad) -> FloatArray:
    """Sds (9,) of the parameters of one session, by errors that sessions do not share."""
    noise, scale = triad.section.sd_parts["noise"], triad.parameters.scale_counts_per_unit
    bias, gain, angle = (np.array(part, float) for part in (
        noise.bias_counts, noise.scale_counts_per_unit, noise.misalignment_rad))
    return np.asarray(np.nan_to_num(np.concatenate([bias / scale, gain / scale, angle])))


def _size(section: TriadSection) -> float:
    """The typical magnitude that was measured, SI."""
    return float(np.median([abs(pose.reference) for pose in section.poses
                            if pose.reference] or [0.0]))


def _squared(change: FloatArray, size: float) -> float:
    """D² of a change (9,) of the parameters."""
    bias, scale, angle = change.reshape(3, 3)
    return float(bias @ bias / 3 + size**2 / 15 * (
        2 * scale @ scale + scale.sum() ** 2 + angle @ angle))


def _expected(variance: FloatArray, size: float) -> float:
    """Mean of D² if the parameters differ by noise of these variances (9,) alone."""
    bias, scale, angle = variance.reshape(3, 3).sum(axis=1)
    return float(bias / 3 + size**2 / 15 * (3 * scale + angle))


def _variance(whole: float, noise: float, freedom: float, tail: float) -> float:
    """Change of sessions beyond the noise if ``whole`` is as small as in ``tail`` of cases."""
    return max(whole * freedom / float(chdtri(freedom, 1 - tail)) - noise, 0.0)


def _due(limit: float, now: float, per_day: float) -> float:
    if limit <= now:
        return 0.0
    return (limit**2 - now**2) / per_day if per_day > 0 else math.inf
