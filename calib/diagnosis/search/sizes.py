"""Comparison of the sizes of effects with those of real sensors.

Before any refit they are those that the residual requires, and biased by whatever else is missing.
At a joint refit, a size that no sensor has excludes the set.
"""

import numpy as np

from calib.diagnosis.constants import CONSTANTS
from calib.diagnosis.hypotheses.listed import Hypothesis
from calib.diagnosis.search.refit import Refit
from calib.diagnosis.search.table import Table
from calib.effects.effect import Effect
from calib.effects.typical import largest_for
from calib.poses.imu_log import FloatArray, Triad

SEEN_SHARE = 1e-3
"""Share of the best seen combination of parameters; those seen less have no size of their own. A
judgement."""


LEAST_TYPICAL = 0.01
"""Sds, over all rows together, that the largest size quoted for an effect must leave. Derived:
sizes of parts differ by a factor of thirty, so that what shows at a hundred times the largest is
hardly this effect."""


def shows_at_no_size(table: Table, j: int, h: Hypothesis, triad: Triad) -> bool:
    """Whether the rows show effect ``j`` only at a size that no part has."""
    if h.effect is None or h.effect.in_square or table.is_blind(j):
        return False
    sizes = [quoted.si_for(triad) for quoted in h.effect.page.typical.values()]
    largest = max((size for size in sizes if size is not None), default=np.inf)
    each = table.spectra[j]
    per_size = np.divide(np.sqrt(each.turns**2 @ np.maximum(each.squared, 0.0)), each.unit,
                         where=each.unit > 0, out=np.zeros_like(each.unit))
    return bool(largest * per_size.max() < LEAST_TYPICAL)


def largest_of(effect: Effect, triad: Triad) -> float:
    """Upper bound of the parameters of an effect in a part, SI; infinite without any.

    Nothing bounds what an evening or a bench does to a sensor, nor the unit of a logged column.
    """
    if effect.largest is not None:
        return effect.largest
    of_the_part = effect.belongs_to == "sensor" and not effect.drawn and not effect.logged
    return largest_for(triad, effect.page.typical.values()) if of_the_part else np.inf


def predicted_size(table: Table, j: int) -> tuple[FloatArray, FloatArray]:
    """Size and sd of the parameters of ``j`` alone that the residual requires, SI, each (k,)."""
    each = table.spectra[j]
    seen = each.squared > SEEN_SHARE**2 * float(each.squared.max())
    turns, squared = each.turns[:, seen], each.squared[seen]
    size = turns @ (each.along[seen] / squared)
    return size * each.unit, np.sqrt((turns**2 / squared).sum(axis=1)) * each.unit


def beyond_nature(joint: Refit) -> dict[str, float]:
    """Ratio of each effect of ``joint`` to the largest size of a sensor, where it exceeds that."""
    fit, slices = joint.fit, joint.fit.model.slices()
    times = {}
    for effect in fit.model.effects:
        if effect.name not in joint.names:
            continue
        where = slices[effect.name]
        times[effect.name] = _times(fit.theta[where], np.sqrt(np.diag(fit.cov)[where]),
                                    largest_of(effect, fit.poses.triad))
    return {name: beyond for name, beyond in times.items() if beyond}


def _times(size: FloatArray, sd: FloatArray, largest: float) -> float:
    """The size over the ``largest``; 0 where its sd allows for that."""
    if not (np.abs(size) - CONSTANTS.limit_sd * sd > largest).any():
        return 0.0
    return float(np.abs(size).max() / largest)
