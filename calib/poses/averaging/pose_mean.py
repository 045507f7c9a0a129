"""Records of one pose after averaging, here or in the program that wrote a table."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from calib.poses.checks.pose_checks import check_range
from calib.poses.data_sheet import TriadSpec
from calib.poses.imu_log import TRIADS, FloatArray, Triad
from calib.poses.samples.converter_steps import printed_unit
from calib.poses.samples.in_step import Waves
from calib.poses.triad_kind import TRIAD_KINDS


@dataclass(frozen=True, eq=False)
class TriadMean:
    """Mean of one triad over one pose, in nominal SI units; NaN where it was not logged.

    Attributes
    ----------
    mean : array, shape (3,)
    variance : array, shape (3,)
        Of that mean, from BATCHES batches.
    scatter : array, shape (3,)
        Variance of the samples about it.
    parts : array, shape (PARTS, 3)
        Means of as many equal stretches; (0, 3) of a mean whose samples are not at hand.
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
    scatter: FloatArray
    parts: FloatArray = field(default_factory=lambda: np.zeros((0, 3)))
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

    def with_triad(self, triad: Triad, mean: TriadMean) -> "PoseMean":
        """The same pose with another mean of a triad."""
        if triad == "accelerometer":
            return replace(self, accelerometer=mean)
        if triad == "gyroscope":
            return replace(self, gyroscope=mean)
        return replace(self, further={**self.further, triad: mean})


_NOTHING = np.full(3, np.nan)
NOT_LOGGED = TriadMean(_NOTHING, _NOTHING, _NOTHING)
"""The mean of a triad that was not logged."""


TIME = "time_s"
SD = "sd_"  #: before the name of a reading: the column of its sd
SAMPLES = "samples"  #: the column that makes the sds those of the samples


def triad_columns(triad: Triad, prefix: str = "") -> list[str]:
    """Names of the three columns of a triad."""
    return [f"{prefix}{name}" for name in TRIAD_KINDS[triad].columns]


def is_stated(name: str) -> bool:
    """Whether a column states the uncertainty of the means of a table."""
    return name == SAMPLES or any(name in triad_columns(triad, SD) for triad in TRIAD_KINDS)


def is_read(name: str) -> bool:
    """Whether a column is the time, a reading of every IMU, or the uncertainty of one."""
    return (name == TIME or any(name in triad_columns(triad) for triad in TRIADS)
            or is_stated(name))


def nominal_means(
    labels: Sequence[str], columns: Mapping[str, FloatArray], triad: Triad, spec: TriadSpec
) -> tuple[FloatArray, FloatArray]:
    """Means of a triad and their sds by the data sheet, SI, each (n, 3); NaN for no stated sds.

    An sd includes the rounding of the means to their printed digits.

    Raises
    ------
    UnusableLog
        A mean that the converter cannot give.
    """
    printed = np.column_stack([columns[name] for name in triad_columns(triad)])
    counts = spec.signed(printed)
    farthest = int(np.abs(counts - spec.nominal_bias_counts).max(axis=1).argmax())
    check_range(labels[farthest], triad, counts[farthest], spec)
    stated = _stated_sds(columns, triad)
    samples = columns.get(SAMPLES, np.ones(len(printed)))
    digits = printed_unit(printed) / np.sqrt(12)
    sd = np.hypot(stated / np.sqrt(samples)[:, None], digits) * spec.nominal_scale
    return spec.nominal(printed), sd


def _stated_sds(columns: Mapping[str, FloatArray], triad: Triad) -> FloatArray:
    """The sds stated in a table, (n, 3): of means, or of samples if their number is stated."""
    rows = len(columns[triad_columns(triad)[0]])
    return np.column_stack([columns.get(name, np.full(rows, np.nan))
                            for name in triad_columns(triad, SD)])


def tabled_poses(
    labels: Sequence[str], columns: Mapping[str, FloatArray], specs: Mapping[Triad, TriadSpec]
) -> list[PoseMean]:
    """The rows of a table as averaged poses.

    Parameters
    ----------
    labels : sequence of str, length n
    columns : mapping of str to array, shape (n,)
        Readings as logged, ``time_s`` in s, and any further column.
    specs : mapping of triad to TriadSpec
        The data sheets of the triads to read.

    Raises
    ------
    UnusableLog
        A mean that a converter cannot give.
    """
    triads = {triad: _means(labels, columns, triad, spec)
              for triad, spec in specs.items() if set(triad_columns(triad)) <= columns.keys()}
    nothing = [NOT_LOGGED] * len(labels)
    force, rate = (triads.pop(triad, nothing) for triad in TRIADS)
    time_s = columns.get(TIME, np.full(len(labels), np.nan))
    others = {name: values for name, values in columns.items() if not is_read(name)}
    return [
        PoseMean(label, force[i], rate[i], float(time_s[i]), 0.0,
                 {name: float(values[i]) for name, values in others.items()}, stated=True,
                 further={triad: means[i] for triad, means in triads.items()})
        for i, label in enumerate(labels)
    ]


def _means(
    labels: Sequence[str], columns: Mapping[str, FloatArray], triad: Triad, spec: TriadSpec
) -> list[TriadMean]:
    scatter = (_stated_sds(columns, triad) * spec.nominal_scale) ** 2
    if SAMPLES not in columns:
        scatter = np.full_like(scatter, np.nan)
    return [TriadMean(m, sd**2, s)
            for m, sd, s in zip(*nominal_means(labels, columns, triad, spec), scatter, strict=True)]


def on_one_clock(means: Sequence[PoseMean]) -> FloatArray:
    """Mid times of poses, s, (n,); NaN where every file starts its own clock: they overlap."""
    time_s = np.array([mean.time_s for mean in means])
    half = np.array([mean.duration_s for mean in means]) / 2
    order = np.argsort(time_s)
    overlap = (time_s - half)[order][1:] < (time_s + half)[order][:-1] - 1e-6  # rounding
    return np.full(len(means), np.nan) if overlap.any() else time_s
