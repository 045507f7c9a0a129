"""A calibrated triad: its parameters, their sds, and the budget of the sds.

**Budget.** The estimate is linear in the whitened rows, ``theta = P r`` with ``P = (JᵀJ)⁻¹ Jᵀ``,
and every row has unit variance; so the covariance is the sum of ``p pᵀ`` over the columns p of P.
The column of a prior row is what one sd of that common error (local gravity, the camera's clock,
the rate of a setting) does to the parameters; what remains is noise, and misfit where the sds were
widened.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np

from calib.errors import Undetermined
from calib.fit.least_squares.result import Fit
from calib.fit.least_squares.unknown_sd import noise_of
from calib.fit.parameters import TriadParameters, triad_parameters
from calib.fit.triad.correction import Correction
from calib.fit.triad.determined import LARGEST_SHARE, scatter_between_runs, undetermined
from calib.fit.triad.within_poses import courses_within
from calib.numbers import NO_LENGTH
from calib.poses.conditions import Conditions
from calib.poses.data_sheet import TriadSpec
from calib.poses.imu_log import FloatArray, Triad

TOLD_WIDENING = 1.1
"""Ratio of the sds to those of the noise alone from which it is reported: it chooses words only."""

NOISE = "noise"
BETWEEN_RUNS = "rate, from run to run"


@dataclass(frozen=True, eq=False)
class TriadCalibration:
    """One calibrated triad.

    Attributes
    ----------
    triad : str
    spec : TriadSpec
        The data sheet that made the readings nominal.
    fit : Fit
        Its ``cov`` is widened.
    parameters : TriadParameters
        Those of Angrisano et al. eq. (3).
    widening : float
        By how much the sds exceed those of the stated noise: the root of the variance to expect
        (:meth:`calib.fit.noise_size.Noise.expected_variance`), and of a calibration
        :meth:`averaged` the root mean square ratio of all parameters.
    unaveraged : mapping of cause to array, shape (p, p)
        What adds to ``fit.cov`` and does not average down over poses: the scatter of the plate's
        rate between runs, and courses that all poses have in common.
    """

    triad: Triad
    spec: TriadSpec
    fit: Fit
    parameters: TriadParameters
    widening: float
    unaveraged: Mapping[str, FloatArray]

    def averaged(self, factor: float, held: FloatArray) -> "TriadCalibration":
        """The same calibration with sds averaged over effects that may be missing.

        Parameters
        ----------
        factor : float
            Of the variance of the noise.
        held : array, shape (p, p)
            Mean of the products of what the parameters hold of errors that no model has.
        """
        stated = self.noise_cov / self.widening**2
        noise = factor * stated + held
        cov = self.fit.cov - self.noise_cov + noise
        seen = np.diag(stated) > 0
        ratio = float(np.sqrt(np.mean(np.diag(noise)[seen] / np.diag(stated)[seen])))
        return replace(
            self, fit=replace(self.fit, cov=cov), widening=ratio,
            parameters=triad_parameters(self.fit.model, self.fit.theta, cov, self.spec))

    @property
    def is_widened(self) -> bool:
        """Whether the sds exceed those of the noise by enough to be reported."""
        return self.widening > TOLD_WIDENING

    @property
    def noise_cov(self) -> FloatArray:
        """Covariance (p, p) of the errors that poses do not share: noise, widened by the misfit."""
        common = self.fit.common_shift
        return np.asarray(self.fit.cov - common @ common.T - sum(self.unaveraged.values()))

    def effect_values(self) -> dict[str, tuple[FloatArray, FloatArray]]:
        """Value and sd of each added effect's parameters, by its name.

        Returns
        -------
        dict of str to (array, array), both shape (k,), or (k + 1,) with a shape parameter
            In the unit of the effect, the shape parameter last in its own. A parameter that these
            poses see only in combination with others has no sd of its own (NaN).
        """
        values = {}
        sd = np.where(self.fit.determined, np.sqrt(np.diag(self.fit.cov)), np.nan)
        for effect in self.fit.model.effects:
            if effect.acts_on == "reading":
                continue
            where = self.fit.model.slices()[effect.name]
            value, value_sd = self.fit.theta[where], sd[where]
            if effect.drawn:
                value_sd = np.sqrt(np.diag(self.fit.cov)[where])
            if effect.shape is not None:
                value = np.append(value, self.fit.shapes[effect.name])
                value_sd = np.append(value_sd, self.fit.shape_sd.get(effect.name, np.nan))
            values[effect.name] = (value, value_sd)
        return values

    @property
    def end_s(self) -> float:
        """Time of its last pose since the session began, s; NaN where no times are known."""
        return float(self.fit.poses.time_s.max())

    @property
    def correction(self) -> Correction:
        """The correction of readings alone, without the fit it came from."""
        return Correction(self.spec, self.fit.model, self.fit.theta, self.fit.shapes)

    def covariance_of(self, quantity: Callable[[Correction], FloatArray]) -> FloatArray:
        """Covariance (q, q) that the parameters give a ``quantity`` (q,) of their correction.

        In the square of its unit; by central differences, one sd of each parameter to both sides.
        """
        at, sd = self.correction, np.sqrt(np.diag(self.fit.cov))
        by_sd = np.array([(quantity(replace(at, theta=at.theta + step))
                           - quantity(replace(at, theta=at.theta - step))) / 2
                          for step in np.diag(sd)])  # (p, q)
        unit = np.where(sd > 0, sd, 1.0)
        return np.asarray(by_sd.T @ (self.fit.cov / np.outer(unit, unit)) @ by_sd)

    def correct(self, at: Conditions) -> FloatArray:
        """Corrected vectors.

        Parameters
        ----------
        at : Conditions
            Of n nominal readings: ``at.vector`` (n, 3), m/s² or rad/s by the data sheet.

        Returns
        -------
        array, shape (n, 3)
            In the same unit.

        Raises
        ------
        FitFailed
            The effects are larger than the readings.
        """
        return self.correction.correct(at)


def noise_widening(fit: Fit) -> float:
    """Root of the noise variance to expect of a fit, over the stated one."""
    return float(np.sqrt(noise_of(fit).expected_variance(fit.bounded_chi2)))


def covariance_with_misfit(fit: Fit) -> FloatArray:
    """Covariance (p, p) of the parameters, SI: ``C + w² (cov - C)`` and what is not averaged.

    Noise has the variance w² to expect of it, and C, the errors that the references have in common,
    are left as they were stated.
    """
    common = fit.common_shift @ fit.common_shift.T
    noise = noise_widening(fit)**2 * (fit.cov - common)
    return np.asarray(common + noise + sum(unaveraged(fit).values()))


def unaveraged(fit: Fit) -> Mapping[str, FloatArray]:
    """Covariances (p, p) by what all poses, or all of a run, have in common, SI, by cause."""
    between = scatter_between_runs(fit)
    return {**({BETWEEN_RUNS: between} if between.any() else {}),
            **{course.cause: course.cov for course in courses_within(fit)}}


def calibrate_triad(fit: Fit, spec: TriadSpec) -> TriadCalibration:
    """Derive the paper's parameters from ``fit``, with honest sds.

    Parameters
    ----------
    fit : Fit
        As :func:`calib.fit.least_squares.solver.fit` gives it.
    spec : TriadSpec
        The data sheet that made the readings nominal.

    Returns
    -------
    TriadCalibration
        With :func:`covariance_with_misfit`.

    Raises
    ------
    Undetermined
        Sds that are no smaller than what they belong to.
    """
    _require_determined(fit, spec)
    cov = covariance_with_misfit(fit)
    return TriadCalibration(
        triad=fit.poses.triad,
        spec=spec,
        fit=replace(fit, cov=cov),
        parameters=triad_parameters(fit.model, fit.theta, cov, spec),
        widening=noise_widening(fit),
        unaveraged=unaveraged(fit),
    )


def _require_determined(fit: Fit, spec: TriadSpec) -> None:
    value = triad_parameters(fit.model, fit.theta, fit.cov, spec)
    stated = fit.poses.reference.magnitude
    lost = undetermined(value, float(stated.max()) if stated.any() else np.nan)
    if not lost:
        return
    variance = np.diag(fit.cov)
    common = fit.common_shift**2  # (p, q)
    share = (common / np.maximum(variance, NO_LENGTH)[:, None]).max(axis=0, initial=0.0)
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

    Returns
    -------
    mapping of cause to array, shape (3, 3)
        Rows are misalignment, bias and scale, columns x, y, z; NaN for what was not fitted. The
        causes are ``NOISE``, the common errors of the reference, and what is not averaged.
    """
    fit = calibration.fit
    reference = fit.poses.reference
    parts = {
        name: np.outer(shift, shift)
        for name, shift, stated in zip(
            reference.common_names, fit.common_shift.T, reference.common.T, strict=True
        )
        if stated.any()  # not an error that was stated as zero
    }
    parts |= calibration.unaveraged
    rest = fit.cov - sum(parts.values(), start=np.zeros_like(fit.cov))
    return {name: parameter_sds(calibration, cov) for name, cov in {NOISE: rest, **parts}.items()}


def parameter_sds(calibration: TriadCalibration, cov: FloatArray) -> FloatArray:
    """Sds of the nine parameters under another covariance of theta.

    Parameters
    ----------
    calibration : TriadCalibration
        Of a model of p parameters.
    cov : array, shape (p, p)

    Returns
    -------
    array, shape (3, 3)
        Rows misalignment (rad), bias (counts), scale (counts per unit); columns x, y, z.
    """
    fit = calibration.fit
    variance = np.diag(triad_parameters(fit.model, fit.theta, cov, calibration.spec).cov)
    return np.asarray(np.sqrt(np.maximum(variance, 0.0)).reshape(3, 3))  # 0 may round below 0
