"""Errors of the next log by effects of the model that no sample of it tells.

The pose before, the vibration within a pose and the clock of the session are facts of the
calibration session. In another log such an effect counts as without a pose before, in
quiet, off the plate and at the end of the session: with e(v, i) its error of the true vector v in
the conditions of pose i, and e(v) under those, a magnitude along n errs by

    E²(n) = <(n · (e(v, i) - e(v)))²>   over the poses i

What stays as it is after the session, like a step, has its last level and no such error.
"""

import numpy as np

from calib.effects.effect import Effect
from calib.fit.rows.sensitive_axes import axes_of, sensor_columns
from calib.fit.triad.calibration import TriadCalibration
from calib.fit.validation.prediction import Prediction
from calib.poses.conditions import Conditions
from calib.poses.imu_log import FloatArray

LATER = 2.0
"""Times the end of the session at which an effect that stays is the same. Numerical: any later time
would do, since the two are compared for equality."""


def untold_errors(calibration: TriadCalibration, prediction: Prediction) -> dict[str, FloatArray]:
    """Mean square error (m, d) of a corrected magnitude by each such effect of the model, SI.

    Parameters
    ----------
    calibration : TriadCalibration
    prediction : Prediction
        Its magnitudes (m,) and directions (d, 3).

    Returns
    -------
    dict of name to array, shape (m, d)
    """
    fit = calibration.fit
    at = fit.poses.conditions(fit.rows.vector)
    errors = {}
    for effect in fit.model.effects:
        if effect.acts_on == "sensor" and effect.told_by in ("clock", "nothing"):
            square = np.array([_mean_square(calibration, effect, at, size * prediction.directions)
                               for size in prediction.magnitude])
            if square.any():
                errors[effect.name] = square
    return errors


def _mean_square(
    calibration: TriadCalibration, effect: Effect, at: Conditions, true: FloatArray
) -> FloatArray:
    """E² (d,) of true vectors (d, 3), SI."""
    fit, (n, d) = calibration.fit, (len(at), len(true))
    rows = at.take(np.repeat(np.arange(n), d)).with_vector(np.tile(true, (n, 1)))
    end = float(at.time_s.max())
    in_a_log, later = rows.as_in_a_log(end), rows.as_in_a_log(LATER * end)
    axes = axes_of(calibration.correction.linear_form()[0])
    of_pose, of_log, of_later = (
        sensor_columns((effect,), each, fit.shapes, axes) for each in (rows, in_a_log, later))
    if effect.told_by == "clock" and np.array_equal(of_log, of_later):
        return np.zeros(d)
    theta = fit.theta[fit.model.slices()[effect.name]]
    along = np.tile(true / np.linalg.norm(true, axis=1, keepdims=True), (n, 1))
    errors = np.einsum("ri,rik,k->r", along, of_pose - of_log, theta).reshape(n, d)
    return np.asarray((errors**2).mean(axis=0))
