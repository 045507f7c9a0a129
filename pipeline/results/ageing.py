"""When to calibrate again: changes between the sessions of a sensor, and their rate.

From one session to the next the parameters differ by their noise and by changes of the sensor. Both
cause an error of the corrected magnitude m, over all directions of

    D² = |δb|²/3 + m² (2 Σ δs_i² + (Σ δs_i)² + |δα|²) / 15

with δb the change of the biases (SI), δs of the scales (relative), δα of the misalignments (rad).
D² beyond the noise grows like a random walk, in proportion to time: q = Σ (D² - N²) / Σ t over
consecutive sessions. The expected error then passes a limit L at (L² - now²) / q.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import datetime
from itertools import pairwise
from operator import itemgetter

import numpy as np
from scipy.special import chdtri

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
    if len({tuple(one.section.model) for _, one in sessions}) != 1:
        return None
    excess, days, pairs, noise2, most = 0.0, 0.0, 0, 0.0, (0.0, "")
    for (begin_s, before), (end_s, after) in pairwise(sessions):
        apart = (end_s - begin_s) / DAY_S
        if apart < LEAST_DAYS:
            continue
        change, size = _change(before.parameters, after.parameters), _size(after.section)
        variance = _sd(before) ** 2 + _sd(after) ** 2
        noise = _expected(variance, size)
        excess += _squared(change, size) - noise
        noise2, days, pairs = noise2 + noise, days + apart, pairs + 1
        with np.errstate(divide="ignore", invalid="ignore"):
            sds = np.nan_to_num(np.abs(change) / np.sqrt(variance))
        most = max(most, (float(sds.max()), _NAMES[int(sds.argmax())]))
    prediction = sessions[-1][1].section.prediction
    if not pairs or prediction is None or prediction.sd_median is None:
        return None
    now = prediction.sd_median
    limit = TWICE * now if limit is None else limit
    freedom = FREEDOM * pairs
    due = [_due(limit, now, q / days) for q in (
        _variance(excess + noise2, noise2, freedom, ONE_SD), excess,
        _variance(excess + noise2, noise2, freedom, 1 - ONE_SD))]
    if excess <= 0 or (excess + noise2) / noise2 * freedom < chdtri(freedom, CERTAIN):
        most = (0.0, "")
        excess = 0.0
        upper = _variance(noise2, noise2, freedom, CERTAIN)
        due = [_due(limit, now, upper / days), math.inf, math.inf]
    return Ageing(days, math.sqrt(max(excess, 0.0) / pairs), math.sqrt(noise2 / pairs), most[1],
                  now, limit, (due[0], due[1], due[2]))


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
