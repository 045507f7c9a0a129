"""The search in all triads of a session: triads of one chip follow its temperature alike."""

from collections.abc import Sequence

from calib.discovery.discover import Discovered, discover
from calib.fit.least_squares.result import Fit


def discover_each(
    fits: Sequence[Fit], covariates: Sequence[str] | None = None
) -> list[Discovered | None]:
    """The likeliest formula of each triad, by :func:`calib.discovery.discover.discover`.

    Where the poses of a triad show no formula, or do not tell several apart, its search is repeated
    with the functions that the others follow.

    Raises
    ------
    Undetermined
        A Python function of a model raised.
    """
    formulas = [discover(fit, covariates) for fit in fits]
    for i, (fit, one) in enumerate(zip(fits, formulas, strict=True)):
        known = [other.formula.function for j, other in enumerate(formulas)
                 if j != i and other is not None and other.listed is None]
        if known and (one is None or one.alike):
            formulas[i] = discover(fit, covariates, known)
    return formulas
