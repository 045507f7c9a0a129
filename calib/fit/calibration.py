"""A calibrated triad: the parameters of Angrisano et al. eq. (3), their sds, and what those are of.

With nominal scale k0 and nominal bias b0, the reading is ``y = k0 (u - b0)`` and the fit gives
``s = (I - S) y - bias``, S upper triangular. Then ``T K = (I - S) k0``, so

    k_j = k0 (1 - S_jj)      alpha = - S_ij / (1 - S_jj)      b = b0 + (I - S)^-1 bias / k0

**Budget.** The estimate is linear in the whitened rows, ``theta = P r`` with ``P = (JᵀJ)⁻¹ Jᵀ``,
and every row has unit variance; so the covariance is the sum of ``p pᵀ`` over the columns p of P.
The column of a prior row is what one sd of that common error (local gravity, the camera's clock,
the rate of a setting) does to the parameters; what remains is noise, and misfit where the sds were
widened.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from calib.effects.catalogue import BASE
from calib.errors import Undetermined
from calib.fit.correction import Correction
from calib.fit.determined import LARGEST_SHARE, BaseParameters, undetermined
from calib.fit.model import Model
from calib.fit.result import MISFIT_P_VALUE, Fit
from calib.poses.conditions import Conditions
from calib.poses.data_sheet import TriadSpec
from calib.poses.imu_log import FloatArray, Triad

NOISE = "noise"

BASE_SIZE = 9  #: parameters of Angrisano et al. eq. (3)
COMPLEX_STEP = 1e-30  #: its square is nothing beside one, so the derivative is exact to rounding


@dataclass(frozen=True, eq=False)
class TriadParameters:
    """alpha (rad), b (counts), k^-1 (counts per SI unit), each (3,) in x, y, z; cov (9, 9).

    ``cov`` is in the order misalignment, bias, scale. A group that was not in the model keeps its
    data-sheet value and has no sd (NaN).
    """

    misalignment_rad: FloatArray
    bias_counts: FloatArray
    scale_counts_per_unit: FloatArray
    cov: FloatArray

    @property
    def sd(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Sds of misalignment, bias and scale, each (3,)."""
        sd = np.sqrt(np.diag(self.cov))
        return sd[:3], sd[3:6], sd[6:]

    def matrix(self) -> FloatArray:
        """``T K`` of eq. (1), SI units per count, shape (3, 3)."""
        return alignment(self.misalignment_rad) / self.scale_counts_per_unit

    def correct(self, counts: FloatArray) -> FloatArray:
        """``T K (counts - b)`` of eq. (1), shape (n, 3)."""
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
        From the sensitive axes to the orthogonal ones.
    """
    x, y, z = misalignment_rad
    return np.array([[1.0, z, y], [0.0, 1.0, x], [0.0, 0.0, 1.0]])


def _paper_vector(theta: np.ndarray, k0: float, b0: float) -> np.ndarray:
    """(alpha, b, 1/k) of theta = (bias, scale, misalignment), each x, y, z; also complex."""
    bias, scale, (mx, my, mz) = theta[:3], theta[3:6], theta[6:]
    gain = 1 - scale
    alpha = np.array([-mx / gain[2], -my / gain[2], -mz / gain[1]])
    upper = np.diag(gain) - np.array([[0, mz, my], [0, 0, mx], [0, 0, 0]])
    b = b0 + np.linalg.solve(upper, bias) / k0
    return np.concatenate([alpha, b, 1 / (gain * k0)])


def base_theta(model: Model, theta: FloatArray, cov: FloatArray) -> tuple[FloatArray, FloatArray]:
    """theta (9,) and cov (9, 9) of bias, scale and misalignment; NaN cov for what is absent."""
    full = np.zeros(BASE_SIZE)
    full_cov = np.full((BASE_SIZE, BASE_SIZE), np.nan)
    index: list[int] = []
    source: list[int] = []
    for i, name in enumerate(BASE):
        where = model.slices().get(name)
        if where is not None:
            index += range(3 * i, 3 * i + 3)
            source += range(where.start, where.stop)
    full[index] = theta[source]
    full_cov[np.ix_(index, index)] = cov[np.ix_(source, source)]
    return full, full_cov


def triad_parameters(
    model: Model, theta: FloatArray, cov: FloatArray, spec: TriadSpec
) -> TriadParameters:
    """The paper's parameters of a fit, with their covariance by exact differentiation.

    Parameters
    ----------
    model : Model
        Of p parameters.
    theta, cov : array, shapes (p,) and (p, p)
        Those of the fit, SI.
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
    value = _paper_vector(full, k0, b0)
    jacobian = np.empty((BASE_SIZE, BASE_SIZE))
    for j in range(BASE_SIZE):
        moved = full.astype(complex)
        moved[j] += 1j * COMPLEX_STEP
        jacobian[:, j] = _paper_vector(moved, k0, b0).imag / COMPLEX_STEP
    known = ~np.isnan(np.diag(full_cov))
    filled = np.where(np.isnan(full_cov), 0.0, full_cov)
    out = jacobian @ filled @ jacobian.T
    for group, rows in ((2, slice(0, 3)), (0, slice(3, 6)), (1, slice(6, 9))):
        if not known[3 * group]:
            out[rows, :] = np.nan
            out[:, rows] = np.nan
    return TriadParameters(value[:3], value[3:6], value[6:], out)


