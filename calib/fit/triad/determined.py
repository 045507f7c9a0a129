"""Test whether a calibration's parameters are determined, and the rate's scatter between runs.

A wrong parameter makes a corrected vector of magnitude m wrong by a share of m: a gain by its
relative error, a misalignment by its angle, a bias by its size over m. ``LARGEST_SHARE`` is the one
limit for all three. It is judged with the stated sds, before any widening by misfit.

A setting of the plate has one rate, whose relative error is the same in all poses of its run. The
scatter of these errors does not average down within a run, and no widening of the poses' noise
contains it. With Z the column of one relative error per run, M the projector that removes the model
and r the residual, all whitened, the variance is Henderson's third estimator

    σ² = (rᵀ H r - k s²) / tr(Zᵀ M Z),   H the projector on M Z, k its rank,

s² chi-square over its degrees of freedom within the runs, at least 1. It counts where
``rᵀ H r / k s²`` is no F ratio of noise: all rows together hardly show two rates that contradict
each other. With k + 1 runs it has only k degrees of freedom: Student's quantile keeps 68 % of the
errors within one sd.
"""

from collections.abc import Iterator

import numpy as np
from scipy.special import fdtrc, stdtrit

from calib.fit.least_squares.result import MISFIT_P_VALUE, Fit
from calib.fit.parameters import TriadParameters
from calib.poses.imu_log import AXES, BoolArray, FloatArray

LARGEST_SHARE = 0.1
"""Largest relative sd r of a parameter: in a linear fit the curvature moves it by r sds. A data
sheet states most gains to 3 %: ten are no calibration. Derived."""


def undetermined(parameters: TriadParameters, magnitude: float) -> tuple[str, ...]:
    """The parameters that the data do not determine.

    Parameters
    ----------
    parameters : TriadParameters
        With the stated sds; the sd of what was not fitted is NaN.
    magnitude : float
        The largest that was measured, SI; NaN where nothing but rest was.

    Returns
    -------
    tuple of str
        Each in words; empty where all are determined.

    Examples
    --------
    >>> nil, cov = np.zeros(3), np.diag([0, 0, 0, 0, 0, 0, 4e8, 9, 9])
    >>> undetermined(TriadParameters(nil, nil, nil + 9e3, cov), 1.7)
    ('scale x 9e+03 ± 2e+04',)
    """
    return tuple(_each(parameters, magnitude))


def is_undetermined(p: TriadParameters, magnitude: FloatArray) -> BoolArray:
    """Whether the data do not determine a parameter, for one sensor or many.

    Parameters
    ----------
    p : TriadParameters
    magnitude : array, shape (...,)
        The largest that was measured, SI; NaN where nothing but rest was.

    Returns
    -------
    array of bool, shape (..., 3, 3)
        Scale, misalignment and bias, each x, y, z; a gain that is not positive counts.
    """
    gain = np.abs(p.scale_counts_per_unit)
    size = np.where(gain > 0, gain, np.nan)
    misalignment_sd, bias_sd, scale_sd = p.sd
    shares = [scale_sd / size, misalignment_sd, bias_sd / size / np.asarray(magnitude)[..., None]]
    lost = np.stack(shares, axis=-2) > LARGEST_SHARE  # False for NaN: not fitted, or only rest
    lost[..., 0, :] |= ~(p.scale_counts_per_unit > 0)
    return np.asarray(lost)


def _each(p: TriadParameters, magnitude: float) -> Iterator[str]:
    misalignment_sd, bias_sd, scale_sd = p.sd
    values = (("scale", p.scale_counts_per_unit, scale_sd),
              ("misalignment", p.misalignment_rad, misalignment_sd),
              ("bias", p.bias_counts, bias_sd))
    lost = is_undetermined(p, np.asarray(magnitude))
    for (name, value, sd), of_group in zip(values, lost, strict=True):
        for k in np.flatnonzero(of_group):
            if name == "scale" and not value[k] > 0:
                yield f"{name} {AXES[k]} {value[k]:.3g} (not positive)"
            else:
                yield f"{name} {AXES[k]} {value[k]:.3g} ± {sd[k]:.2g}"


SEEN_SHARE = 1e-3
"""Share of what the common errors leave of a column of Z, squared, that the model must leave for it
to count as seen. Numerical: the sum of all columns is the scale's and leaves about 1e-6 of itself,
a run among others half."""

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
        Zero where the stated sds explain the residual between the runs, for an accelerometer and
        for a single run.
    """
    p = fit.model.size
    nothing = np.zeros((p, p))
    runs = _runs(fit)
    if fit.poses.triad != "gyroscope" or runs.shape[1] < 2:
        return nothing
    root = np.sqrt(fit.weight)
    q, _ = np.linalg.qr(fit.weighted_jacobian)
    common = q[:, : len(fit.eta)]  # they come first
    of_runs = runs * root[:, None]
    shown = of_runs - q @ (q.T @ of_runs)
    u, singular, _ = np.linalg.svd(shown, full_matrices=False)
    free = of_runs - common @ (common.T @ of_runs)
    seen = singular**2 > SEEN_SHARE * (free**2).sum(axis=0).max()
    k = int(seen.sum())
    between = float(((u[:, seen].T @ (fit.rows.residual * root)) ** 2).sum())
    rest = max(fit.dof - k, 1)
    within = max(1.0, (float(fit.weight @ fit.rows.residual**2) - between) / rest)
    if k == 0 or fdtrc(k, min(rest, fit.noise_dof), between / k / within) >= MISFIT_P_VALUE:
        return nothing
    variance = (between - k * within) / float((singular**2).sum())
    shift = shift_by_rates(fit)
    return np.asarray(variance * float(stdtrit(k, ONE_SD)) ** 2 * shift @ shift.T)


def shift_by_rates(fit: Fit) -> FloatArray:
    """Shift of the parameters by a relative error of each run's magnitude, SI, (p, runs)."""
    of_runs = _runs(fit) * np.sqrt(fit.weight)[:, None]
    q, r = np.linalg.qr(fit.weighted_jacobian)
    return np.asarray(fit.directions[: fit.model.size] @ np.linalg.solve(r, q.T @ of_runs))


def _runs(fit: Fit) -> FloatArray:
    """Whitened magnitude rows by a relative error of the magnitude of each run, (r, runs)."""
    poses, turning = fit.poses, fit.equations.magnitude
    run = np.array(poses.run)[turning]
    rate = poses.reference.magnitude[turning] / fit.equations.magnitude_sd
    columns = np.zeros((len(fit.rows.residual), len(set(run))))
    for j, name in enumerate(dict.fromkeys(run)):
        columns[: len(turning), j] = np.where(run == name, rate, 0.0)
    return columns
