"""Which common mistake in the files of a run explains a misfit that is no sensor's.

Each mistake is undone in turn and the nine parameters are fitted again. With d degrees of freedom
one explains the misfit better than the session as it stands by the log likelihood ratio
``d/2 ln(chi2_as_it_stands / chi2_undone)``, the noise's scale free, no chi-square below d; it is
named where this exceeds the logarithm of the number of looks over the probability of a false alarm
and where it leaves less than a hundredth of the misfit. A mistake in some poses of one run leaves
them, once undone, as near to the others as these are to each other, by an F ratio; else it is
another one, and the verdict says which poses are odd.
"""

from collections.abc import Sequence

import numpy as np
from scipy.special import fdtrc

from calib.consistency.common_mistakes import (
    CHANGED_AXES,
    CHANGES,
    Mistake,
    block_mistakes,
    blocks,
    exchanged_rates,
    odd_mistakes,
    rate_mistakes,
)
from calib.consistency.means_alone import by_means
from calib.consistency.odd_poses import odd_poses
from calib.consistency.quadric import left_over, quadric
from calib.effects.catalogue import BASE
from calib.errors import CalibrationError, Contradiction
from calib.fit.least_squares.result import MISFIT_P_VALUE, Fit
from calib.fit.least_squares.solver import fit, fit_sets
from calib.fit.model import Model
from calib.poses.checks.frozen import FALSE_ALARM
from calib.poses.imu_log import BoolArray
from calib.poses.pose_set import PoseSet

LEFT_OVER = 0.01
"""Share of the misfit above its degrees of freedom that a named mistake leaves at most. A
judgement: what a sensor's effects leave of an exchanged axis or a wrong range."""


def require_no_mistake(poses: PoseSet, model: Model, fitted: Fit | None) -> None:
    """Refuse poses whose misfit a common mistake in the files explains.

    Parameters
    ----------
    poses : PoseSet
        All runs of the triad.
    model : Model
        The one that was fitted.
    fitted : Fit or None
        None where there was no fit.

    Raises
    ------
    Contradiction
        Naming the run or the poses and the mistake.
    """
    poses, fitted = by_means(poses, model, fitted)
    base = Model(tuple(effect for effect in model.effects if effect.name in BASE))
    if set(base.names) != set(BASE):
        return
    looks = max(1, len(blocks(poses)) * len(CHANGES.get(poses.triad, CHANGED_AXES)))
    if fitted is not None and fitted.p_value > MISFIT_P_VALUE / looks:
        return  # without a copy of the poses for every look
    mistakes = [*block_mistakes(poses), *rate_mistakes(poses, base), *exchanged_rates(poses)]
    if fitted is not None and fitted.p_value > MISFIT_P_VALUE / len(mistakes):
        return
    odd = odd_poses(poses)
    if odd is not None:
        mistakes += odd_mistakes(poses, odd)
    if (words := _explanation(mistakes, poses, base)) is not None:
        raise Contradiction(
            f"{poses.triad}: the poses contradict each other, and they agree once one mistake is "
            f"undone: {words}. Check the files and the configuration of these poses."
        )
    if odd is not None and fitted is None and _chi2(poses.take(~odd), base) is not None:
        labels = [label for label, is_odd in zip(poses.label, odd, strict=True) if is_odd]
        raise Contradiction(
            f"{poses.triad}: the readings of {' and '.join(labels)} contradict those of all other "
            f"poses, and by no exchange of axes, range or unit. Without them the others determine "
            f"the model. Record them again, or exclude them."
        )


def _explanation(mistakes: Sequence[Mistake], poses: PoseSet, base: Model) -> str | None:
    """The mistake that explains the misfit and what it leaves, in words; None where none does."""
    before = _chi2(poses, base)
    whole = float(left_over(*quadric(poses))[0][0]) if before is None else before[0]
    tried = [
        (chi2, dof, mistakes[i])
        for fits in fit_sets([mistake.undone for mistake in mistakes], base) if fits.fitted
        for i, chi2, dof in zip(fits.index, fits.fitted.chi2, fits.fitted.dof, strict=True)
    ]
    if not tried:
        return None
    chi2, dof, mistake = min(tried, key=lambda one: one[0])
    gained = dof / 2 * np.log(max(whole, dof) / max(chi2, dof))
    if gained < np.log(len(mistakes) / FALSE_ALARM) or chi2 - dof > LEFT_OVER * (whole - dof):
        return None
    if mistake.of is not None and not _agree(mistake.undone, mistake.of, base, (chi2, dof)):
        return None
    return f"{mistake.words} (chi²/dof {chi2 / dof:.3g} instead of {whole / dof:.3g})"


def _agree(
    poses: PoseSet, member: BoolArray, model: Model, whole: tuple[float, int]
) -> bool:
    """Whether the poses ``member`` fit to the others as these do to each other.

    ``whole`` is the chi-square of all and its degrees of freedom. True where too few are left.
    """
    others = _chi2(poses.take(~member), model)
    if others is None or others[1] < 1:
        return True
    more = whole[1] - others[1]
    ratio = max(whole[0] - others[0], 0.0) / more / max(others[0] / others[1], 1.0)
    return float(fdtrc(more, min(others[1], poses.noise_dof), ratio)) > FALSE_ALARM


def _chi2(poses: PoseSet, model: Model) -> tuple[float, int] | None:
    """Chi-square of the fit and its degrees of freedom; None where there is no fit."""
    try:
        fitted = fit(poses, model)
    except CalibrationError:
        return None
    return fitted.chi2, fitted.dof
