"""Poses recorded under one reference."""

from collections.abc import Sequence
from dataclasses import dataclass

from calib.poses.averaging import PoseMean
from calib.poses.imu_log import FloatArray
from calib.poses.reference import Reference
from calib.poses.ring import Ring


@dataclass(frozen=True, eq=False)
class PoseRun:
    """Poses recorded under one reference.

    Parameters
    ----------
    name : str
        What messages call the run.
    means : sequence of PoseMean, length n
    reference : Reference
        Magnitudes of the n poses.
    spin_rad_s : array, shape (n,)
        Plate rate, positive counter-clockwise seen from above; 0 when stopped.
    expected : array, shape (n, 3)
        What a null pose should read, SI.
    ring : Ring or None
        Of a plate that leans, by the nominal accelerometer.
    """

    name: str
    means: Sequence[PoseMean]
    reference: Reference
    spin_rad_s: FloatArray
    expected: FloatArray
    ring: Ring | None = None

    @property
    def is_stated(self) -> bool:
        """Whether its means and their sds come from a table."""
        return any(mean.stated for mean in self.means)
