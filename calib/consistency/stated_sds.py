"""Sds of a table of means that are clearly larger than the scatter of the poses.

The sd that the samples of a pose give may well exceed the scatter of its mean, by chance or because
it contains the converter's steps and slow noise at their largest: nothing needs mending.
"""

from collections.abc import Iterator
from math import sqrt

from calib.fit.least_squares.result import Fit
from calib.fit.least_squares.unknown_sd import tests_the_model

ONE_SESSION_OF = 2000
"""One in this many sessions with right sds causes a warning. Derived: both triads together then
take a fifth of the one in 200 that all warnings may take."""

PLAINLY = 1.5
"""Ratio of stated sds to right ones. A judgement: sds that contain a converter's steps and slow
noise at their largest are up to 1.3 times too large in sound sessions, and need no action."""


def sds_too_large(fit: Fit) -> Iterator[str]:
    """Warn, once at most, where residuals are too small for the sds of the poses to be right."""
    if not tests_the_model(fit.poses) or fit.dof < 1 or fit.p_value <= 1 - 1 / ONE_SESSION_OF:
        return
    ratio = fit.chi2 / fit.dof
    if PLAINLY**2 * ratio > 1:
        return
    yield (
        f"the sds of the {fit.poses.triad}'s poses are about {1 / sqrt(ratio):.2g} times too "
        f"large: chi²/dof is {ratio:.2g} with {fit.dof} degrees of freedom, and right sds give so "
        f"little in fewer than one session of {ONE_SESSION_OF}. The stated sds of the "
        f"parameters are too large with them, and an error of that size goes unseen. Are "
        f"they those of single samples? Those of the means belong here."
    )
