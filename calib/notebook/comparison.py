"""``calib.compare(a, b)``: the parameters of two calibrations of one sensor side by side."""

from typing import TYPE_CHECKING

import numpy as np

from calib.errors import UnusableLog
from calib.notebook.calibration import Calibration
from calib.notebook.display import parameter_frame

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
    first, second = (parameter_frame(item.assessed) for item in (one, other))
    names = first.index.union(second.index, sort=False)
    first, second = first.reindex(names), second.reindex(names)
    difference, sd = second["value"] - first["value"], np.hypot(first["sd"], second["sd"])
    return DataFrame({
        "one": first["value"], "other": second["value"], "difference": difference, "sd": sd,
        "in_sd": difference / sd, "unit": first["unit"].fillna(second["unit"])})
