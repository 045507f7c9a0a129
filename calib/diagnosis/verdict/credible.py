"""Whether what a refit makes of effects can be: whether it leaves rows over."""

from calib.diagnosis.search.refit import Refit
from calib.fit.least_squares.result import Fit


def is_credible(joint: Refit, base: Fit) -> bool:
    """Whether the effects that ``joint`` adds to ``base`` leave a fifth of the degrees of freedom.

    Two of the nine of 18 poses, beside the seven combinations of ``cross_quadratic`` that they
    show.
    """
    return 5 * joint.fit.dof >= base.dof
