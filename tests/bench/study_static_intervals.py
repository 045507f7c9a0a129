"""What the search for static intervals finds in simulated hand-turned logs, and by which constants.

    python -m tests.bench.study_static_intervals [SEEDS]

For each kind of log: rests found of those there, and found stretches that are mostly movement. Then
the same, all kinds together, with each constant halved and doubled.
"""

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from types import ModuleType

import numpy as np

from calib.errors import Undetermined
from calib.poses import attitude_fit, rest_candidates, static_intervals
from calib.poses.data_sheet import TriadSpec
from calib.poses.imu_log import ImuLog
from calib.poses.static_intervals import find_still
from tests.world.hand_turned import HandTurned, Stop, by_hand, on_gimbal, turn_through

SI = TriadSpec(np.inf, 0, "si")
KINDS = ("hand", "hand, 20 Hz", "strong tremor", "noisy sensor", "table, then hand", "gimbal",
         "table, then gimbal", "stops of 0.6 s")
CONSTANTS: tuple[tuple[ModuleType, str], ...] = (
    (rest_candidates, "WINDOW_S"),
    (rest_candidates, "QUIETEST_SHARE"),
    (rest_candidates, "LARGEST_TURN"),
    (rest_candidates, "MARGIN_SHARE"),
    (rest_candidates, "SAME_ATTITUDE"),
    (rest_candidates, "WANDER_S"),
    (rest_candidates, "NOISE_OF_RANGE"),
    (static_intervals, "STILL_RATIO"),
    (static_intervals, "THRESHOLD_STEP"),
    (attitude_fit, "ALIKE"),
    (attitude_fit, "WORTHLESS"),
)


def made(kind: str, seed: int) -> HandTurned:
    """One simulated log."""
    if kind == "hand, 20 Hz":
        return turn_through(by_hand(seed), seed, rate_hz=20.0)
    if kind == "strong tremor":
        return turn_through(by_hand(seed, tremor_m_s2=0.1), seed)
    if kind == "noisy sensor":
        return turn_through(by_hand(seed), seed, noise_m_s2=0.05)
    if kind == "table, then hand":
        stops = [Stop(120.0), *by_hand(seed, tremor_m_s2=0.08)]
        return turn_through(stops, seed, noise_m_s2=0.005)
    if kind == "gimbal":
        return turn_through(on_gimbal(), seed, noise_m_s2=0.005)
    if kind == "table, then gimbal":
        return turn_through([Stop(600.0), *on_gimbal()], seed, noise_m_s2=0.005)
    if kind == "stops of 0.6 s":
        return turn_through([Stop(0.6, 0.02)] * 30, seed)
    return turn_through(by_hand(seed), seed)


def count(log: HandTurned) -> tuple[int, int, int]:
    """Rests found, rests there, found stretches that are mostly movement."""
    blank = ImuLog("log", log.time_s, log.force_m_s2, log.rate_rad_s)
    try:
        stretches = [(float(each.time_s[0]), float(each.time_s[-1]))
                     for each in find_still(blank, SI, SI).logs]
    except Undetermined:
        stretches = []
    held, wrong = set(), 0
    for start, stop in stretches:
        shared = [min(stop, end) - max(start, begin) for begin, end in log.rests]
        best = int(np.argmax(shared))
        if shared[best] > 0.8 * (stop - start):
            held.add(best)
        else:
            wrong += 1
    return len(held), len(log.rests), wrong


@contextmanager
def changed(module: ModuleType, name: str, factor: float) -> Iterator[None]:
    """A constant of a module multiplied for a while."""
    before = getattr(module, name)
    setattr(module, name, before * factor)
    try:
        yield
    finally:
        setattr(module, name, before)


def main(seeds: int = 10) -> None:
    """Print both tables."""
    logs = {kind: [made(kind, seed) for seed in range(seeds)] for kind in KINDS}

    def line(title: str, kinds: tuple[str, ...]) -> None:
        counts = np.array([count(log) for kind in kinds for log in logs[kind]]).sum(axis=0)
        print(f"{title:<34} {counts[0]:5d} of {counts[1]:5d} rests, {counts[2]:3d} wrong")

    for kind in KINDS:
        line(kind, (kind,))
    line("all", KINDS)
    for module, name in CONSTANTS:
        for factor in (0.5, 2.0):
            if name == "THRESHOLD_STEP" and factor == 0.5:
                continue  # no steps at all
            with changed(module, name, factor):
                line(f"{name} x {factor:g}", KINDS)
    for factor in (0.5, 2.0):
        largest = {key: factor * swing for key, swing in rest_candidates.LARGEST_SWING.items()}
        before = dict(rest_candidates.LARGEST_SWING)
        rest_candidates.LARGEST_SWING.update(largest)
        line(f"LARGEST_SWING x {factor:g}", KINDS)
        rest_candidates.LARGEST_SWING.update(before)


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
