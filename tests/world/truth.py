"""The calibration parameters that a physical sensor implies, by numeric matrix algebra.

A triad delivers ``counts - offset = C v`` for a vector v in the case frame, C = diag(gain) · axes.
A calibration that knows magnitudes only can undo C up to a rotation Q: it finds the one upper
triangular matrix with positive diagonal among all ``Qᵀ C⁻¹``. That is T K of the published model
``s = T K (s_out - b)``, and ``s = Qᵀ v`` is the true vector in the frame that it calls orthogonal.
"""

from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from tests.world.imu import FloatArray, Sensor, Triad


@dataclass(frozen=True, eq=False)
class Parameters:
    """What a perfect calibration of one triad reports.

    Parameters
    ----------
    misalignment_rad : array, shape (3,)
        (αx, αy, αz) of Angrisano et al. eq. (2)-(3).
    bias_counts : array, shape (3,)
    scale_counts_per_unit : array, shape (3,)
        k⁻¹, counts per m/s² or per rad/s.
    case_to_orthogonal : array, shape (3, 3)
        Rotation Qᵀ that takes a vector in the case frame into the triad's orthogonal frame.
    reading_to_orthogonal : array, shape (3, 3)
        Takes an error along the three sensitive axes (in the triad's unit) to the error of the
        corrected vector.
    """

    misalignment_rad: FloatArray
    bias_counts: FloatArray
    scale_counts_per_unit: FloatArray
    case_to_orthogonal: FloatArray
    reading_to_orthogonal: FloatArray


def parameters(triad: Triad) -> Parameters:
    """The parameters of the published model that describe ``triad`` exactly."""
    counts_per_case_unit = triad.gain[:, None] * triad.axes
    q, upper = np.linalg.qr(np.linalg.inv(counts_per_case_unit))
    sign = np.sign(np.diag(upper))
    q, upper = q * sign, sign[:, None] * upper
    k = np.diag(upper)
    t = upper / k  # columns divided: upper = T diag(k)
    return Parameters(
        misalignment_rad=np.array([t[1, 2], t[0, 2], t[0, 1]]),
        bias_counts=triad.offset.copy(),
        scale_counts_per_unit=1 / k,
        case_to_orthogonal=q.T,
        reading_to_orthogonal=upper * triad.gain,
    )


def gyroscope_to_accelerometer(sensor: Sensor) -> FloatArray:
    """Rotation (3, 3) from the gyroscope's orthogonal frame to the accelerometer's."""
    from_case = parameters(sensor.accelerometer).case_to_orthogonal
    return from_case @ parameters(sensor.gyroscope).case_to_orthogonal.T


def gyroscope_to_accelerometer_rad(sensor: Sensor) -> FloatArray:
    """The same rotation as a rotation vector (3,), in radians about x, y, z."""
    return Rotation.from_matrix(gyroscope_to_accelerometer(sensor)).as_rotvec()


def g_sensitivity_seen(sensor: Sensor, size: FloatArray) -> FloatArray:
    """The g-sensitivity (3, 3) between the two orthogonal frames, (rad/s)/(m/s²).

    ``size`` is the error along the sensitive gyroscope axes per unit of specific force in the case.
    """
    onto_corrected = parameters(sensor.gyroscope).reading_to_orthogonal
    return onto_corrected @ size @ parameters(sensor.accelerometer).case_to_orthogonal.T
