"""Steps: changes that happen once and stay."""

import numpy as np

from calib.effects.effect import Page, Shape, ShapeValue, effect, per_axis
from calib.effects.typical import between, typical
from calib.poses.conditions import Conditions
from calib.poses.imu_log import AXES, FloatArray

STEP_MARGIN = 2
"""Least number of poses on either side of a step. Derived: a single one is a bad pose."""

APART = 0.6
"""Share of the times by which further starts are shifted. Numerical: two at one time are one."""


def _times_between(at: Conditions) -> tuple[float, ...]:
    """Middles between poses adjacent in time, except at the ends, the middle one first.

    The visibility of a step in a fit is judged at the first.
    """
    times = np.unique(at.time_s)
    middles = 0.5 * (times[:-1] + times[1:])
    inner = middles[STEP_MARGIN - 1 : len(middles) - STEP_MARGIN + 1]
    if not np.isfinite(times).all():
        return ()
    inner = inner[inner > 0]
    return tuple(map(float, inner[np.argsort(np.abs(inner - times.mean()), kind="stable")]))


def times_from_elsewhere(number: int, at: Conditions) -> tuple[float, ...]:
    """Start times of a further step, shifted from those of the steps before it."""
    times = _times_between(at)
    first = int(len(times) * ((number - 1) * APART % 1.0))
    return (*times[first:], *times[:first])


@effect(
    *AXES,
    unit="{u}",
    needs=("time",),
    constant_is="bias",
    belongs_to="session",
    shape=Shape("at_s", "s", (1.0,), (1e-3, 1e6), is_fitted=False),
    starts_in=_times_between,
    page=Page(
        formula="e_k = j_k from the time at_s on,  at_s fitted",
        expressions=("(1 + sign(time_s - at_s)) / 2",),
        typical={"MPU-6050": typical(between(0.02, 0.2, "°/s"), between(1, 10, "mg")),
                 "MTi": typical(between(0.1, 1, "mg"))},
        source="mounting that slips, a supply that switches, stress that lets go",
        confounded="bias_drift and warm_up, where it is in the middle of the session",
        separates="poses of before the step repeated after it",
    ),
)
def bias_step(at: Conditions, at_s: ShapeValue) -> FloatArray:
    """Bias that steps once and stays; bias_step_2 and so on are further steps."""
    after = 0.5 * (1 + np.sign(at.time_s[:, None] - at_s))
    return per_axis(after * np.ones_like(at.vector))