def theta_of(parameters: TriadParameters, spec: TriadSpec) -> FloatArray:
    """theta (bias, scale, misalignment) of the linear form that is ``parameters``, shape (9,)."""
    k0, b0 = spec.nominal_scale, spec.nominal_bias_counts
    upper = parameters.matrix() / k0
    bias = upper @ (parameters.bias_counts - b0) * k0
    mx, my, mz = -upper[1, 2], -upper[0, 2], -upper[0, 1]
    return np.concatenate([bias, 1 - np.diag(upper), [mx, my, mz]])


@dataclass(frozen=True, eq=False)
class TriadCalibration:
    """One calibrated triad.

    ``parameters`` are those of Angrisano et al. eq. (3). Where the residual is larger than the
    stated sds explain (``MISFIT_P_VALUE``), noise is widened by ``widening``, the square root of
    chi-square over its degrees of freedom (Birge ratio).
    """

    triad: Triad
    spec: TriadSpec
    fit: Fit
    parameters: TriadParameters
    widening: float

    @property
    def p_value(self) -> float:
        """See :attr:`calib.fit.result.Fit.p_value`."""
        return self.fit.p_value

    def effect_values(self) -> dict[str, tuple[FloatArray, FloatArray]]:
        """Value and sd of each added effect's parameters, the shape parameter last.

        A parameter that these poses see only in combination with others has no sd of its own (NaN).
        """
        values = {}
        sd = np.where(self.fit.determined, np.sqrt(np.diag(self.fit.cov)), np.nan)
        for effect in self.fit.model.effects:
            if effect.acts_on == "reading":
                continue
            where = self.fit.model.slices()[effect.name]
            value, value_sd = self.fit.theta[where], sd[where]
            if effect.shape is not None:
                value = np.append(value, self.fit.shapes[effect.name])
                value_sd = np.append(value_sd, self.fit.shape_sd[effect.name])
            values[effect.name] = (value, value_sd)
        return values

    @property
    def correction(self) -> Correction:
        """What corrects readings, without the fit it came from."""
        return Correction(self.spec, self.fit.model, self.fit.theta, self.fit.shapes)

    def correct(self, at: Conditions) -> FloatArray:
        """Corrected vectors for nominal readings ``at.vector`` and their conditions, (n, 3)."""
        return self.correction.correct(at)


