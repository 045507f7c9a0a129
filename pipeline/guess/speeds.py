"""Speeds of the plate in logs and between them, by their gyroscopes."""

import math
from collections import Counter
from collections.abc import Sequence

import numpy as np

from pipeline.guess.pool import (
    FEWEST_MEANS,
    REST_S,
    are_still,
    block_rows,
    common_mean,
    stops_of,
    usual_step,
)
from pipeline.guess.table_guess import TURNING_RAD_S, TableGuess, joined_log
from pipeline.guess.units import SHORTEST_LOG_S

NEAR_CLIP = math.log(1.15)
"""Largest log ratio of the gyroscope's rate to a clip's: its gain may be 10 % off. Also that of the
rates of two tables of one speed."""


def speeds_of(rates_rad_s: Sequence[float]) -> list[float]:
    """The speed of each table, rad/s: the median of all tables with about its rate; 0 at rest.

    A bias changes the measured rate from attitude to attitude.
    """
    rates, speeds = np.array(rates_rad_s), np.zeros(len(rates_rad_s))
    turning = np.flatnonzero(rates > 0)
    order = turning[np.argsort(rates[turning])]
    apart = np.flatnonzero(np.diff(np.log(rates[order])) > NEAR_CLIP) + 1
    for group in np.split(order, apart)[: len(order)]:
        speeds[group] = np.median(rates[group])
    return [*map(float, speeds)]


def speeds_in(force: TableGuess, rate: TableGuess) -> list[tuple[float, bool]]:
    """Rest (0) and the speeds, rad/s, at which a log of many poses is steady, each with whether it
    turns clockwise by gravity; empty if it only rests, or has no gyroscope."""
    log = joined_log(force, rate) if force.accelerometer else rate.log()
    if log is None or len(log.time_s) < 2:
        return []
    size = max(1, round(REST_S / usual_step(log.time_s)))
    rows, _ = block_rows(np.zeros(len(log.time_s), np.int64), size)
    at = np.flatnonzero(are_still(log.gyroscope[rows])) if len(rows) else rows[:, 0]
    if len(at) < FEWEST_MEANS:
        return []
    mean, up = (np.nan_to_num(values)[rows[at]].mean(axis=1)
                for values in (log.gyroscope, log.accelerometer))
    stops = stops_of(at, mean, up)
    bias = common_mean(np.array([mean[stop].mean(axis=0) for stop in stops]))
    mean = mean if bias is None else mean - bias
    length = np.linalg.norm(mean, axis=1)
    speed = np.array(speeds_of([*np.where(length > TURNING_RAD_S, length, 0.0)]))
    clockwise = (speed > 0) & ((mean * up).sum(axis=1) < 0)
    blocks: Counter[tuple[float, bool]] = Counter()
    for run in np.split(np.arange(len(at)), 1 + np.flatnonzero(
            (np.diff(at) > 1) | (np.diff(speed) != 0))):
        turns = len(run) * REST_S * speed[run[0]] / (2 * math.pi)
        if not speed[run[0]] or turns >= 1:  # a hand turns it no whole turn
            blocks.update(zip(speed[run].tolist(), clockwise[run].tolist(), strict=True))
    able = [way for way, count in blocks.items() if count * REST_S >= SHORTEST_LOG_S]
    return able if len(able) > 1 or (able and able[0][0]) else []
