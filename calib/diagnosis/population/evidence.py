"""Score and information of everything that could be missing, at one fit.

With r the whitened residual of a fit and X the columns of a candidate that are left when the fitted
model is projected out, an effect of size b leaves ``r = X b + noise`` of unit variance, so that

    u = Xᵀ r  (score),    I = Xᵀ X  (information),    b = I⁻¹ u ± I^(-1/2),    uᵀ I⁻¹ u ~ χ²

where nothing is missing (Rao's score test). Scores and information of sensors that share a size add
up. Combinations of parameters that these poses cannot see have no information.
"""

from collections.abc import Collection, Sequence
from dataclasses import dataclass

import numpy as np

from calib.diagnosis.hypotheses.listed import candidate_effects
from calib.diagnosis.hypotheses.signature import effect_columns
from calib.effects.effect import Effect
from calib.fit.least_squares.identifiability import VISIBLE_SHARE
from calib.fit.least_squares.result import Fit
from calib.fit.linear import NORM_FLOOR, orthonormal_bases
from calib.numbers import NO_LENGTH
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
    """Score and information of all candidates, K parameters in all, at one fit or at S.

    Parameters
    ----------
    trials : tuple of Trial
        Their parameters stand one after another.
    score : array, shape (..., K)
        Per SI unit of each parameter; zero where the poses cannot evaluate or see it.
    information : array, shape (..., K, K)
    chi2, dof, noise_dof : array, shape (...,)
        Of the fit; its degrees of freedom, and those behind the sds.
    """

    trials: tuple[Trial, ...]
    score: FloatArray
    information: FloatArray
    chi2: FloatArray
    dof: FloatArray
    noise_dof: FloatArray


def trials_of(effect: Effect, triad: str) -> list[Trial]:
    """The trials of an effect: one, or one at each start of its shape parameter."""
    shapes: tuple[float | None, ...] = effect.shape.starts if effect.shape else (None,)
    return [Trial(effect.name, shape, effect.parameters, effect.unit_for(triad))
            for shape in shapes]


def evidence_of(
    fit: Fit, user_effects: Sequence[Effect] = (),
    covariates: Sequence[str] | None = None, names: Collection[str] = (),
) -> Evidence:
    """The evidence of every candidate at ``fit``, or at each of many.

    Parameters
    ----------
    fit : Fit
    user_effects : sequence of Effect
        User-defined effects.
    covariates : sequence of str, optional
        Logged columns that may cause an error.
    names : collection of str, optional
        The candidates that are wanted; by default all.

    Returns
    -------
    Evidence
        Of what the poses can evaluate. Effects that a length shows in their square only are left
        out: their sizes do not add up.
    """
    root = np.sqrt(fit.weight)
    basis = orthonormal_bases(fit.rows.jacobian * root[..., None])
    residual = (fit.rows.residual * root)[..., None]
    residual = residual - basis @ (basis.swapaxes(-1, -2) @ residual)
    trials: list[Trial] = []
    visible: list[FloatArray] = [np.zeros((*root.shape, 0))]
    for effect in candidate_effects(fit.model, fit.poses, user_effects, covariates):
        if effect.in_square or (names and effect.name not in names):
            continue
        for trial in trials_of(effect, fit.poses.triad):
            columns = effect_columns(fit, effect, trial.shape)
            complete = np.asarray(np.isfinite(columns).all(axis=(-2, -1)))
            if complete.any():
                known = np.where(complete[..., None, None], columns, 0.0)
                visible.append(_visible(known, basis, root))
                trials.append(trial)
    x = np.concatenate(visible, axis=-1)
    transposed = x.swapaxes(-1, -2)
    return Evidence(
        trials=tuple(trials),
        score=(transposed @ residual)[..., 0],
        information=transposed @ x,
        chi2=(residual[..., 0] ** 2).sum(axis=-1),
        dof=np.asarray(fit.dof, float),
        noise_dof=np.asarray(fit.noise_dof, float),
    )


def _visible(columns: FloatArray, basis: FloatArray, root: FloatArray) -> FloatArray:
    """Part of whitened columns (..., d, k) visible beside the model, (..., r, k).

    ``basis`` (..., r, m) is that of the model, ``root`` (..., r) the root of the rows' weights.
    """
    full = np.zeros((*root.shape, columns.shape[-1]))
    full[..., : columns.shape[-2], :] = columns
    full *= root[..., None]
    norm = np.sqrt((full**2).sum(axis=-2))
    used = norm > NORM_FLOOR * np.maximum(norm.max(axis=-1, keepdims=True), NO_LENGTH)
    norm = np.where(used, norm, 1.0)[..., None, :]
    unit = np.where(used[..., None, :], full / norm, 0.0)
    rest = unit - basis @ (basis.swapaxes(-1, -2) @ unit)
    values, vectors = np.linalg.eigh(rest.swapaxes(-1, -2) @ rest)
    seen = vectors * (values > VISIBLE_SHARE**2)[..., None, :]
    return np.asarray(rest @ (seen @ seen.swapaxes(-1, -2)) * norm * used[..., None, :])
