"""What an error of the references leaves in the rows of the means and of the waves.

Where gravity goes round in an accelerometer, the mean and the waves have their parts of it; where a
gyroscope turns, the waves have none of the rate.
"""

import numpy as np

from calib.fit.rows.wave_rows import WaveRows
from calib.fit.rows.whitening import Whitening
from calib.poses.imu_log import FloatArray


def whitened_references(
    whitening: Whitening, waves: WaveRows | None, count: int, whole: FloatArray,
    errors: FloatArray,
) -> FloatArray:
    """Whitened columns of errors of the references.

    Parameters
    ----------
    whitening : Whitening
    waves : WaveRows or None
    count : int
        Number d of data rows.
    whole : array, shape (S n,)
        The references, with all of gravity where it goes round, SI.
    errors : array, shape (..., n, k)
        Of the references, SI per unit of each parameter.

    Returns
    -------
    array, shape (..., d, k)
        In sds of the data rows.
    """
    magnitude, lead = whitening.order.magnitude, errors.shape[:-2]
    relative = errors[..., magnitude, :] / whole.reshape(*lead, -1)[..., magnitude, None]
    columns = np.zeros((*lead, count, errors.shape[-1]))
    in_sds = whitening.stated / whitening.magnitude_sd
    columns[..., : len(magnitude), :] = relative * in_sds[..., None]
    if waves is not None and waves.of_gravity:
        in_sds = waves.of_rings.stated / waves.row_sd
        columns[..., -waves.count :, :] = relative[..., waves.row_pose, :] * in_sds[..., None]
    return columns
