"""Poses whose means a table states: a row for each, under the names that columns of logs have."""

from collections.abc import Mapping, Sequence

import numpy as np

from calib.poses.averaging.pose_mean import NOT_LOGGED, PoseMean, TriadMean
from calib.poses.data_sheet import TriadSpec
from calib.poses.imu_log import TRIADS, FloatArray, Triad
from calib.poses.samples.converter_steps import printed_unit
from calib.poses.triad_kind import TRIAD_KINDS

TIME = "time_s"
SD = "sd_"  #: before the name of a reading: the column of its sd
SAMPLES = "samples"  #: the column that makes the sds those of the samples


def triad_columns(triad: Triad, prefix: str = "") -> list[str]:
    """Names of the three columns of a triad."""
    return [f"{prefix}{name}" for name in TRIAD_KINDS[triad].columns]


def is_stated(name: str) -> bool:
    """Whether a column says how well the means of a table are known."""
    return name == SAMPLES or any(name in triad_columns(triad, SD) for triad in TRIAD_KINDS)


def is_read(name: str) -> bool:
    """Whether a column is the time, a reading of every IMU, or how well one is known."""
    return (name == TIME or any(name in triad_columns(triad) for triad in TRIADS)
            or is_stated(name))


def nominal_means(
    columns: Mapping[str, FloatArray], triad: Triad, spec: TriadSpec
) -> tuple[FloatArray, FloatArray]:
    """Means of a triad and their sds by the data sheet, SI, each (n, 3); NaN for no stated sds.

    An sd contains what the digits of the means leave open.
    """
    printed = np.column_stack([columns[name] for name in triad_columns(triad)])
    stated = _stated_sds(columns, triad)
    samples = columns.get(SAMPLES, np.ones(len(printed)))
    digits = printed_unit(printed) / np.sqrt(12)
    sd = np.hypot(stated / np.sqrt(samples)[:, None], digits) * spec.nominal_scale
    return spec.nominal(printed), sd


def _stated_sds(columns: Mapping[str, FloatArray], triad: Triad) -> FloatArray:
    """The sds as they stand in a table, (n, 3), those of samples where their number is stated."""
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
    """
    triads = {triad: _means(columns, triad, spec)
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
    columns: Mapping[str, FloatArray], triad: Triad, spec: TriadSpec
) -> list[TriadMean]:
    scatter = (_stated_sds(columns, triad) * spec.nominal_scale) ** 2
    if SAMPLES not in columns:
        scatter = np.full_like(scatter, np.nan)
    return [TriadMean(m, sd**2, sd**2, s)
            for m, sd, s in zip(*nominal_means(columns, triad, spec), scatter, strict=True)]
