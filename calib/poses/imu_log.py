"""One stretch of logged inertial readings, as the sensor gave them."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from calib.errors import UnusableLog
from calib.poses.rows import Rows
from calib.poses.triad_kind import TRIAD_KINDS, PerKind

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]
IntArray = NDArray[np.int64]

Triad = str  #: name of a kind of triad (:data:`calib.poses.triad_kind.TRIAD_KINDS`)
TRIADS: tuple[Triad, Triad] = ("accelerometer", "gyroscope")  #: the triads of every IMU
AXES = ("x", "y", "z")
TEMPERATURE = "temperature_c"  #: the column of the sensor's temperature, in every log
SI_UNIT: Mapping[str, str] = PerKind(lambda kind: kind.unit)  #: SI unit of a triad's readings


@dataclass(frozen=True, eq=False)
class ImuLog(Rows):
    """Raw readings against time, checked once on creation.

    Parameters
    ----------
    label : str
        What messages call this log, for example ``pose_07.csv``.
    time_s : array, shape (t,)
        Sample times in seconds, strictly increasing.
    accelerometer, gyroscope : array, shape (t, 3)
        Raw readings in counts (or in the unit the sensor is declared to give); a triad that was
        not logged is all NaN.
    columns : mapping of name to array, shape (t,)
        Every further numeric column, for example ``temperature_c``; those of a further triad too.
    notes : tuple of str
        Sentences on what its reader changed, for example a clock that steps back.

    Raises
    ------
    UnusableLog
        Fewer than two samples, shapes that disagree, time not increasing, or NaN inside a triad.
    """

    label: str
    time_s: FloatArray
    accelerometer: FloatArray
    gyroscope: FloatArray
    columns: Mapping[str, FloatArray] = field(default_factory=dict)
    notes: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        n = len(self.time_s)
        if n < 2:
            raise UnusableLog(
                f"{self.label}: {n} sample(s) found, at least 2 expected; record the pose again."
            )
        backwards = np.flatnonzero(np.diff(self.time_s) <= 0)
        if backwards.size:
            i = int(backwards[0])
            raise UnusableLog(
                f"{self.label}: time does not increase at sample {i + 2}: {self.time_s[i]:.6g} s "
                f"is followed by {self.time_s[i + 1]:.6g} s. Remove the repeated or misplaced "
                f"rows, or record the log again."
            )
        for name in TRIADS:
            triad = getattr(self, name)
            if triad.shape != (n, 3):
                raise UnusableLog(
                    f"{self.label}: {name} readings have shape {triad.shape}, ({n}, 3) expected."
                )
            missing = ~np.isfinite(triad)
            if missing.any() and not missing.all():
                row = int(np.flatnonzero(missing.any(axis=1))[0])
                raise UnusableLog(
                    f"{self.label}: the {name} has no number at sample {row + 1}. Remove the "
                    f"damaged rows, or record the log again."
                )

    def has(self, triad: Triad) -> bool:
        """Whether a triad was logged."""
        if triad in TRIADS:
            return bool(np.isfinite(self.readings(triad)[0, 0]))
        return self.columns.keys() >= {*TRIAD_KINDS[triad].columns}

    def readings(self, triad: Triad) -> FloatArray:
        """Raw readings of a triad, (t, 3), counts as logged; a further one may lack some (NaN)."""
        if triad in TRIADS:
            return np.asarray(getattr(self, triad))
        return np.column_stack([self.columns[name] for name in TRIAD_KINDS[triad].columns])

    def between(self, start: int, stop: int, label: str) -> "ImuLog":
        """The samples ``start:stop`` as a log of their own."""
        return replace(self.take(slice(start, stop)), label=label)

    def where(self, kept: BoolArray) -> "ImuLog":
        """Some of the samples; their times show the gaps.

        Parameters
        ----------
        kept : array of bool, shape (t,)
        """
        return self.take(kept)
