"""Score and information of everything that could be missing, at one fit.

With r the whitened residual of a fit and X the columns of a candidate that are left when the fitted
model is projected out, an effect of size b leaves ``r = X b + noise`` of unit variance, so that

    u = Xᵀ r  (score),    I = Xᵀ X  (information),    b = I⁻¹ u ± I^(-1/2),    uᵀ I⁻¹ u ~ χ²

where nothing is missing (Rao's score test). Scores and information of sensors that share a size add
up. Combinations of parameters that these poses cannot see have no information.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from calib.diagnosis.hypotheses.listed import candidate_effects
from calib.diagnosis.hypotheses.signature import Projector, effect_columns
from calib.effects.effect import Effect
from calib.effects.needs import unavailable
from calib.fit.least_squares.result import Fit
from calib.poses.imu_log import FloatArray


@dataclass(frozen=True)
class Trial:
    """One candidate at one value of its shape parameter.

    ``shape`` is that value, None where it has none; ``parameters`` (k,) are its parameters' names,
    ``unit`` that of each.
    """

    name: str
    shape: float | None
    parameters: tuple[str, ...]
    unit: str

    @property
    def size(self) -> int:
        """Number k of parameters."""
        return len(self.parameters)


@dataclass(frozen=True, eq=False)
class Evidence:
    """Score and information of all candidates at one fit, K parameters in all.

    Parameters
    ----------
    trials : tuple of Trial
        Their parameters stand one after another.
    score : array, shape (K,)
        Per SI unit of each parameter.
    information : array, shape (K, K)
    chi2 : float
        Of the fit.
    dof, noise_dof : float
        Its degrees of freedom, and those behind the sds.
    """

    trials: tuple[Trial, ...]
    score: FloatArray
    information: FloatArray
    chi2: float
    dof: float
    noise_dof: float


def trials_of(effect: Effect, triad: str) -> list[Trial]:
    """The trials of an effect: one, or one at each start of its shape parameter."""
    shapes: tuple[float | None, ...] = effect.shape.starts if effect.shape else (None,)
    return [Trial(effect.name, shape, effect.parameters, effect.unit_for(triad))
            for shape in shapes]


def evidence_of(
    fit: Fit, user_effects: Sequence[Effect] = (), covariates: Sequence[str] | None = None
) -> Evidence:
    """The evidence of every candidate at ``fit``.

    Parameters
    ----------
    fit : Fit
    user_effects : sequence of Effect
        User-defined effects.
    covariates : sequence of str, optional
        Logged columns that may cause an error.

    Returns
    -------
    Evidence
        Of what the poses can evaluate. Effects that a length shows in their square only are left
        out: their sizes do not add up.
    """
    projector = Projector(fit)
    trials: list[Trial] = []
    visible: list[FloatArray] = [np.zeros((len(projector.residual), 0))]
    for effect in candidate_effects(fit, user_effects, covariates):
        if effect.in_square or unavailable(effect, fit.equations.at_reading) is not None:
            continue
        for trial in trials_of(effect, fit.poses.triad):
            columns = effect_columns(fit, effect, trial.shape)
            signature = projector.signature(effect.name, columns)
            full = np.zeros((len(projector.residual), columns.shape[1]))
            full[: len(columns)] = columns * projector.root[: len(columns), None]
            visible.append(signature.basis @ (signature.basis.T @ full))
            trials.append(trial)
    x = np.hstack(visible)
    return Evidence(
        trials=tuple(trials),
        score=x.T @ projector.residual,
        information=x.T @ x,
        chi2=projector.chi2,
        dof=float(projector.dof),
        noise_dof=fit.poses.noise_dof,
    )
