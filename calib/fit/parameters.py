"""The parameters of Angrisano et al. eq. (3), and the linear form that is fitted.

With nominal scale k0 and nominal bias b0, the reading is ``y = k0 (u - b0)`` and the fit gives
``s = (I - S) y - bias``, S upper triangular. Then ``T K = (I - S) k0``, so

    k_j = k0 (1 - S_jj)      alpha = - S_ij / (1 - S_jj)      b = b0 + (I - S)^-1 bias / k0
"""

from dataclasses import dataclass

import numpy as np

from calib.effects.catalogue import BASE
from calib.fit.model import Model
from calib.poses.data_sheet import TriadSpec
from calib.poses.imu_log import FloatArray

BASE_SIZE = 9  #: parameters of Angrisano et al. eq. (3); definition
COMPLEX_STEP = 1e-30  #: its square vanishes beside one, so that derivatives are exact; numerical


@dataclass(frozen=True, eq=False)
class TriadParameters:
    """The nine parameters of Angrisano et al. eq. (3), each group in x, y, z.

    A group that was not in the model keeps its data-sheet value and has no sd (NaN).

    Parameters
    ----------
    misalignment_rad : array, shape (..., 3)
        alpha of eq. (2), rad.
    bias_counts : array, shape (..., 3)
        b, counts of the converter.
    scale_counts_per_unit : array, shape (..., 3)
        1 / k, counts per m/s² or per rad/s.
    cov : array, shape (..., 9, 9)
        In the order misalignment, bias, scale.
    """

    misalignment_rad: FloatArray
    bias_counts: FloatArray
    scale_counts_per_unit: FloatArray
    cov: FloatArray

    @property
    def sd(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Sds of misalignment (rad), bias (counts) and scale (counts per unit), each (..., 3)."""
        sd = np.sqrt(np.einsum("...kk->...k", self.cov))
        return sd[..., :3], sd[..., 3:6], sd[..., 6:]

    def matrix(self) -> FloatArray:
        """``T K`` of eq. (1), SI units per count, shape (3, 3)."""
        return alignment(self.misalignment_rad) / self.scale_counts_per_unit

    def correct(self, counts: FloatArray) -> FloatArray:
        """``T K (counts - b)`` of eq. (1).

        Parameters
        ----------
        counts : array, shape (n, 3)
            Readings of the converter, signed.

        Returns
        -------
        array, shape (n, 3)
            m/s² or rad/s, on the orthogonal axes.
        """
        return np.asarray((counts - self.bias_counts) @ self.matrix().T)


def alignment(misalignment_rad: FloatArray) -> FloatArray:
    """T of Angrisano et al. eq. (2).

    Parameters
    ----------
    misalignment_rad : array, shape (3,)
        alpha in x, y, z, rad.

    Returns
    -------
    array, shape (3, 3)
        From the sensitive axes to the orthogonal ones, no unit.
    """
    x, y, z = misalignment_rad
    return np.array([[1.0, z, y], [0.0, 1.0, x], [0.0, 0.0, 1.0]])


def _paper_vector(theta: np.ndarray, k0: float, b0: float) -> np.ndarray:
    """(alpha, b, 1/k) of theta (..., 9) = (bias, scale, misalignment), each x, y, z; also complex.
    """
    bias, scale, lean = theta[..., :3], theta[..., 3:6], theta[..., 6:]
    gain = 1 - scale
    alpha = -lean / gain[..., [2, 2, 1]]
    upper = gain[..., None] * np.eye(3)
    upper[..., [1, 0, 0], [2, 2, 1]] = -lean
    b = b0 + np.linalg.solve(upper, bias[..., None])[..., 0] / k0
    return np.concatenate([alpha, b, 1 / (gain * k0)], axis=-1)


def base_theta(model: Model, theta: FloatArray, cov: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Bias, scale and misalignment from the parameters of any model.

    Parameters
    ----------
    model : Model
        Of p parameters.
    theta, cov : array, shapes (..., p) and (..., p, p)
        SI.

    Returns
    -------
    theta : array, shape (..., 9)
        SI, 0 for what the model does not hold.
    cov : array, shape (..., 9, 9)
        SI, NaN for what the model does not hold.
    """
    lead = theta.shape[:-1]
    full = np.zeros((*lead, BASE_SIZE))
    full_cov = np.full((*lead, BASE_SIZE, BASE_SIZE), np.nan)
    index: list[int] = []
    source: list[int] = []
    for i, name in enumerate(BASE):
        where = model.slices().get(name)
        if where is not None:
            index += range(3 * i, 3 * i + 3)
            source += range(where.start, where.stop)
    full[..., index] = theta[..., source]
    rows, from_rows = np.array(index, dtype=int)[:, None], np.array(source, dtype=int)[:, None]
    full_cov[..., rows, index] = cov[..., from_rows, source]
    return full, full_cov


def triad_parameters(
    model: Model, theta: FloatArray, cov: FloatArray, spec: TriadSpec
) -> TriadParameters:
    """The paper's parameters of a fit, with their covariance by exact differentiation.

    Parameters
    ----------
    model : Model
        Of p parameters.
    theta, cov : array, shapes (..., p) and (..., p, p)
        Those of the fit, or of S fits, SI.
    spec : TriadSpec
        The data sheet that made the readings nominal.

    Returns
    -------
    TriadParameters
        Misalignment in rad, bias in counts, scale in counts per unit; NaN covariance for what the
        model does not hold.
    """
    full, full_cov = base_theta(model, theta, cov)
    k0, b0 = spec.nominal_scale, spec.nominal_bias_counts
    value = _paper_vector(full, k0, b0) + 0.0  # no -0 for what is not fitted
    jacobian = np.empty((*full.shape, BASE_SIZE))
    for j in range(BASE_SIZE):
        moved = full.astype(complex)
        moved[..., j] += 1j * COMPLEX_STEP
        jacobian[..., j] = _paper_vector(moved, k0, b0).imag / COMPLEX_STEP
    filled = np.where(np.isnan(full_cov), 0.0, full_cov)
    out = jacobian @ filled @ jacobian.swapaxes(-1, -2)
    for name, rows in zip(BASE, (slice(3, 6), slice(6, 9), slice(0, 3)), strict=True):
        if name not in model.names:
            out[..., rows, :] = np.nan
            out[..., :, rows] = np.nan
    return TriadParameters(value[..., :3], value[..., 3:6], value[..., 6:], out)


def theta_of(parameters: TriadParameters, spec: TriadSpec) -> FloatArray:
    """The linear form of ``parameters``.

    Parameters
    ----------
    parameters : TriadParameters
    spec : TriadSpec
        The data sheet that makes the readings nominal.

    Returns
    -------
    array, shape (9,)
        Bias (m/s² or rad/s), scale and misalignment (without a unit), each x, y, z.
    """
    k0, b0 = spec.nominal_scale, spec.nominal_bias_counts
    upper = parameters.matrix() / k0
    bias = upper @ (parameters.bias_counts - b0) * k0
    mx, my, mz = -upper[1, 2], -upper[0, 2], -upper[0, 1]
    return np.concatenate([bias, 1 - np.diag(upper), [mx, my, mz]])
