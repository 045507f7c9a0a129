"""Sixty errors that no catalogue has, in poses with the columns of any bench.

Of the reading itself, of the pose before, of time and of logged columns, in words as a data sheet
or a repair shop has them. A formula is as in :mod:`tests.hidden_formulas`; a covariate is taken
from -1 to 1 over the session; the first of two keys says what an error is a function of. Those of
``HELD_OUT`` chose nothing in the diagnosis.
"""

from collections.abc import Mapping

import numpy as np

from calib.poses.imu_log import FloatArray
from calib.poses.pose_set import PoseSet
from tests.hidden_formulas import Formula


def _of(poses: PoseSet, name: str) -> FloatArray:
    """A column, or the time, from -1 to 1, (n, 1)."""
    values = poses.time_s if name == "time_s" else poses.columns[name]
    return (2 * (values - values.min()) / np.ptp(values) - 1)[:, None]


def _time(poses: PoseSet) -> FloatArray:
    return (1 + _of(poses, "time_s")) / 2


def _warmth(poses: PoseSet) -> FloatArray:
    return _of(poses, "temperature_c")


def _humidity(poses: PoseSet) -> FloatArray:
    return _of(poses, "humidity_pct")


def _supply(poses: PoseSet) -> FloatArray:
    return _of(poses, "supply_v")


def _before(poses: PoseSet, true: FloatArray, steps: int = 1) -> FloatArray:
    order = np.argsort(poses.time_s)
    before = np.zeros_like(true)
    before[order[steps:]] = true[order[:-steps]]
    return before


def _next_axis(true: FloatArray) -> FloatArray:
    return np.roll(true, 1, axis=1)


