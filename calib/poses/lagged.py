"""A logged column behind itself: what a body does that follows it with a time constant.

    τ dy/dt = x - y

with x a straight line between the rows, in the order of time, and y in balance at the first.
"""

from collections.abc import Iterable, Mapping
from dataclasses import replace

import numpy as np

from calib.poses.imu_log import FloatArray
from calib.poses.pose_set import PoseSet

Lag = tuple[str, float]
"""A logged column and a time constant, s."""

LAG = "lag:"  #: before the name of such a column


def lag_name(column: str, tau_s: float) -> str:
    """The name of a column that follows ``column`` with the time constant ``tau_s``."""
    return f"{LAG}{column}:{tau_s:g}"


def behind(values: FloatArray, time_s: FloatArray, tau_s: float) -> FloatArray:
    """What follows ``values`` (n,) of the times (n,) with a time constant, s, (n,).

    NaN throughout where a time is not known.
    """
    if not np.isfinite(time_s).all():
        return np.full(len(values), np.nan)
    order = np.argsort(time_s, kind="stable")
    driven, step = values[order], np.diff(time_s[order])
    slope = np.divide(np.diff(driven), step, out=np.zeros(len(step)), where=step > 0)
    kept = np.exp(-step / tau_s)
    # y = x - τ slope + (y₀ - x₀ + τ slope) exp(-step / τ)
    gained = np.where(step > 0, driven[1:] - kept * driven[:-1] - (1 - kept) * tau_s * slope, 0.0)
    state, states = float(driven[0]), [float(driven[0])]
    for part, more in zip(kept.tolist(), gained.tolist(), strict=True):
        state = part * state + more
        states.append(state)
    result = np.empty(len(values))
    result[order] = states
    return result


def lagged_columns(
    columns: Mapping[str, FloatArray], time_s: FloatArray, lags: Iterable[Lag]
) -> dict[str, FloatArray]:
    """The columns that follow those of ``columns`` (n,), of the lags whose column is there."""
    return {lag_name(name, tau_s): behind(columns[name], time_s, tau_s)
            for name, tau_s in lags if name in columns}


def with_lags(poses: PoseSet, lags: Iterable[Lag]) -> PoseSet:
    """``poses`` with the columns that follow theirs; the same where there is no lag."""
    more = lagged_columns(poses.columns, poses.time_s, lags)
    return replace(poses, columns={**poses.columns, **more}) if more else poses
