"""Sets of effects added to a fit and everything refitted jointly, nonlinearly, from where it stood.

Scores before the refit also accuse innocent effects, the more so the stronger the missing one is:
the columns are linearised at a fit that the missing effect has biased. Shape parameters are fitted
with all the others. The weights of a robust fit stay as they are.
"""

from collections.abc import Collection, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.special import erfcx, ndtr

from calib.diagnosis.constants import CONSTANTS
from calib.diagnosis.hypotheses.signature import Projector, positions_of
from calib.effects.effect import Effect
from calib.effects.typical import largest_for
from calib.errors import CalibrationError
from calib.fit.least_squares.result import MISFIT_P_VALUE, Fit, shapes_at_bound
from calib.fit.least_squares.solver import extend
from calib.fit.validation.leave_one_out import left_out_residual
from calib.poses.imu_log import FloatArray, Triad


@dataclass(frozen=True, eq=False)
class Refit:
    """A base fit with more effects, everything refitted.

    Attributes
    ----------
    names : tuple of str
        What was added.
    fit : Fit
        The joint fit.
    p_value : float
        Whether it explains the rows.
    log_shape_width : float
        Log share of their range that the data leave to its shape parameters.
    """

    names: tuple[str, ...]
    fit: Fit
    p_value: float
    log_shape_width: float = 0.0

    @property
    def explains(self) -> bool:
        """Whether the poses' own noise explains the residual."""
        return self.p_value >= MISFIT_P_VALUE

    def signal(self, names: Collection[str], projector: Projector) -> FloatArray:
        """What the effects ``names`` of it explain, whitened, the model projected out, (r,)."""
        where = positions_of(self.fit, [name for name in self.names if name in names])
        return projector(self.fit.rows.jacobian[:, where] @ self.fit.theta[where])


def explained(base: Fit, joint: Refit | None, noise_is_known: bool) -> tuple[float, bool]:
    """Part of the misfit of ``base`` that a refit takes, and whether noise explains the rest.

    Of noise that is not known, part of the whole residual.
    """
    if joint is None:
        return 0.0, False
    if not noise_is_known:
        return 1 - joint.fit.chi2 / base.chi2, joint.explains
    rest, whole = (float(each.weight @ each.rows.residual**2) - each.dof
                   for each in (joint.fit, base))  # weighted as a robust loss has them
    return max(1 - max(rest, 0.0) / whole, 0.0) if whole > 0 else 0.0, joint.explains


def linear_loo_rms(fit: Fit) -> float:
    """Leave-one-out error, SI, with the model linear about its solution: for comparisons only."""
    root = np.sqrt(fit.weight)
    equations = fit.equations
    out = left_out_residual(
        fit.rows.residual * root, fit.rows.jacobian * root[:, None], equations.row_pose
    )
    return float(np.sqrt(np.mean((equations.row_sd * out) ** 2)))


def refit(base: Fit, effects: Sequence[Effect]) -> Refit | None:
    """``effects`` added to a fit and everything refitted.

    Parameters
    ----------
    base : Fit
    effects : sequence of Effect
        A shape parameter begins at the first of its effect's starts.

    Returns
    -------
    Refit or None
        None where the poses cannot carry the effects.
    """
    try:
        joint = extend(base, effects)
    except (CalibrationError, np.linalg.LinAlgError):
        return None
    if joint.dof < CONSTANTS.fewest_dof:
        return None
    names = tuple(effect.name for effect in effects)
    return Refit(names, joint, joint.bounded_p_value, _log_shape_width(joint, effects))


def _log_shape_width(joint: Fit, effects: Sequence[Effect]) -> float:
    """Log share of their range that the data leave to the shape parameters of ``effects``.

    The range is that of the logarithm, in which the density is normal about the fitted value; at a
    bound, where the minimum lies beyond, it is the tail on this side.
    """
    names = [effect.name for effect in effects if effect.name in joint.log_shape_sd]
    if not names:
        return 0.0
    at_bound = shapes_at_bound(joint.model, joint.shapes)
    gradient = _gradient(joint, names) if at_bound & {*names} else {}
    log_share = 0.0
    for effect in effects:
        if not np.isfinite(joint.log_shape_sd.get(effect.name, np.nan)):
            continue  # a shape without influence on the rows keeps all of its range
        sd = joint.log_shape_sd[effect.name]
        assert effect.shape is not None
        low, high = np.log(effect.shape.bounds) - np.log(joint.shapes[effect.name])
        if effect.name in at_bound:
            width = np.sqrt(np.pi / 2) * sd * erfcx(abs(gradient[effect.name]) * sd / np.sqrt(2))
        else:
            width = np.sqrt(2 * np.pi) * sd * (ndtr(high / sd) - ndtr(low / sd))
        log_share += float(np.log(min(1.0, width / (high - low))))
    return log_share


def _gradient(joint: Fit, names: Sequence[str]) -> dict[str, float]:
    """Derivative of half of chi-square by the logarithms of the shapes of these effects."""
    slope = joint.at.shape_derivatives(joint.equations, names).slope
    return dict(zip(names, map(float, slope.T @ (joint.weight * joint.rows.residual)),
                    strict=True))


def largest_of(effect: Effect, triad: Triad) -> float:
    """Upper bound of the parameters of an effect in a part, SI; infinite without any.

    Nothing bounds what an evening or a bench does to a sensor, nor the unit of a logged column.
    """
    if effect.largest is not None:
        return effect.largest
    of_the_part = effect.belongs_to == "sensor" and not effect.drawn and not effect.logged
    return largest_for(triad, effect.page.typical.values()) if of_the_part else np.inf


def beyond_nature(joint: Refit) -> dict[str, float]:
    """Ratio of each effect of ``joint`` to the largest size of a sensor, where it exceeds that."""
    fit, slices = joint.fit, joint.fit.model.slices()
    times = {}
    for effect in fit.model.effects:
        if effect.name not in joint.names:
            continue
        where = slices[effect.name]
        times[effect.name] = _times(fit.theta[where], np.sqrt(np.diag(fit.cov)[where]),
                                    largest_of(effect, fit.poses.triad))
    return {name: beyond for name, beyond in times.items() if beyond}


def _times(size: FloatArray, sd: FloatArray, largest: float) -> float:
    """The size over the ``largest``; 0 where its sd allows for that."""
    if not (np.abs(size) - CONSTANTS.limit_sd * sd > largest).any():
        return 0.0
    return float(np.abs(size).max() / largest)
