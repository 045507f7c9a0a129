"""How far a statistic strays by chance alone, so that a test's bounds follow from its sample.

Sums of squares of n independent normal values of sd 1 follow chi-square with n degrees of freedom,
numbers of hits a binomial distribution. A bound is the value that honest noise passes beyond with
the probability ``chance``: 1 % for a statistic of many draws, 0.1 % where a test asks often.
"""

import numpy as np
from scipy.stats import binom, chi2


def spread_bounds(dof: int, chance: float = 0.01) -> tuple[float, float]:
    """Between which the root mean square of ``dof`` standard normal values lies.

    A standard deviation about the values' own mean has one degree of freedom less than values.

    Examples
    --------
    >>> low, high = spread_bounds(39)
    >>> round(low, 2), round(high, 2)
    (0.72, 1.3)
    """
    low, high = np.sqrt(chi2.ppf([chance / 2, 1 - chance / 2], dof) / dof)
    return float(low), float(high)


def largest_rms(rows: int, parameters: int, chance: float = 1e-3) -> float:
    """Below which the rms of ``rows`` whitened residuals of a right model stays.

    Examples
    --------
    >>> round(largest_rms(126, 12), 2)
    1.15
    """
    return float(np.sqrt(chi2.ppf(1 - chance, rows - parameters) / rows))


def largest_left_out_rms(rows: int, parameters: int, chance: float = 1e-3) -> float:
    """The same where each row is left out of the fit that predicts it.

    A residual r of leverage h becomes r / (1 - h), and the mean leverage is parameters / rows.
    """
    return largest_rms(rows, parameters, chance) * rows / (rows - parameters)


def fewest_hits(trials: int, probability: float, chance: float = 1e-3) -> int:
    """Number of hits that honest intervals of this probability reach.

    Examples
    --------
    >>> fewest_hits(60, 0.9545)
    51
    """
    return int(binom.ppf(chance, trials, probability))
