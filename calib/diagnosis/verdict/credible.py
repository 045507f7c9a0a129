"""Whether what a refit makes of effects can be: rows left over, and sizes of this world."""

import numpy as np

from calib.diagnosis.search.refit import Refit
from calib.effects.effect import Effect
from calib.fit.least_squares.result import Fit
from calib.poses.imu_log import Triad

LARGEST = 1e8
"""Times the largest size that the catalogue quotes for any class of parts. Derived: 300 sds of a
pose's mean are up to 6·10⁶ times a quoted size where the poses hardly vary in what the effect
follows; of poses at another range such an effect makes 10¹¹ times."""


def is_credible(joint: Refit, base: Fit) -> bool:
    """Whether the effects that ``joint`` adds to ``base`` have possible sizes, with rows left over.

    A fifth of the degrees of freedom must be left: two of the nine of 18 poses, beside the seven
    combinations of ``cross_quadratic`` that they show. An effect for which no size is quoted may
    have any.
    """
    where = joint.fit.model.slices()
    return 5 * joint.fit.dof >= base.dof and all(
        np.abs(joint.fit.theta[where[effect.name]]).max()
        <= LARGEST * largest_quoted(effect, base.poses.triad)
        for effect in joint.fit.model.effects if effect.name in joint.names
    )


def largest_quoted(effect: Effect, triad: Triad) -> float:
    """The largest size of a parameter that the catalogue quotes, SI; infinite where it has none."""
    sizes = (each.si_for(triad) for each in effect.page.typical.values())
    return max((size for size in sizes if size is not None), default=np.inf)
