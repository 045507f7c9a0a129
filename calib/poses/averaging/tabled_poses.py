"""Poses whose means a table states: a row for each, under the names that columns of logs have."""

from collections.abc import Mapping, Sequence

import numpy as np

from calib.poses.averaging.pose_mean import NOT_LOGGED, PoseMean, stated_means
from calib.poses.data_sheet import TriadSpec
from calib.poses.imu_log import AXES, TRIADS, FloatArray, Triad

PREFIX: Mapping[Triad, str] = {"accelerometer": "acc", "gyroscope": "gyr"}
TIME = "time_s"
SD = "sd_"  #: before the name of a reading: the column of its sd
SAMPLES = "samples"  #: the column that makes the sds those of the samples


def triad_columns(triad: Triad, prefix: str = "") -> list[str]:
    """Names of the three columns of a triad."""
    return [f"{prefix}{PREFIX[triad]}_{axis}" for axis in AXES]


STATED = frozenset((SAMPLES, *(SD + name for triad in TRIADS for name in triad_columns(triad))))
"""Columns that say how well the means of a table are known."""

READ = STATED | {TIME, *(name for triad in TRIADS for name in triad_columns(triad))}


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
    nothing = [NOT_LOGGED] * len(labels)
    triads = {triad: stated_means(*nominal_means(columns, triad, specs[triad]),
                                  columns.get(SAMPLES))
              if triad in specs and set(triad_columns(triad)) <= columns.keys() else nothing
              for triad in TRIADS}
    time_s = columns.get(TIME, np.full(len(labels), np.nan))
    further = {name: values for name, values in columns.items() if name not in READ}
    return [
        PoseMean(label, triads["accelerometer"][i], triads["gyroscope"][i], float(time_s[i]), 0.0,
                 {name: float(values[i]) for name, values in further.items()}, stated=True)
        for i, label in enumerate(labels)
    ]