def calibrate_triad(fit: Fit, spec: TriadSpec) -> TriadCalibration:
    """Read the paper's parameters off ``fit``, with honest sds.

    Parameters
    ----------
    fit : Fit
        As :func:`calib.fit.solver.fit` gives it.
    spec : TriadSpec
        The data sheet that made the readings nominal.

    Returns
    -------
    TriadCalibration
        Where the noise does not explain the residual, noise is widened by the Birge ratio w, and
        the errors that the references have in common are left as they were stated:
        ``C + w² (cov - C)``, C the sum of their parts.

    Raises
    ------
    Undetermined
        Sds that are no smaller than what they belong to.
    """
    _require_determined(fit, spec)
    misfit = fit.bounded_p_value < MISFIT_P_VALUE
    widening = float(np.sqrt(fit.bounded_chi2 / fit.dof)) if misfit else 1.0
    common = fit.common_shift @ fit.common_shift.T
    cov = common + widening**2 * (fit.cov - common)
    return TriadCalibration(
        triad=fit.poses.triad,
        spec=spec,
        fit=replace(fit, cov=cov),
        parameters=triad_parameters(fit.model, fit.theta, cov, spec),
        widening=widening,
    )


def _require_determined(fit: Fit, spec: TriadSpec) -> None:
    value = triad_parameters(fit.model, fit.theta, fit.cov, spec)
    stated = fit.poses.reference.magnitude
    lost = undetermined(BaseParameters(
        value.misalignment_rad, value.bias_counts, value.scale_counts_per_unit, *value.sd,
        magnitude=float(stated.max()) if stated.any() else np.nan,
    ))
    if not lost:
        return
    variance = np.diag(fit.cov)
    common = fit.common_shift**2  # (p, q)
    share = (common / np.maximum(variance, 1e-300)[:, None]).max(axis=0, initial=0.0)
    names = fit.poses.reference.common_names
    cause = (
        f"Most of that comes from the stated sd of: {names[int(np.argmax(share))]}. State it as "
        f"small as it is"
        if share.size and share.max() > 1 / 2
        else "Record more poses, in directions all round and with a larger reference, or fit less"
    )
    raise Undetermined(
        f"{fit.poses.triad}: these {len(fit.poses)} poses do not determine {', '.join(lost)}: an "
        f"sd of more than {100 * LARGEST_SHARE:.0f} % of what is measured is no calibration. "
        f"{cause}."
    )


def uncertainty_budget(calibration: TriadCalibration) -> Mapping[str, FloatArray]:
    """Sd of misalignment (rad), bias (counts) and scale (counts per unit) by each cause.

    The squares of the causes add up to that of ``calibration.parameters.sd``.

    Parameters
    ----------
    calibration : TriadCalibration

    Returns
    -------
    mapping of cause to array, shape (3, 3)
        Rows are misalignment, bias and scale, columns x, y, z; NaN for what was not fitted. The
        causes are ``NOISE`` and the common errors of the reference.
    """
    fit = calibration.fit
    reference = fit.poses.reference
    parts = {
        name: np.outer(shift, shift)
        for name, shift, stated in zip(
            reference.common_names, fit.common_shift.T, reference.common.T, strict=True
        )
        if stated.any()  # not an error that was stated to be none
    }
    rest = fit.cov - sum(parts.values(), start=np.zeros_like(fit.cov))
    return {name: parameter_sds(calibration, cov) for name, cov in {NOISE: rest, **parts}.items()}


def parameter_sds(calibration: TriadCalibration, cov: FloatArray) -> FloatArray:
    """Sds of misalignment, bias and scale, (3, 3), where theta has the covariance ``cov``."""
    fit = calibration.fit
    variance = np.diag(triad_parameters(fit.model, fit.theta, cov, calibration.spec).cov)
    return np.asarray(np.sqrt(np.maximum(variance, 0.0)).reshape(3, 3))  # 0 may round below 0
