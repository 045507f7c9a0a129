"""A calibrated triad: the fit, what it says in the paper's parameters, and how to apply it."""

from dataclasses import dataclass, replace

import numpy as np
from scipy.special import fdtrc

from calib.fit.correction import Correction
from calib.fit.parameters import TriadParameters, triad_parameters
from calib.fit.result import Fit
from calib.poses.conditions import Conditions
from calib.poses.data_sheet import TriadSpec
from calib.poses.imu_log import FloatArray, Triad

MISFIT_P_VALUE = 0.01
"""Below it the stated sds do not explain the residual, and the parameters' sds are widened."""


def misfit_p_value(fit: Fit) -> float:
    """Probability of a residual this large when the model and the stated sds are right.

    The sds come from the same samples with ``noise_dof`` degrees of freedom, so chi-square over
    its degrees of freedom is an F ratio.
    """
    return float(fdtrc(fit.dof, fit.poses.noise_dof, fit.chi2 / fit.dof))


@dataclass(frozen=True, eq=False)
class TriadCalibration:
    """One calibrated triad.

    ``parameters`` are those of Angrisano et al. eq. (3). Where the residual is larger than the
    stated sds explain (``p_value`` under 0.01), all sds are widened by ``widening``, the square
    root of chi-square over its degrees of freedom.
    """

    triad: Triad
    spec: TriadSpec
    fit: Fit
    parameters: TriadParameters
    widening: float

    @property
    def p_value(self) -> float:
        """See :func:`misfit_p_value`."""
        return misfit_p_value(self.fit)

    def effect_values(self) -> dict[str, tuple[FloatArray, FloatArray]]:
        """Value and sd of each added effect's parameters, the shape parameter last.

        A parameter that these poses see only in combination with others has no sd of its own (NaN).
        """
        found = {}
        sd = np.where(self.fit.determined, np.sqrt(np.diag(self.fit.cov)), np.nan)
        for effect in self.fit.model.effects:
            if effect.acts_on == "reading":
                continue
            where = self.fit.model.slices()[effect.name]
            value, value_sd = self.fit.theta[where], sd[where]
            if effect.shape is not None:
                value = np.append(value, self.fit.shapes[effect.name])
                value_sd = np.append(value_sd, self.fit.shape_sd[effect.name])
            found[effect.name] = (value, value_sd)
        return found

    @property
    def correction(self) -> Correction:
        """What corrects readings, without the fit it came from."""
        return Correction(self.spec, self.fit.model, self.fit.theta, self.fit.shapes)

    def correct(self, at: Conditions) -> FloatArray:
        """Corrected vectors for nominal readings ``at.vector`` and their conditions, (n, 3)."""
        return self.correction.correct(at)


def calibrate_triad(fit: Fit, spec: TriadSpec) -> TriadCalibration:
    """Read the paper's parameters off ``fit``, with honest sds."""
    misfit = misfit_p_value(fit) < MISFIT_P_VALUE
    widening = float(np.sqrt(fit.chi2 / fit.dof)) if misfit else 1.0
    widened = replace(fit, cov=fit.cov * widening**2)
    return TriadCalibration(
        triad=fit.poses.triad,
        spec=spec,
        fit=widened,
        parameters=triad_parameters(fit.model, fit.theta, widened.cov, spec),
        widening=widening,
    )
