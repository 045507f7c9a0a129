"""Search for the common mistake in the files of a run that explains a misfit no sensor can have.

Each mistake is undone in turn and the nine parameters are fitted again. With d degrees of freedom
one explains the misfit better than the session as it stands by the log likelihood ratio
``d/2 ln(chi2_as_it_stands / chi2_undone)``, the noise's scale free, no chi-square below d; it is
named where this exceeds the logarithm of the number of trials over the probability of a false alarm
and where it leaves less than a hundredth of the misfit. Once a mistake in some poses of a run is
undone, these agree with the others as well as the others agree with each other, by an F ratio;
otherwise the mistake is another one, and the verdict names the odd poses.

The odd poses are found together, because one can mask the next: if three poses are wrong and one
is left out, the other two still spoil the fit. Every set of up to three is left out, and the least
misfit of the rest under any parameters shows which set it is, by the same ratio.
"""

from collections.abc import Sequence
from dataclasses import replace
from itertools import combinations

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
    runs_by_name,
)
from calib.consistency.quadric import left_over, quadric
from calib.effects.catalogue import BASE
from calib.errors import CalibrationError, Contradiction, Remedy
from calib.fit.least_squares.result import MISFIT_P_VALUE, Fit
from calib.fit.least_squares.solver import fit, fit_sets
from calib.fit.model import Model
from calib.poses.checks.frozen import CERTAIN_SD, FALSE_ALARM
from calib.poses.imu_log import AXES, BoolArray
from calib.poses.pose_set import PoseSet

LEFT_OVER = 0.01
"""Share of the misfit above its degrees of freedom that a named mistake leaves at most. A
judgement: what a sensor's effects leave beside an exchanged axis or a wrong range."""

MOST_ODD = 3  #: poses; derived: what a set of 18 can lose before a direction is missing
MOST_SETS = 1000  #: sets of poses left out; a limit of time

OTHER_GAIN = 0.01
"""Largest relative difference between the gains of a gyro in two runs. Fact: 300 ppm/°C of data
sheets over 30 °C."""


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
        return  # without a copy of the poses for each trial
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
            f"the model. Record them again, or exclude them.", Remedy("exclude_pose")
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
    """Whether the poses ``member`` agree with the others as well as these with each other.

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


def odd_poses(poses: PoseSet) -> BoolArray | None:
    """The poses that contradict all others, (n,); None where no small set of poses does."""
    columns, target = quadric(poses)
    n, unknowns = columns.shape
    kept = np.ones((1, n), dtype=bool)
    for size in range(1, min(MOST_ODD, n - unknowns - 1) + 1):
        out = np.array([*combinations(range(n), size)])
        if len(kept) - 1 + len(out) > MOST_SETS:
            break
        kept = np.concatenate([kept, ~(out[..., None] == np.arange(n)).any(axis=1)])
    if len(kept) == 1:
        return None
    chi2, dof = left_over(columns, target, kept)
    dof = np.maximum(dof[1:], 1)
    gained = dof / 2 * np.log(np.maximum(chi2[0], dof) / np.maximum(chi2[1:], dof))
    best = int(np.argmax(gained))
    if gained[best] < np.log(len(gained) / FALSE_ALARM):
        return None
    odd = np.zeros(len(poses), dtype=bool)
    odd[~poses.reference.is_null] = ~kept[1 + best]
    return odd


def require_one_sensor(poses: PoseSet, model: Model, fitted: Fit) -> None:
    """Refuse a run that only another sensor, or another range, can have logged.

    Its poses agree with each other and those of the other runs with each other, each by gains of
    their own that differ by more than any sensor's within a session.

    Raises
    ------
    Contradiction
        Naming the run.
    """
    poses, of_means = by_means(poses, model, fitted)
    base = Model(tuple(effect for effect in model.effects if effect.name in BASE))
    runs = runs_by_name(poses)
    if (of_means is None or len(runs) < 2 or set(base.names) != set(BASE)
            or of_means.p_value > MISFIT_P_VALUE / len(runs)):
        return
    for name, member in runs.items():
        try:
            alone, others = fit(poses.take(member), base), fit(poses.take(~member), base)
        except CalibrationError:
            continue
        scale = alone.model.slices()["scale"]
        apart = np.abs((1 - alone.theta[scale]) / (1 - others.theta[scale]) - 1)
        sd = np.sqrt(np.diag(alone.cov)[scale] + np.diag(others.cov)[scale])
        agree = min(alone.p_value, others.p_value) > MISFIT_P_VALUE
        if agree and (apart > OTHER_GAIN + CERTAIN_SD * sd).any():
            raise Contradiction(
                f"{poses.triad}: the poses of {name} agree with each other, and so do all others, "
                f"but their gains differ by {100 * apart.max():.2g} % ({AXES[int(apart.argmax())]} "
                f"the most). No sensor changes so much within a session: are these the logs of "
                f"another sensor or range, or is the rate wrong? Check the files and the rate of "
                f"this run."
            )


def by_means(poses: PoseSet, model: Model, fitted: Fit | None) -> tuple[PoseSet, Fit | None]:
    """The means of ``poses`` without the waves of a leaning plate, and their fit for ``fitted``.

    Mistakes in files show in the means.

    Parameters
    ----------
    poses : PoseSet
    model : Model
    fitted : Fit or None
        With the waves; None where there was no fit.

    Returns
    -------
    poses : PoseSet
        Those given where the plate is level.
    fitted : Fit or None
        None where the means alone do not determine the model.
    """
    if poses.ring is None:
        return poses, fitted
    means = replace(poses, ring=None)
    try:
        return means, None if fitted is None else fit(means, model)
    except CalibrationError:
        return means, None
