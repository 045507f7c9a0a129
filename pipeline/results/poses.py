"""The averaged poses in a results.json, and what any calibration of the sensor errs by on them."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from calib.errors import CalibrationError
from calib.fit.triad.correction import Correction
from calib.poses.conditions import Conditions
from calib.poses.imu_log import FloatArray


@dataclass(frozen=True, eq=False)
class StoredPoses:
    """The n poses of one triad in which its vector has a length: gravity, or the plate's rate.

    ``at`` are their conditions with the nominal readings, ``reference`` (n,) the lengths and
    ``sd`` (n,) those of their errors, SI.
    """

    label: tuple[str, ...]
    at: Conditions
    reference: FloatArray
    sd: FloatArray

    @classmethod
    def of(cls, triad: str, poses: Sequence[Mapping[str, Any]]) -> "StoredPoses":
        """The entries of the triad's section, without those at rest of a gyroscope."""
        used = [pose for pose in poses if pose["reading"] is not None and pose["reference"] != 0]
        force = "reading" if triad == "accelerometer" else "force_m_s2"
        names = dict.fromkeys(name for pose in used for name in pose["columns"])
        at = Conditions.of_vectors(
            _rows([pose["reading"] for pose in used]),
            {name: _values([pose["columns"].get(name) for pose in used]) for name in names},
            force=_rows([pose.get(force) for pose in used]),
            time_s=_values([pose["time_s"] for pose in used]),
            spin_rad_s=_values([pose.get("spin_rad_s") for pose in used]))
        return cls(tuple(pose["label"] for pose in used), at,
                   np.abs(_values([pose["reference"] for pose in used])),
                   _values([pose["sd"] for pose in used]))

    def errors(self, correction: Correction) -> FloatArray | None:
        """Corrected length less the reference, SI, (n,), by the part of the sensor alone.

        None where there is no such pose, and where an effect needs what these results do not hold.
        """
        if not self.label:
            return None
        try:
            corrected = correction.sensor_part().correct(self.at)
        except CalibrationError:
            return None
        error = np.linalg.norm(corrected, axis=1) - self.reference
        return error if np.isfinite(error).all() else None


def rms(values: FloatArray) -> float:
    """Root mean square, in the unit of ``values`` (n,)."""
    return float(np.sqrt(np.mean(values**2)))


def _values(values: Sequence[float | None]) -> FloatArray:
    return np.array([math.nan if value is None else value for value in values], float)


def _rows(rows: Sequence[Sequence[float | None] | None]) -> FloatArray:
    return np.array([_values(row if row is not None else [None] * 3) for row in rows],
                    float).reshape(-1, 3)
