"""Columns computed from the past of others: a lag, a play, a total.

    lag     τ dy/dt = x - y, y in balance at the first row: a body of one heat capacity
    play    y rests until x has crossed a gap of ± its half width: backlash, dry friction
    total   ∫ x dt since the first row: what was drawn or taken up so far

with x a straight line between the rows, in the order of time.
"""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from calib.poses.imu_log import FloatArray, IntArray
from calib.poses.pose_set import PoseSet

PAST = "past:"  #: prefix of the name of such a column


@dataclass(frozen=True)
class Past:
    """A column computed from the past of others.

    Attributes
    ----------
    name : str
        What the column is called, beginning with ``PAST``.
    logged : tuple of str
        The columns that it is made of.
    values : callable
        From the columns (n,) by name and the times (n,), s, to its values (n,).
    """

    name: str
    logged: tuple[str, ...]
    values: Callable[[Mapping[str, FloatArray], FloatArray], FloatArray] = field(compare=False)


def past_columns(
    columns: Mapping[str, FloatArray], time_s: FloatArray, pasts: Iterable[Past]
) -> dict[str, FloatArray]:
    """The columns that ``pasts`` compute from ``columns`` (n,), as far as these are available."""
    return {past.name: past.values(columns, time_s)
            for past in pasts if {*past.logged} <= columns.keys()}


def with_pasts(poses: PoseSet, pasts: Iterable[Past]) -> PoseSet:
    """``poses`` with the columns computed from their past; unchanged if there are none."""
    more = past_columns(poses.columns, poses.time_s, pasts)
    return replace(poses, columns={**poses.columns, **more}) if more else poses


def behind(values: FloatArray, time_s: FloatArray, tau_s: float) -> FloatArray:
    """Lag of ``values`` (n,) at the times (n,) with a time constant, s, (n,).

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
    return _back(states, order)


def across_gap(values: FloatArray, time_s: FloatArray, half_width: float) -> FloatArray:
    """Play: ``values`` (n,) at the times (n,), s, followed across a gap, (n,).

    It is in the middle of the gap at the first row. NaN throughout where a time is not known.
    """
    if not np.isfinite(time_s).all():
        return np.full(len(values), np.nan)
    order = np.argsort(time_s, kind="stable")
    state, states = float(values[order[0]]), []
    for value in values[order].tolist():
        state = min(max(state, value - half_width), value + half_width)
        states.append(state)
    return _back(states, order)


def total(values: FloatArray, time_s: FloatArray) -> FloatArray:
    """The integral of ``values`` (n,) over the times (n,), s, since the first, (n,).

    NaN throughout where a time is not known.
    """
    if not np.isfinite(time_s).all():
        return np.full(len(values), np.nan)
    order = np.argsort(time_s, kind="stable")
    flow = values[order]
    parts = 0.5 * np.diff(time_s[order]) * (flow[1:] + flow[:-1])
    return _back(np.concatenate([[0.0], np.cumsum(parts)]), order)


def _back(course: FloatArray | list[float], order: IntArray) -> FloatArray:
    """Reorder a course from the order of time to that of the rows."""
    result = np.empty(len(order))
    result[order] = course
    return result
