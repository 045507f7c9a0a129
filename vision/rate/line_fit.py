"""The rate's own fit: the line, and what is always fitted together with it."""

from dataclasses import replace

import numpy as np

from vision.phase_track import PhaseTrack, PlateAngle
from vision.rate.least_squares import LeastSquares, independent, least_squares
from vision.rate.terms import FORWARD_PREDICTION, Regressors, design, regressors

ALWAYS = ("once_per_rev", "twice_per_rev", FORWARD_PREDICTION)


def fit_rate(
    track: PhaseTrack, angle: PlateAngle, rate_rad_s: float, *, with_drift: bool
) -> tuple[LeastSquares, Regressors, tuple[str, ...]]:
    """The rate's own fit; twice, because the waves are placed by the line it finds."""
    for _ in range(2):
        given = regressors(track, angle, rate_rad_s)
        always: tuple[str, ...] = ()
        for term in ALWAYS:
            # A fast plate has few pictures per turn, and the waves may look alike on them.
            x = design((*always, term), given, given.time_s)
            if independent(x).shape[1] == x.shape[1]:
                always = (*always, term)
        fit, always = _fit(always, ("rate_drift",) if with_drift else (), given, angle)
        rate_rad_s = float(fit.beta[1])
    return fit, given, always


def _fit(
    always: tuple[str, ...], besides: tuple[str, ...], given: Regressors, angle: PlateAngle
) -> tuple[LeastSquares, tuple[str, ...]]:
    """The fit, and the terms of ``always`` that it can tell on the pictures not set aside."""
    x = design((*always, *besides), given, given.time_s)
    try:
        return least_squares(x, angle.angle_rad, turn_rad=given.line_rad), always
    except np.linalg.LinAlgError:
        if not always:
            raise
        return _fit(always[:-1], besides, given, angle)


def without_lag(
    angle: PlateAngle, fit: LeastSquares, given: Regressors, always: tuple[str, ...]
) -> PlateAngle:
    """The angle as if every picture were coded alike."""
    if FORWARD_PREDICTION not in always:
        return angle
    before = design(always[: always.index(FORWARD_PREDICTION)], given, given.time_s)
    lag = float(fit.beta[before.shape[1]])
    return replace(angle, angle_rad=angle.angle_rad - lag * given.forward)
