"""Errors of the next log by effects of the model that no sample of it tells.

The pose before, the vibration within a pose and the clock of the session are facts of the
calibration session. In another log such an effect counts as without a pose before, in
quiet, off the plate and at the end of the session: with e(v, i) its error of the true vector v in
the conditions of pose i, and e(v) under those, a magnitude along n errs by

    E²(n) = <(n · (e(v, i) - e(v)))²>   over the poses i

What stays as it is after the session, like a step, has its last level and no such error.
"""

from collections.abc import Iterator

import numpy as np

from calib.effects.effect import Effect
from calib.fit.rows.sensitive_axes import axes_of, sensor_columns
from calib.fit.triad.calibration import TriadCalibration
from calib.fit.validation.prediction import Prediction
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
    along = prediction.directions
    squares = {
        effect.name: np.array([
            np.mean(np.einsum("di,ndi->nd", along, _errors(calibration, effect, size * along)) ** 2,
                    axis=0)
            for size in prediction.magnitude])
        for effect in untold(calibration)
    }
    return {name: square for name, square in squares.items() if square.any()}


def untold_covariance(calibration: TriadCalibration, true: FloatArray) -> FloatArray:
    """Mean square error (3, 3) of one corrected vector (3,) by all such effects, SI."""
    errors = [_errors(calibration, effect, true[None])[:, 0] for effect in untold(calibration)]
    return sum((each.T @ each / len(each) for each in errors), np.zeros((3, 3)))


def untold(calibration: TriadCalibration) -> Iterator[Effect]:
    """The effects of its model that no sample of another log tells."""
    for effect in calibration.fit.model.effects:
        if effect.acts_on == "sensor" and effect.told_by in ("clock", "nothing"):
            yield effect


def _errors(calibration: TriadCalibration, effect: Effect, true: FloatArray) -> FloatArray:
    """``e(v, i) - e(v)`` of true vectors v (d, 3), SI, shape (n, d, 3)."""
    fit, d = calibration.fit, len(true)
    at, n = fit.poses.conditions(fit.rows.vector), len(fit.poses)
    rows = at.take(np.repeat(np.arange(n), d)).with_vector(np.tile(true, (n, 1)))
    end = float(at.time_s.max())
    in_a_log, later = rows.as_in_a_log(end), rows.as_in_a_log(LATER * end)
    axes = axes_of(calibration.correction.linear_form()[0])
    of_pose, of_log, of_later = (
        sensor_columns((effect,), each, fit.shapes, axes) for each in (rows, in_a_log, later))
    if effect.told_by == "clock" and np.array_equal(of_log, of_later):
        return np.zeros((n, d, 3))
    theta = fit.theta[fit.model.slices()[effect.name]]
    return np.asarray(((of_pose - of_log) @ theta).reshape(n, d, 3))
