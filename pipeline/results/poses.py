"""The averaged poses in a results.json, and what any calibration of the sensor errs by on them."""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from calib.errors import CalibrationError
from calib.fit.triad.correction import Correction
from calib.poses.conditions import Conditions
from calib.poses.imu_log import FloatArray
from pipeline.results.read import StoredTriad


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
    def of(cls, triad: StoredTriad) -> "StoredPoses":
        """The poses of a triad's section, without those at rest of a gyroscope."""
        used = [pose for pose in triad.section.poses if pose.reference != 0]
        names = dict.fromkeys(name for pose in used for name in pose.columns)
        reading = np.array([pose.reading for pose in used], float).reshape(-1, 3)
        force = reading if triad.name == "accelerometer" else np.array(
            [pose.force_m_s2 or [None] * 3 for pose in used], float).reshape(-1, 3)
        at = Conditions.of_vectors(
            reading, {name: _values(pose.columns.get(name) for pose in used) for name in names},
            force=force, time_s=_values(pose.time_s for pose in used),
            spin_rad_s=_values(pose.spin_rad_s for pose in used))
        return cls(tuple(pose.label for pose in used), at,
                   np.abs(_values(pose.reference for pose in used)),
                   _values(pose.sd for pose in used))

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


def _values(values: Iterable[float | None]) -> FloatArray:
    return np.array([*values], float)
