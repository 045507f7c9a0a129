"""``calib.compare(a, b)``: the parameters of two calibrations of one sensor beside each other."""

from typing import TYPE_CHECKING

import numpy as np

from calib.errors import UnusableLog
from calib.notebook.calibration import Calibration
from calib.notebook.display import parameters_of

if TYPE_CHECKING:
    from pandas import DataFrame


def parameter_differences(one: Calibration, other: Calibration) -> "DataFrame":
    """Every parameter of two calibrations, and their difference in its sd.

    Parameters
    ----------
    one, other : Calibration
        Of the same triad; their sds count as independent.

    Returns
    -------
    DataFrame
        Columns ``one``, ``other``, ``difference``, ``sd``, ``in_sd`` and ``unit`` by the
        parameter's name; NaN for a parameter that only one of them has.

    Raises
    ------
    UnusableLog
        They are of different triads, or of different data sheets.
    """
    from pandas import DataFrame

    if one.triad != other.triad:
        raise UnusableLog(f"one calibration is of the {one.triad}, the other of the {other.triad}: "
                          "compare two of the same triad.")
    if one.assessed.calibration.spec != other.assessed.calibration.spec:
        raise UnusableLog("the calibrations are of readings in different units or ranges: a count "
                          "of the one is no count of the other.")
    values = [{name: (value, sd, unit) for name, unit, value, sd in parameters_of(item.assessed)}
              for item in (one, other)]
    names = list(dict.fromkeys([*values[0], *values[1]]))
    lacking = (np.nan, np.nan, "")
    first, second = ([item.get(name, lacking) for name in names] for item in values)
    difference = np.array([b[0] - a[0] for a, b in zip(first, second, strict=True)])
    sd = np.array([np.hypot(a[1], b[1]) for a, b in zip(first, second, strict=True)])
    return DataFrame({
        "one": [a[0] for a in first], "other": [b[0] for b in second], "difference": difference,
        "sd": sd, "in_sd": difference / sd,
        "unit": [a[2] or b[2] for a, b in zip(first, second, strict=True)]}, index=names)
