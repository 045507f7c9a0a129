"""What is known of one pose once its samples are averaged."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from calib.poses.imu_log import TRIADS, FloatArray, Triad
from calib.poses.samples.in_step import Waves


@dataclass(frozen=True, eq=False)
class TriadMean:
    """Mean of one triad over one pose, in nominal SI units; NaN where it was not logged.

    Attributes
    ----------
    mean : array, shape (3,)
    variance, coarse_variance : array, shape (3,)
        Of that mean, from BATCHES and from COARSE_BATCHES batches.
    scatter : array, shape (3,)
        Variance of the samples about it.
    step : array, shape (3,)
        Between neighbouring values of the log; infinite where there was one value only.
    unit : array, shape (3,)
        The least step that its converter or its decimals can have.
    envelope : array, shape (e, 2, 3)
        Lowest and highest sample of equal stretches.
    waves : Waves or None
        In step with the plate, where it turned.
    """

    mean: FloatArray
    variance: FloatArray
    coarse_variance: FloatArray
    scatter: FloatArray
    step: FloatArray = field(default_factory=lambda: np.full(3, np.inf))
    unit: FloatArray = field(default_factory=lambda: np.zeros(3))
    envelope: FloatArray = field(default_factory=lambda: np.zeros((0, 2, 3)))
    waves: Waves | None = None


@dataclass(frozen=True, eq=False)
class PoseMean:
    """One averaged pose.

    Attributes
    ----------
    label : str
    accelerometer, gyroscope : TriadMean
    time_s, duration_s : float
        Mean of its time stamps, and from the first to the last.
    columns : dict of str to float
        Mean of every further column of the log.
    creep_rad_s : float
        How fast it turned although at rest, as far as gravity shows that.
    sway_rad2 : float
        Mean square of the angle by which it rocked, rad²; NaN without a gyroscope.
    stated : bool
        Whether mean and sd come from a table; an sd that was not stated there is NaN.
    further : mapping of str to TriadMean
        Means of the further triads that were logged.
    """

    label: str
    accelerometer: TriadMean
    gyroscope: TriadMean
    time_s: float
    duration_s: float
    columns: dict[str, float]
    creep_rad_s: float = 0.0
    sway_rad2: float = math.nan
    stated: bool = False
    further: Mapping[str, TriadMean] = field(default_factory=dict)

    def of(self, triad: Triad) -> TriadMean:
        """The mean of a triad; NaN where it was not logged."""
        return getattr(self, triad) if triad in TRIADS else self.further.get(triad, NOT_LOGGED)


_NOTHING = np.full(3, np.nan)
NOT_LOGGED = TriadMean(_NOTHING, _NOTHING, _NOTHING, _NOTHING)
"""The mean of a triad that was not logged."""
