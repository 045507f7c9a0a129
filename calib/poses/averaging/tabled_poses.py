"""Poses whose means a table states: a row for each, under the names that columns of logs have."""

from collections.abc import Mapping, Sequence

import numpy as np

from calib.poses.averaging.pose_mean import NOT_LOGGED, PoseMean, stated_means
from calib.poses.data_sheet import TriadSpec
from calib.poses.imu_log import TRIADS, FloatArray, Triad
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
    """Means of a triad and their sds by the data sheet, SI, each (n, 3); NaN for no stated sds."""
    means = spec.nominal(np.column_stack([columns[name] for name in triad_columns(triad)]))
    names = triad_columns(triad, SD)
    if any(name not in columns for name in names):
        return means, np.full(means.shape, np.nan)
    return means, np.column_stack([columns[name] for name in names]) * spec.nominal_scale


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
    triads = {triad: stated_means(*nominal_means(columns, triad, spec), columns.get(SAMPLES))
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
