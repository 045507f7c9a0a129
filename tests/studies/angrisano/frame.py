"""The freedom of the frame taken out of gains and sensitive axes, by linear algebra."""

import numpy as np

from calib.poses.imu_log import FloatArray


def frame_free(gain: FloatArray, axes: FloatArray) -> tuple[FloatArray, FloatArray]:
    """k⁻¹ (3,), counts per SI unit, and alpha (3,), rad, of eq. (2): ``G A`` without its frame.

    The QR decomposition of ``(G A)⁻¹`` leaves the one upper triangular ``T K`` that magnitudes
    determine.
    """
    upper = np.linalg.qr(np.linalg.inv(gain[:, None] * axes), mode="r")
    upper = upper * np.sign(np.diag(upper))[:, None]  # QR leaves the sign of every row open
    k = np.diag(upper)
    t = upper / k
    return 1 / k, np.array([t[1, 2], t[0, 2], t[0, 1]])
