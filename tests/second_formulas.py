"""A second list of twenty formulas, written down before the grammar learned products and lags.

They are what a sensor's surroundings do to it as a data sheet or a physicist would tell it, not
what the grammar can build: some have three quantities, some no term that it knows. Half of them,
by a draw, are looked at while the grammar is made; the other half is run once, when it is finished.
A formula is as in :mod:`tests.hidden_formulas`.
"""

from collections.abc import Mapping

import numpy as np

from calib.poses.imu_log import FloatArray
from calib.poses.pose_set import PoseSet
from tests.hidden_formulas import Formula

SPLIT_SEED = 29  #: of the draw; chosen before anything was run


def _about(poses: PoseSet, name: str, centre: float) -> FloatArray:
    return poses.columns[name][:, None] - centre


def _warmth(poses: PoseSet) -> FloatArray:
    return _about(poses, "temperature_c", 30)


def _supply(poses: PoseSet) -> FloatArray:
    return _about(poses, "supply_v", 5)


def _humidity(poses: PoseSet) -> FloatArray:
    return _about(poses, "humidity_pct", 45)


def _power(poses: PoseSet) -> FloatArray:
    return _about(poses, "tx_power_w", 0)


def behind(poses: PoseSet, drive: FloatArray, tau_s: float) -> FloatArray:
    """What a body of one heat capacity does behind ``drive`` (n, 1), step by step, (n, 1).

    The drive is a straight line between poses; the body is in balance at the first.
    """
    order = np.argsort(poses.time_s)
    time, driven = poses.time_s[order], drive[order, 0]
    state = [driven[0]]
    for start, end, a, b in zip(time, time[1:], driven, driven[1:], strict=False):
        steps = 400
        body, step = state[-1], (end - start) / steps
        for k in range(steps):
            body += step / tau_s * (a + (b - a) * (k + 0.5) / steps - body)
        state.append(body)
    behind = np.empty(len(poses))
    behind[order] = state
    return behind[:, None]


def _slope(poses: PoseSet, values: FloatArray) -> FloatArray:
    """Change of ``values`` (n, 1) since the pose before, per second, (n, 1)."""
    order = np.argsort(poses.time_s)
    slope = np.zeros_like(values)
    slope[order[1:]] = np.diff(values[order], axis=0) / np.diff(poses.time_s[order])[:, None]
    return slope


def _before(poses: PoseSet, true: FloatArray) -> FloatArray:
    order = np.argsort(poses.time_s)
    before = np.zeros_like(true)
    before[order[1:]] = true[order[:-1]]
    return before


def _others(true: FloatArray) -> FloatArray:
    """For each axis the product of the other two, (n, 3)."""
    return np.roll(true, 1, axis=1) * np.roll(true, 2, axis=1)


EVERY: Mapping[str, Formula] = {
    "bias ~ power, 200 s behind": lambda p, s: behind(p, _power(p), 200),
    "bias ~ warmth · power": lambda p, s: _warmth(p) * _power(p),
    "bias ~ supply · humidity": lambda p, s: _supply(p) * _humidity(p),
    "cross gain ~ warmth": lambda p, s: _warmth(p) * np.roll(s, 1, axis=1),
    "s_i s_j ~ power": lambda p, s: _power(p) * _others(s),
    "gain ~ warmth · supply": lambda p, s: _warmth(p) * _supply(p) * s,
    "gain ~ power, 150 s behind": lambda p, s: behind(p, _power(p), 150) * s,
    "bias ~ slope of the temperature": lambda p, s: _slope(p, _warmth(p)),
    "bias ~ 1 / (power + 0.2)": lambda p, s: 1 / (_power(p) + 0.2),
    "bias ~ ripple in the supply": lambda p, s: np.sin(2 * np.pi * _supply(p) / 0.4),
    "|s| ~ warmth": lambda p, s: _warmth(p) * np.abs(s),
    "s² ~ supply": lambda p, s: _supply(p) * s**2,
    "memory ~ power": lambda p, s: _power(p) * _before(p, s),
    "bias ~ warmth over 34 °C": lambda p, s: np.maximum(_warmth(p) - 4, 0),
    "bias ~ humidity where the supply is low": lambda p, s: _humidity(p) * (_supply(p) < -0.1),
    "bias ~ bump in humidity": lambda p, s: np.exp(-((_humidity(p) / 4) ** 2)),
    "gain ~ power over 1.2 W": lambda p, s: (_power(p) > 1.2) * s,
    "bias ~ square of the supply, 100 s behind": lambda p, s: (
        behind(p, (_supply(p) + 5) ** 2, 100)),
    "s³ ~ warmth": lambda p, s: _warmth(p) * s**3,
    "bias ~ heat of power over 1.5 W": lambda p, s: behind(p, 1.0 * (_power(p) > 1.5), 150),
}

_DRAWN = np.random.default_rng(SPLIT_SEED).permutation(len(EVERY))

SEEN: Mapping[str, Formula] = {list(EVERY)[i]: list(EVERY.values())[i] for i in _DRAWN[:10]}
UNSEEN: Mapping[str, Formula] = {list(EVERY)[i]: list(EVERY.values())[i] for i in _DRAWN[10:]}
