"""A third list of twenty formulas, written down before the grammar learned waves, bumps and play.

They are what a bench does to a sensor: a fan that resonates, a plate whose angle counts, a relay
behind a warm case, iron that remembers. Half of them, by a draw, are looked at while the grammar is
made; the other half is run once, when it is finished. A formula is as in
:mod:`tests.hidden_formulas`, in poses with three more logged columns.
"""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from calib.poses.imu_log import FloatArray
from calib.poses.pose_set import PoseSet
from tests.hidden_formulas import Formula
from tests.second_formulas import behind

SPLIT_SEED = 2929  #: of the draw; chosen before anything was run


def with_bench_columns(poses: PoseSet, seed: int) -> PoseSet:
    """``poses`` with the plate's angle, the phase of the mains and the speed of a fan."""
    random, n = np.random.default_rng([seed, 42]), len(poses)
    return replace(poses, columns={
        **poses.columns,
        "plate_angle_deg": random.uniform(0, 360, n),
        "mains_phase_deg": random.uniform(0, 360, n),
        "fan_hz": random.uniform(20, 60, n),
    })


def _column(poses: PoseSet, name: str) -> FloatArray:
    return poses.columns[name][:, None]


def _warmth(poses: PoseSet) -> FloatArray:
    return _column(poses, "temperature_c") - 30


def _supply(poses: PoseSet) -> FloatArray:
    return _column(poses, "supply_v") - 5


def _power(poses: PoseSet) -> FloatArray:
    return _column(poses, "tx_power_w")


def _fan(poses: PoseSet) -> FloatArray:
    return _column(poses, "fan_hz")


def _angle(poses: PoseSet) -> FloatArray:
    return np.radians(_column(poses, "plate_angle_deg"))


def _time(poses: PoseSet) -> FloatArray:
    return poses.time_s[:, None]


def _play(poses: PoseSet, drive: FloatArray, half_width: float) -> FloatArray:
    """What follows ``drive`` (n, 1) with play: it rests until the drive has crossed the gap."""
    order, state = np.argsort(poses.time_s), drive[np.argmin(poses.time_s), 0]
    followed = np.empty(len(poses))
    for i in order:
        state = min(max(state, drive[i, 0] - half_width), drive[i, 0] + half_width)
        followed[i] = state
    return followed[:, None]


def _rise(poses: PoseSet, values: FloatArray) -> FloatArray:
    """Sign of the change of ``values`` (n, 1) since the pose before, (n, 1)."""
    order = np.argsort(poses.time_s)
    rise = np.zeros_like(values)
    rise[order[1:]] = np.sign(np.diff(values[order], axis=0))
    return rise


def _sum_so_far(poses: PoseSet, flow: FloatArray) -> FloatArray:
    """The integral of ``flow`` (n, 1) since the first pose, pose by pose, (n, 1)."""
    order = np.argsort(poses.time_s)
    time, through = poses.time_s[order], flow[order, 0]
    total = np.empty(len(poses))
    total[order] = np.concatenate([[0.0], np.cumsum(np.diff(time) * (through[1:] + through[:-1]))])
    return total[:, None] / 2


EVERY: Mapping[str, Formula] = {
    "s³ ~ supply": lambda p, s: _supply(p) * s**3,
    "bias ~ relay behind the heat of power": lambda p, s: (
        1.0 * (behind(p, _power(p), 200) > 1.0)),
    "bias ~ resonance in the supply": lambda p, s: 1 / (1 + ((_supply(p) - 0.1) / 0.1) ** 2),
    "bias ~ resonance of the fan": lambda p, s: (
        1 / np.hypot(1 - (_fan(p) / 40) ** 2, _fan(p) / 40 / 8)),
    "bias ~ sine of the plate's angle": lambda p, s: np.sin(_angle(p) + 0.6),
    "bias ~ twice the mains": lambda p, s: (
        np.sin(2 * np.radians(_column(p, "mains_phase_deg")) + 1.1)),
    "gain ~ cosine of the plate's angle": lambda p, s: np.cos(_angle(p) - 0.4) * s,
    "bias ~ power, saturating": lambda p, s: _power(p) / (_power(p) + 0.4),
    "bias ~ warmth beyond ±4 K": lambda p, s: (
        np.sign(_warmth(p)) * np.maximum(np.abs(_warmth(p)) - 4, 0)),
    "bias ~ power / fan": lambda p, s: _power(p) / _fan(p),
    "bias ~ time · power": lambda p, s: _time(p) * _power(p),
    "bias ~ exp(-power / its own of each axis)": lambda p, s: (
        np.exp(-_power(p) / np.array([0.2, 0.5, 1.2]))),
    "gain ~ exp(-t / its own of each axis)": lambda p, s: (
        np.exp(-_time(p) / np.array([150.0, 500.0, 1500.0])) * s),
    "bias ~ temperature with play": lambda p, s: _play(p, _warmth(p), 4.0),
    "bias ~ direction of the temperature's change": lambda p, s: _rise(p, _warmth(p)),
    "force ~ power": lambda p, s: _power(p) * np.roll(p.force, 1, axis=1),
    "vibration² ~ supply": lambda p, s: _supply(p) * p.vibration**2,
    "gain ~ exp(warmth / 4 K)": lambda p, s: np.exp(_warmth(p) / 4) * s,
    "bias ~ energy so far": lambda p, s: _sum_so_far(p, _power(p)),
    "bias ~ case behind the die": lambda p, s: _warmth(p) - behind(p, _warmth(p), 300),
}

_DRAWN = np.random.default_rng(SPLIT_SEED).permutation(len(EVERY))

SEEN: Mapping[str, Formula] = {list(EVERY)[i]: list(EVERY.values())[i] for i in _DRAWN[:10]}
UNSEEN: Mapping[str, Formula] = {list(EVERY)[i]: list(EVERY.values())[i] for i in _DRAWN[10:]}
