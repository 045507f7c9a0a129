"""Closed-form evidence of a hypothesis about what is left in the residual.

Every hypothesis is a covariance of the projected residual r:

    r ~ N(0, I + tau² X Xᵀ + (kappa tau)² I)

X the visible part of its columns, tau the root mean square signal in noise units, kappa the
fraction to which the hypothesis need explain the residual (no listed formula is exact). The log
Bayes factor against "nothing" is averaged over tau = 1, 2, ..., 64 and over kappa: it needs no
threshold, punishes parameters that buy nothing, and does not tie where p-values underflow.
"""

from collections.abc import Sequence

import numpy as np

from calib.diagnosis.signature import Signature
from calib.poses.imu_log import FloatArray

TAUS = 2.0 ** np.arange(7)
LISTED_TOLERANCE = np.array([0.0, 0.03])
UNKNOWN_TOLERANCE = np.array([0.0, 0.1, 0.3])
SCATTER_TAUS = np.concatenate([[0.35, 0.5, 0.7], TAUS])


def log_mean_exp(values: Sequence[float] | FloatArray) -> float:
    """Logarithm of the mean of exponentials."""
    v = np.asarray(values, float)
    return float(v.max() + np.log(np.mean(np.exp(v - v.max()))))


def log_evidence(
    strength: FloatArray,
    amplitude: FloatArray,
    chi2: float,
    dof: int,
    tolerance: FloatArray,
) -> float:
    """Log Bayes factor of a signature against nothing.

    Parameters
    ----------
    strength : array, shape (v,)
        Signal along each visible direction for unit tau.
    amplitude : array, shape (v,)
        Residual along each visible direction.
    chi2, dof : float, int
        Of the whole projected residual.
    tolerance : array
        Values of kappa to average over.
    """
    tau = np.repeat(TAUS, len(tolerance))[:, None]
    nugget = (tau * np.tile(tolerance, len(TAUS))[:, None]) ** 2
    variance = 1 + nugget + (tau * strength) ** 2
    inside = -0.5 * np.log(variance) + 0.5 * amplitude**2 * (1 - 1 / variance)
    rest = max(chi2 - float(amplitude @ amplitude), 0.0)
    n = nugget[:, 0]
    outside = -0.5 * (dof - len(strength)) * np.log1p(n) + 0.5 * rest * (1 - 1 / (1 + n))
    return log_mean_exp(inside.sum(axis=1) + outside)


def log_evidences(strength: FloatArray, amplitude: FloatArray, chi2: float) -> FloatArray:
    """:func:`log_evidence` without tolerance of many small hypotheses (m, v) at once, (m,)."""
    variance = 1 + (TAUS[:, None, None] * strength) ** 2
    gain = 0.5 * np.minimum(amplitude**2, chi2) * (1 - 1 / variance) - 0.5 * np.log(variance)
    total = gain.sum(axis=2)
    top = total.max(axis=0)
    return np.asarray(top + np.log(np.mean(np.exp(total - top), axis=0)))


def signature_evidence(
    signature: Signature, residual: FloatArray, dof: int, tolerance: FloatArray
) -> float:
    """:func:`log_evidence` of a visible signature."""
    amplitude = signature.basis.T @ residual
    chi2 = float(residual @ residual)
    return log_evidence(signature.strength, amplitude, chi2, dof, tolerance)


def scatter_evidence(chi2: float, dof: int) -> float:
    """Log Bayes factor of noise larger than stated, against the stated one."""
    t2 = SCATTER_TAUS**2
    return log_mean_exp(-0.5 * dof * np.log1p(t2) + 0.5 * chi2 * t2 / (1 + t2))
