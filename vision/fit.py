"""The rate's own fit: the line, and what is always fitted together with it."""

from dataclasses import replace

from vision.motion import PlateAngle
from vision.phase_track import PhaseTrack
from vision.regression import LeastSquares, independent, least_squares
from vision.terms import FORWARD_PREDICTION, Regressors, design, regressors

ALWAYS = ("once_per_rev", "twice_per_rev", FORWARD_PREDICTION)


def fit_rate(
    track: PhaseTrack, angle: PlateAngle, rate_rad_s: float, *, with_drift: bool
) -> tuple[LeastSquares, Regressors, tuple[str, ...]]:
    """The rate's own fit; twice, because the waves are placed by the line it finds."""
    for _ in range(2):
        given = regressors(track, angle, rate_rad_s)
        terms: tuple[str, ...] = ()
        for term in ALWAYS:
            # A fast plate has few pictures per turn, and the waves may look alike on them.
            x = design((*terms, term), given, given.time_s)
            if independent(x).shape[1] == x.shape[1]:
                terms = (*terms, term)
        always = terms
        if with_drift:
            terms = (*terms, "rate_drift")
        fit = least_squares(
            design(terms, given, given.time_s), angle.angle_rad, turn_rad=given.line_rad
        )
        rate_rad_s = float(fit.beta[1])
    return fit, given, always


def without_lag(
    angle: PlateAngle, fit: LeastSquares, given: Regressors, always: tuple[str, ...]
) -> PlateAngle:
    """The angle as if every picture were coded alike."""
    if FORWARD_PREDICTION not in always:
        return angle
    before = design(always[: always.index(FORWARD_PREDICTION)], given, given.time_s)
    lag = float(fit.beta[before.shape[1]])
    return replace(angle, angle_rad=angle.angle_rad - lag * given.forward)
