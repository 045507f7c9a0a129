"""Simulated logs of a sensor turned in the hand, and how many of their rests the search finds."""

import numpy as np

from calib.errors import Undetermined
from calib.poses.data_sheet import TriadSpec
from calib.poses.imu_log import ImuLog
from calib.poses.rests.static_intervals import find_still
from tests.world.hand_turned import HandTurned, Stop, by_hand, on_gimbal, turn_through

SI = TriadSpec(np.inf, 0, "si")
KINDS = ("hand", "hand, 20 Hz", "strong tremor", "noisy sensor", "table, then hand", "gimbal",
         "table, then gimbal", "stops of 0.6 s")


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
                     for each in find_still(blank, {"accelerometer": SI, "gyroscope": SI}).logs]
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