SEEN: Mapping[tuple[str, str], Formula] = {
    ("attitude", "saturation"): lambda p, s: s - np.clip(s, -0.8, 0.8),
    ("attitude", "dead zone"): lambda p, s: np.clip(s, -0.15, 0.15),
    ("attitude", "|s|^1.5"): lambda p, s: np.abs(s) ** 1.5,
    ("attitude", "sin 2πs"): lambda p, s: np.sin(2 * np.pi * s),
    ("attitude", "s⁴"): lambda p, s: s**4,
    ("attitude", "s_i s_j²"): lambda p, s: s * _next_axis(s) ** 2,
    ("attitude", "s_x s_y s_z"): lambda p, s: s.prod(axis=1, keepdims=True),
    ("attitude", "sine of the azimuth"): lambda p, s: (
        np.sin(3 * np.arctan2(s[:, 1:2], s[:, :1]) + 0.7)),
    ("previous", "stick-slip"): lambda p, s: np.sign(s - _before(p, s)),
    ("previous", "two poses before"): lambda p, s: _before(p, s) + 0.6 * _before(p, s, 2),
    ("time_s", "√time"): lambda p, s: np.sqrt(_time(p)),
    ("time_s", "time²"): lambda p, s: _time(p) ** 2,
    ("time_s", "sin of time"): lambda p, s: np.sin(2 * np.pi * 1.3 * _time(p) + 0.4),
    ("time_s", "gain by √time"): lambda p, s: np.sqrt(_time(p)) * s,
    ("temperature_c", "|warmth|"): lambda p, s: np.abs(_warmth(p) - 0.2),
    ("temperature_c", "gain by warmth³"): lambda p, s: _warmth(p) ** 3 * s,
    ("humidity_pct", "humidity²"): lambda p, s: _humidity(p) ** 2,
    ("humidity_pct", "gain by humidity"): lambda p, s: _humidity(p) * s,
    ("supply_v", "ripple in the supply"): lambda p, s: np.sin(2 * np.pi * _supply(p)),
    ("supply_v", "brown-out"): lambda p, s: np.maximum(-_supply(p) - 0.3, 0),
    ("attitude", "steps of a converter"): lambda p, s: np.floor(4 * s) / 4 - s,
    ("attitude", "s⁵"): lambda p, s: s**5,
    ("attitude", "s_i |s_j|"): lambda p, s: s * np.abs(_next_axis(s)),
    ("attitude", "tanh of the next axis"): lambda p, s: np.tanh(4 * _next_axis(s)),
    ("previous", "backlash"): lambda p, s: np.tanh(3 * (s - _before(p, s))),
    ("previous", "memory of the next axis"): lambda p, s: _before(p, _next_axis(s)) ** 2,
    ("time_s", "relay"): lambda p, s: (np.sin(2 * np.pi * 2.5 * _time(p)) > 0).astype(float),
    ("time_s", "log of time"): lambda p, s: np.log(0.02 + _time(p)),
    ("time_s", "s² by time"): lambda p, s: _time(p) * s**2,
    ("temperature_c", "warmth over a knee"): lambda p, s: np.maximum(_warmth(p) - 0.3, 0),
    ("temperature_c", "s³ by warmth"): lambda p, s: _warmth(p) * s**3,
    ("humidity_pct", "gain by humidity²"): lambda p, s: _humidity(p) ** 2 * s,
    ("humidity_pct", "exp of humidity"): lambda p, s: np.exp(3 * _humidity(p)),
    ("supply_v", "supply by humidity"): lambda p, s: _supply(p) * _humidity(p),
    ("supply_v", "cross gain by supply"): lambda p, s: _supply(p) * _next_axis(s),
    ("attitude", "kink at half"): lambda p, s: np.maximum(s - 0.5, 0),
    ("attitude", "s_j² s_k"): lambda p, s: _next_axis(s) ** 2 * _next_axis(_next_axis(s)),
    ("attitude", "signed root"): lambda p, s: np.sign(s) * np.sqrt(np.abs(s)),
    ("attitude", "cube of the next axis"): lambda p, s: _next_axis(s) ** 3,
    ("previous", "memory times reading"): lambda p, s: _before(p, s) * s,
    ("previous", "size of the turn"): lambda p, s: np.abs(s - _before(p, s)),
    ("time_s", "fading swing"): lambda p, s: np.exp(-3 * _time(p)) * np.sin(9 * _time(p) + 0.3),
    ("time_s", "sawtooth"): lambda p, s: 3 * _time(p) % 1,
    ("time_s", "|s| by time²"): lambda p, s: _time(p) ** 2 * np.abs(s),
    ("temperature_c", "exp of warmth"): lambda p, s: np.exp(2 * _warmth(p)),
    ("temperature_c", "gain by |warmth|"): lambda p, s: np.abs(_warmth(p)) * s,
    ("temperature_c", "s² by warmth²"): lambda p, s: _warmth(p) ** 2 * s**2,
    ("humidity_pct", "humidity by time"): lambda p, s: _humidity(p) * _time(p),
    ("humidity_pct", "switch at a humidity"): lambda p, s: (_humidity(p) > 0.1).astype(float),
    ("supply_v", "saturation by supply"): lambda p, s: _supply(p) * np.clip(s, -0.4, 0.4),
}

HELD_OUT: Mapping[tuple[str, str], Formula] = {
    ("attitude", "|s_j|^1.5"): lambda p, s: np.abs(_next_axis(s)) ** 1.5,
    ("attitude", "s_i⁴ s_j"): lambda p, s: s**4 * _next_axis(s),
    ("previous", "cube of the pose before"): lambda p, s: _before(p, s) ** 3,
    ("previous", "square of the turn"): lambda p, s: (s - _before(p, s)) ** 2,
    ("time_s", "cross gain by √time"): lambda p, s: np.sqrt(_time(p)) * _next_axis(s),
    ("time_s", "change of state"): lambda p, s: 1 / (1 + np.exp(-12 * (_time(p) - 0.6))),
    ("temperature_c", "saturation by warmth"): lambda p, s: _warmth(p) * np.clip(s, -0.5, 0.5),
    ("temperature_c", "warmth by time"): lambda p, s: _warmth(p) * _time(p),
    ("humidity_pct", "|s| by humidity"): lambda p, s: _humidity(p) * np.abs(s),
    ("supply_v", "s² by supply²"): lambda p, s: _supply(p) ** 2 * s**2,
}
