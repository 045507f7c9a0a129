"""What the sd of each parameter is made of.

The estimate is linear in the whitened rows, ``theta = P r`` with ``P = (JᵀJ)⁻¹ Jᵀ``, and every row
has unit variance; so the covariance is the sum of ``p pᵀ`` over the columns p of P. The column of a
prior row is what one sd of that common error (local gravity, the camera's clock, the rate of a
setting) does to the parameters; what is left is noise, and misfit where the sds were widened.
"""

from collections.abc import Mapping

import numpy as np

from calib.fit.calibration import TriadCalibration
from calib.fit.gauss_newton import with_common
from calib.fit.parameters import triad_parameters
from calib.poses.imu_log import FloatArray

NOISE = "noise"


def common_shifts(calibration: TriadCalibration) -> dict[str, FloatArray]:
    """How far one sd of each common error of the references moves theta, (p,) each."""
    fit = calibration.fit
    names, q = fit.poses.reference.common_names, len(fit.eta)
    basis = with_common(fit.basis, q)
    jacobian = (fit.rows.jacobian @ basis) * np.sqrt(fit.weight)[:, None]
    scale = np.sqrt((jacobian**2).sum(axis=0))
    scale[scale == 0] = 1.0
    solve = basis @ (np.linalg.pinv(jacobian / scale) / scale[:, None])
    priors = solve[: fit.model.size, fit.equations.data_count :]
    known = (fit.poses.reference.common == 0).all(axis=0)  # errors that were stated to be none
    return {name: priors[:, j] for j, name in enumerate(names) if not known[j]}


def uncertainty_budget(calibration: TriadCalibration) -> Mapping[str, FloatArray]:
    """Sd of misalignment (rad), bias (counts) and scale (counts per unit) by each cause, (3, 3).

    Columns are x, y, z; NaN for what was not fitted. The squares of the causes add up to that of
    ``calibration.parameters.sd``.
    """
    fit = calibration.fit
    parts = {name: np.outer(p, p) for name, p in common_shifts(calibration).items()}
    rest = fit.cov - sum(parts.values(), start=np.zeros_like(fit.cov))
    return {name: _sds(calibration, cov) for name, cov in {NOISE: rest, **parts}.items()}


def _sds(calibration: TriadCalibration, cov: FloatArray) -> FloatArray:
    fit = calibration.fit
    variance = np.diag(triad_parameters(fit.model, fit.theta, cov, calibration.spec).cov)
    return np.asarray(np.sqrt(np.maximum(variance, 0.0)).reshape(3, 3))  # 0 may round below 0
