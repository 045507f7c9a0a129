"""The scatter of the plate's rate between runs, and what it does to the parameters.

A setting of the plate has one rate, which is off by the same share in all poses of its run. What
these shares scatter by does not average down within a run, and no widening of the poses' noise
contains it. With Z the column of one relative error per run, M the projector that takes the model
out and r the residual, all whitened, the variance is Henderson's third estimator

    σ² = (rᵀ H r - k s²) / tr(Zᵀ M Z),   H the projector on M Z, k its rank,

s² chi-square over its degrees of freedom within the runs, at least 1. Of k + 1 runs it is known
with k degrees of freedom only: Student's quantile keeps 68 % of the errors within one sd.
"""

import numpy as np

from calib.fit.least_squares.result import MISFIT_P_VALUE, Fit
from calib.poses.imu_log import FloatArray

SEEN_SHARE = 1e-3
"""Share of a column of Z, squared, that the model must leave for it to count as seen. Numerical:
the sum of all columns is the scale's and leaves about 1e-20 of itself, a run among others half."""

ONE_SD = 0.841345  #: normal distribution function at one sd; definition


def scatter_between_runs(fit: Fit) -> FloatArray:
    """Covariance of the parameters by the scatter of the plate's rate between runs, SI.

    Parameters
    ----------
    fit : Fit
        Of p parameters, with the covariance by the stated sds.

    Returns
    -------
    array, shape (p, p)
        Zero where the stated sds explain the residual, for an accelerometer and for a single run.
    """
    p = fit.model.size
    nothing = np.zeros((p, p))
    runs = _runs(fit)
    if runs.shape[1] < 2 or fit.bounded_p_value >= MISFIT_P_VALUE:
        return nothing
    root = np.sqrt(fit.weight)
    jacobian = fit.rows.jacobian @ fit.directions * root[:, None]
    q, r = np.linalg.qr(jacobian)
    of_runs = runs * root[:, None]
    shown = of_runs - q @ (q.T @ of_runs)
    u, singular, _ = np.linalg.svd(shown, full_matrices=False)
    seen = singular**2 > SEEN_SHARE * (of_runs**2).sum(axis=0).max()
    k = int(seen.sum())
    between = float(((u[:, seen].T @ (fit.rows.residual * root)) ** 2).sum())
    within = max(1.0, (float(fit.weight @ fit.rows.residual**2) - between) / max(fit.dof - k, 1))
    variance = (between - k * within) / float((singular**2).sum())
    if k == 0 or variance <= 0:
        return nothing
    from scipy.special import stdtrit

    shift = fit.directions[:p] @ np.linalg.solve(r, q.T @ of_runs)  # (p, runs)
    return np.asarray(variance * float(stdtrit(k, ONE_SD)) ** 2 * shift @ shift.T)


def _runs(fit: Fit) -> FloatArray:
    """Whitened magnitude rows by a relative error of the rate of each run, (r, runs)."""
    poses, turning = fit.poses, fit.equations.magnitude
    if poses.triad != "gyroscope":
        return np.zeros((len(fit.rows.residual), 0))
    run = np.array(poses.run)[turning]
    rate = poses.reference.magnitude[turning] / fit.equations.magnitude_sd
    columns = np.zeros((len(fit.rows.residual), len(set(run))))
    for j, name in enumerate(dict.fromkeys(run)):
        columns[: len(turning), j] = np.where(run == name, rate, 0.0)
    return columns
