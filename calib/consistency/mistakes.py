"""Search for the common mistake in the files of a run that explains a misfit no sensor can have.

Each mistake is undone in turn and the nine parameters are fitted again. With d degrees of freedom
one explains the misfit better than the session as it stands by the log likelihood ratio
``d/2 ln(chi2_as_it_stands / chi2_undone)``, the noise's scale free, no chi-square below d; it is
named where this exceeds the logarithm of the number of trials over the probability of a false alarm
and where it leaves less than a hundredth of the misfit. Once a mistake in some poses of a run is
undone, these agree with the others as well as the others agree with each other, by an F ratio;
otherwise the mistake is another one, and the verdict names the odd poses. An exchange of their axes
must also explain more than their absence does. Poses of m attitudes give m equations, which one of
many changes meets by chance: the misfits that all changes of these poses leave are drawn from a
chi-square of m degrees of freedom whose size is their median, and the least of them must be smaller
than chance makes it.

No change of some poses by one matrix leaves less than these and the others leave each by
themselves. Where the quadrics of the two parts leave more than a named mistake may, none is tried.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from scipy.special import chdtr, chdtri, fdtrc

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
from calib.effects.catalogue import BASE
from calib.errors import CalibrationError, Contradiction, Remedy
from calib.fit.least_squares.result import MISFIT_P_VALUE, Fit
from calib.fit.least_squares.solver import fit, fit_sets
from calib.fit.least_squares.stack_fits import WEIGHING
from calib.fit.model import Model
from calib.fit.validation.odd_poses import left_over, odd_poses, quadric
from calib.poses.attitudes import direction_name
from calib.poses.checks.frozen import CERTAIN_SD, FALSE_ALARM
from calib.poses.imu_log import AXES, BoolArray, FloatArray
from calib.poses.pose_set import PoseSet

LEFT_OVER = 0.01
"""Share of the misfit above its degrees of freedom that a named mistake leaves at most. A
judgement: what a sensor's effects leave beside an exchanged axis or a wrong range."""

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
        return
    mistakes: list[Mistake] = [
        *block_mistakes(poses), *rate_mistakes(poses, base), *exchanged_rates(poses)]
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
            f"the model. Record them again.", Remedy("exclude_pose")
        )


def _explanation(mistakes: Sequence[Mistake], poses: PoseSet, base: Model) -> str | None:
    """The mistake that explains the misfit and what it leaves, in words; None where none does."""
    before = _chi2(poses, base)
    whole = float(left_over(*quadric(poses))[0][0]) if before is None else before[0]
    possible = possible_mistakes(mistakes, poses, whole)
    tried = [
        (chi2, dof, possible[i])
        for fits in fit_sets([mistake.undone for mistake in possible], base, precision=WEIGHING)
        if fits.fitted
        for i, chi2, dof in zip(fits.index, fits.fitted.chi2, fits.fitted.dof, strict=True)
    ]
    if not tried:
        return None
    chi2, dof, mistake = min(tried, key=lambda one: one[0])
    gained = dof / 2 * np.log(max(whole, dof) / max(chi2, dof))
    if gained < np.log(len(mistakes) / FALSE_ALARM) or chi2 - dof > LEFT_OVER * (whole - dof):
        return None
    if mistake.of is not None:
        others = _chi2(poses.take(~mistake.of), base)
        rivals = [one for one, _, rival in tried if np.array_equal(rival.of, mistake.of)]
        if others is not None and others[1] > 0 and not (
                _agree(mistake.undone, mistake.of, (chi2, dof), others)
                and chance(np.array(rivals) - others[0], _attitudes(mistake)) < MISFIT_P_VALUE):
            return None
    return f"{mistake.words} (chi²/dof {chi2 / dof:.3g} instead of {whole / dof:.3g})"


def possible_mistakes(
    mistakes: Sequence[Mistake], poses: PoseSet, whole: float
) -> Sequence[Mistake]:
    """The mistakes of which no part of the poses by itself tells that they leave too much.

    ``whole`` is the chi-square of the poses as they stand.
    """
    turning = ~poses.reference.is_null
    rows = len(poses) + 2 * int(poses.reference.is_null.sum())
    blocks = {one.mapped.tobytes(): one.mapped for one in mistakes if one.mapped is not None}
    part = np.array([*blocks.values()], dtype=bool).reshape(-1, len(poses))[:, turning]
    columns, target = quadric(poses)
    # What another range or unit multiplies the noise by, it multiplies a far larger misfit by.
    least = left_over(columns, target, part)[0] + left_over(columns, target, ~part)[0]
    out = {key for key, one in zip(blocks, least, strict=True)
           if one - rows > LEFT_OVER * (whole - rows)}
    return [one for one in mistakes if one.mapped is None or one.mapped.tobytes() not in out]


def chance(misfits: FloatArray, attitudes: int) -> float:
    """Largest probability that the least of ``misfits`` is as small by chance; 0 of one alone.

    Parameters
    ----------
    misfits : array
        Chi-square that each change of the same poses leaves above the fit without them.
    attitudes : int
        In which these poses are.
    """
    if len(misfits) == 1:
        return 0.0
    size = float(np.median(misfits)) / chdtri(attitudes, 0.5)
    return len(misfits) * float(chdtr(attitudes, max(misfits.min(), attitudes) / size))


def _attitudes(mistake: Mistake) -> int:
    """Number of attitudes of the affected poses."""
    reading = mistake.undone.reading[mistake.of]
    return len({direction_name(one, mistake.undone.triad) for one in reading})


def _agree(
    poses: PoseSet, member: BoolArray, whole: tuple[float, int], others: tuple[float, int]
) -> bool:
    """Whether the poses ``member`` agree with the others as well as these with each other.

    ``whole`` is the chi-square of all and its degrees of freedom, ``others`` that of the others.
    """
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
