"""What a refit takes of a misfit."""

from calib.diagnosis.search.posterior import Posterior
from calib.diagnosis.search.refit import Refit
from calib.fit.least_squares.result import Fit


def explained(posterior: Posterior, joint: Refit | None) -> tuple[float, bool]:
    """Part of the misfit that a refit takes, and whether noise explains the rest.

    Of noise that is not known, part of the whole residual.
    """
    base = posterior.base
    whole = _square(base) - base.dof
    if joint is not None and not posterior.table.noise.is_known:
        return 1 - joint.fit.chi2 / base.chi2, joint.explains
    if joint is None or whole <= 0:
        return 0.0, False
    return max(1 - max(_square(joint.fit) - joint.fit.dof, 0.0) / whole, 0.0), joint.explains


def _square(fit: Fit) -> float:
    """Chi-square with the rows weighted as a robust loss has them."""
    return float(fit.weight @ fit.rows.residual**2)
