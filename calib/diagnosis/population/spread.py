"""Spread of each parameter over a lot, its own sds removed, and sensors unlike the lot.

The spread is that of :mod:`calib.diagnosis.population.random_effects` over the sensors that are
like the lot. A sensor is unlike it in a parameter when it lies further from the median than
normal spread explains (Bonferroni over the sensors), the spread by the median absolute deviation,
which the unlike themselves hardly move.
"""

from dataclasses import dataclass

import numpy as np
from scipy.special import ndtri

from calib.diagnosis.population.pool import FALSE_ALARM
from calib.diagnosis.population.random_effects import RandomEffects, random_effects
from calib.numbers import MEDIAN_OF_NORMAL
from calib.poses.imu_log import BoolArray, FloatArray, IntArray

FEWEST_SENSORS = 8
"""Sensors from which a lot has a spread to be unlike of. Derived: of fewer, one that is off by any
amount moves the median absolute deviation by half of itself and more."""


@dataclass(frozen=True, eq=False)
class Spread:
    """One parameter over a lot of S sensors.

    Parameters
    ----------
    name : str
    value, sd : array, shape (S,)
        Of each sensor, its evenings weighed together; NaN where it has none.
    of_lot : RandomEffects
        Mean and spread of the sensors that are like the lot.
    distance : array, shape (S,)
        From the median, in sds of lot and sensor together; NaN where a lot is too small.
    unlike : array of bool, shape (S,)
    """

    name: str
    value: FloatArray
    sd: FloatArray
    of_lot: RandomEffects
    distance: FloatArray
    unlike: BoolArray


def spread_of(name: str, value: FloatArray, sd: FloatArray) -> Spread | None:
    """The spread of one parameter.

    Parameters
    ----------
    name : str
    value, sd : array, shape (S,)
        What the sensors state, NaN where one does not.

    Returns
    -------
    Spread or None
        None where no sensor states the parameter with an sd.
    """
    stated = np.isfinite(value) & np.isfinite(sd) & (sd > 0)
    if not stated.any():
        return None
    distance = np.full(len(value), np.nan)
    unlike = np.zeros(len(value), dtype=bool)
    if stated.sum() >= FEWEST_SENSORS:
        centre = float(np.median(value[stated]))
        wide = float(np.median(np.abs(value[stated] - centre))) / MEDIAN_OF_NORMAL
        spread2 = max(0.0, wide**2 - float(np.median(sd[stated] ** 2)))
        distance[stated] = (value[stated] - centre) / np.sqrt(spread2 + sd[stated] ** 2)
        limit = -float(ndtri(FALSE_ALARM / 2 / stated.sum()))
        unlike[stated] = np.abs(distance[stated]) > limit
    like = stated & ~unlike
    return Spread(name, value, sd, random_effects(value[like], sd[like] ** 2), distance, unlike)


def weighed_together(
    value: FloatArray, sd: FloatArray, sensor: IntArray, sensors: int
) -> tuple[FloatArray, FloatArray]:
    """Weighted mean and sd of each sensor's evenings, each (S,), in their unit.

    Parameters
    ----------
    value, sd : array, shape (E,)
        Of E evenings; NaN where one states nothing.
    sensor : array of int, shape (E,)
        Which sensor each is of.
    sensors : int
        Number S of sensors.
    """
    stated = np.isfinite(value) & np.isfinite(sd) & (sd > 0)
    weight = np.where(stated, 1 / np.where(stated, sd, 1.0) ** 2, 0.0)
    total = np.bincount(sensor, weight, sensors)
    product = np.bincount(sensor, weight * np.where(stated, value, 0.0), sensors)
    known = total > 0
    safe = np.where(known, total, 1.0)
    return np.where(known, product / safe, np.nan), np.where(known, 1 / np.sqrt(safe), np.nan)
