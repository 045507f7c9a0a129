"""Spread of each parameter over a lot, its own sds removed, and sensors unlike the lot.

The spread is that of :mod:`calib.diagnosis.population.random_effects` over the sensors that are
like the lot. A sensor is unlike it in a parameter when it lies further from the median than
normal spread explains (Bonferroni over the sensors), the spread by the median absolute deviation,
which the unlike themselves hardly move.

A sensor's parameters repeat on another evening within the stated sds, or they move. For evenings e
of sensor i, with the sds of noise alone (errors that all evenings share, gravity or the camera's
clock, do not move them against each other):

    chi² = Σ_i Σ_e ((y_ie - ȳ_i) / sd_ie)²,    dof = Σ_i (E_i - 1),    Birge ratio = √(chi²/dof)

A ratio of 1 says that the stated sds hold from evening to evening; of 3, that a sensor's parameter
moves between evenings by three times what is stated (Birge, Phys. Rev. 40, 207-227, 1932).
"""

from dataclasses import dataclass

import numpy as np
from scipy.special import chdtrc, ndtri

from calib.diagnosis.population.pool import FALSE_ALARM
from calib.diagnosis.population.random_effects import RandomEffects, random_effects
from calib.numbers import MEDIAN_OF_NORMAL
from calib.poses.imu_log import BoolArray, FloatArray, IntArray

FEWEST_SENSORS = 8
"""Sensors from which a lot has a spread to be unlike of. Derived: of fewer, one that is off by any
amount moves the median absolute deviation by half of itself and more."""

FEWEST_DOF_OF_MEAN = 4.0
"""Degrees of freedom that count behind sds at least. Derived: the mean of 1/x, ν/(ν - 2), is
infinite at two; at twice as many it is 2."""


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


@dataclass(frozen=True, eq=False)
class Repeatability:
    """One parameter over the evenings of S sensors.

    Parameters
    ----------
    name : str
    birge, p_value : float
        Of the whole lot; NaN where no sensor has two evenings.
    dof : int
    of_sensor : array, shape (S,)
        Birge ratio of each sensor; NaN where it has one evening.
    moved : array of bool, shape (S,)
        Sensors that moved by more than the stated sds allow.
    """

    name: str
    birge: float
    p_value: float
    dof: int
    of_sensor: FloatArray
    moved: BoolArray


def repeatability(
    name: str, value: FloatArray, sd: FloatArray, noise_dof: FloatArray, sensor: IntArray,
    sensors: int,
) -> Repeatability:
    """Compare the evenings of each sensor.

    Parameters
    ----------
    name : str
    value, sd : array, shape (E,)
        What each of E evenings states, with the sd of its noise; NaN where it does not.
    noise_dof : array, shape (E,)
        Degrees of freedom ν behind each sd: squares over estimated variances are larger by
        Σν/(Σν - 2) on average, which is taken off.
    sensor : array of int, shape (E,)
        Which sensor each is of.
    sensors : int
        Number S of sensors.
    """
    stated = np.isfinite(value) & np.isfinite(sd) & (sd > 0)
    value, sd, sensor = value[stated], sd[stated], sensor[stated]
    known = np.maximum(np.bincount(sensor, noise_dof[stated], sensors), FEWEST_DOF_OF_MEAN)
    mean, _ = weighed_together(value, sd, sensor, sensors)
    pull = ((value - mean[sensor]) / sd) ** 2
    chi2 = np.bincount(sensor, pull, sensors) * (known - 2) / known
    dof = np.maximum(np.bincount(sensor, minlength=sensors) - 1, 0)
    several = dof > 0
    ratio = np.where(several, np.sqrt(chi2 / np.maximum(dof, 1)), np.nan)
    p_each = np.where(several, chdtrc(np.maximum(dof, 1), chi2), 1.0)
    total, free = float(chi2[several].sum()), int(dof.sum())
    return Repeatability(
        name=name,
        birge=float(np.sqrt(total / free)) if free else np.nan,
        p_value=float(chdtrc(free, total)) if free else np.nan,
        dof=free,
        of_sensor=ratio,
        moved=p_each < FALSE_ALARM / max(int(several.sum()), 1),
    )
