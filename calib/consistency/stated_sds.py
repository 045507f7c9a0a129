"""Sds of a table of means that are plainly larger than what the poses scatter.

What samples show of a pose may well be more than its mean scatters by, by chance or because the
converter's steps and slow noise are in it at their largest: there is nothing to mend.
"""

from collections.abc import Iterator
from math import sqrt

from calib.fit.least_squares.result import Fit
from calib.fit.least_squares.unknown_sd import tests_the_model

ONE_SESSION_OF = 2000
"""Sessions with right sds of which one is warned of. Derived: both triads together then take a
fifth of the one in 200 that all warnings may take."""

PLAINLY = 1.5
"""Ratio of stated sds to right ones. A judgement: sds that hold steps of a converter and slow noise
at their largest are up to 1.3 times too large in sound sessions, and nobody need do anything."""


def sds_too_large(fit: Fit) -> Iterator[str]:
    """Warn, once at most, where residuals are so small that the sds of the poses are not right."""
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
