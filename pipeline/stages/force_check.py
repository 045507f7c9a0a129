"""The specific force in the poses of a gyroscope, checked by the calibrated accelerometer."""

from dataclasses import dataclass

import numpy as np

from calib.consistency.force import force_notes, require_gravity
from calib.fit.triad.calibration import TriadCalibration
from calib.fit.triad.evaluable import missing_in, with_typical_columns
from calib.poses.pose_set import PoseSet


@dataclass(frozen=True)
class ForceCheck:
    """Whether the calibrated force in the gyroscope's poses is good enough to compare axes by.

    ``notes`` are sentences on what is not known of it.
    """

    is_known: bool
    notes: tuple[str, ...]


KNOWN_FORCE = ForceCheck(True, ())


def check_force(
    poses: PoseSet, accelerometer: TriadCalibration, gravity_m_s2: float
) -> ForceCheck:
    """Check the specific force in the poses of the gyroscope by the calibrated accelerometer.

    Raises
    ------
    Contradiction
        The calibrated accelerometer does not read gravity in them.
    """
    whole = with_typical_columns(accelerometer, poses)
    missing = missing_in(accelerometer, poses)
    if still := missing_in(accelerometer, whole):
        reasons = "; ".join(f"{name}: {reason}" for name, reason in still.items())
        return ForceCheck(False, (
            f"the poses of the gyroscope cannot evaluate all effects of the accelerometer "
            f"({reasons}). The specific force there is corrected without them, and the axes of "
            f"the triads were not compared.",))
    require_gravity(whole, accelerometer, gravity_m_s2)
    hardly, off = force_notes(whole, accelerometer, gravity_m_s2)
    notes = tuple(note for note in (hardly, off) if note)
    if missing and np.isfinite(poses.force).all():
        reasons = "; ".join(f"{name}: {reason}" for name, reason in missing.items())
        notes += (f"in the poses of the gyroscope the accelerometer is corrected as in its own "
                  f"poses on average, because they cannot evaluate all of its effects "
                  f"({reasons}).",)
    return ForceCheck(hardly is None, notes)
