"""Which common mistake in the files of a run explains a misfit that is no sensor's.

Each mistake is undone in turn and the nine parameters are fitted again. With d degrees of freedom
one explains the misfit better than the session as it stands by the log likelihood ratio
``d/2 ln(chi2_as_it_stands / chi2_undone)``, the noise's scale free, no chi-square below d; it is
named where this exceeds the logarithm of the number of looks over the probability of a false alarm
and where it leaves less than a hundredth of the misfit. A mistake in some poses of one run leaves
them, once undone, as near to the others as these are to each other, by an F ratio; else it is
another one, and the verdict says which poses are odd.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np
from scipy.special import fdtrc

from calib.consistency.force import FACTORS
from calib.consistency.means_alone import by_means
from calib.consistency.quadric import least_chi2
from calib.consistency.signed_axes import SIGNED_PERMUTATIONS, permutation_words
from calib.effects.catalogue import BASE
from calib.errors import CalibrationError, Contradiction
from calib.fit.least_squares.result import MISFIT_P_VALUE, Fit
from calib.fit.least_squares.solver import fit, fit_sets
from calib.fit.model import Model, stack_columns
from calib.fit.validation.leave_one_out import left_out_residual
from calib.numbers import NO_LENGTH, RPM
from calib.poses.checks.frozen import FALSE_ALARM
from calib.poses.conditions import Conditions
from calib.poses.imu_log import BoolArray, FloatArray, Triad
from calib.poses.pose_set import PoseSet

LEFT_OVER = 0.01
"""Share of the misfit above its degrees of freedom that a named mistake leaves at most. A
judgement: what a sensor's effects leave of an exchanged axis or a wrong range."""

SAME_RATE = 0.02
"""Relative: two plate rates closer than this are no mistake of one for the other. Fact: drives keep
their speed to 2 %, and the speeds of records differ by 35 % and more."""

BOUND_SLACK = 16.0
"""Times the chi-square that a mistake may leave: the bound holds to first order, and for gains that
are the data sheet's within a third. Tuned on mistakes in whole sessions: at 2 exchanged axes of a
run are passed over, at 4, 8, 16 and 32 nothing is. A limit of time."""

FEWEST_OF_BLOCK = 3  #: poses; derived: fewer are bad poses, which have a verdict
WORST_POSES = 2  #: tried one by one: a limit of time

CHANGES: Mapping[Triad, tuple[tuple[FloatArray, str], ...]] = {
    triad: (
        *((matrix.T, permutation_words(matrix)) for matrix in SIGNED_PERMUTATIONS[1:]),
        *((factor * np.eye(3), f"the readings are {words}") for factor, words in factors.items()),
    )
    for triad, factors in FACTORS.items()
}
"""What undoes exchanged or mirrored axes, a wrong range or unit, (3, 3); the mistake in words."""


@dataclass(frozen=True, eq=False)
class Mistake:
    """One mistake: the poses without it, and what it is, in words.

    ``of`` are the poses that it is in, where they are not the whole of a run, (n,).
    """

    undone: PoseSet
    words: str
    of: BoolArray | None = None


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
    looks = max(1, len(_blocks(poses)) * len(CHANGES[poses.triad]))
    if fitted is not None and fitted.p_value > MISFIT_P_VALUE / looks:
        return  # without a copy of the poses for every look
    mistakes = [*_of_blocks(poses), *_of_rates(poses, base), *_exchanged_rates(poses)]
    if fitted is not None and fitted.p_value > MISFIT_P_VALUE / len(mistakes):
        return
    mistakes += _of_worst_poses(poses, fitted)
    before = _chi2(poses, base)
    whole = float(least_chi2([poses])[0]) if before is None else before[0]
    hopeful = _hopeful(mistakes, whole, len(poses))
    tried = [
        (chi2, dof, hopeful[i])
        for fits in fit_sets([mistake.undone for mistake in hopeful], base) if fits.fitted
        for i, chi2, dof in zip(fits.index, fits.fitted.chi2, fits.fitted.dof, strict=True)
    ]
    if not tried:
        return
    chi2, dof, mistake = min(tried, key=lambda one: one[0])
    gained = dof / 2 * np.log(max(whole, dof) / max(chi2, dof))
    if gained < np.log(len(mistakes) / FALSE_ALARM) or chi2 - dof > LEFT_OVER * (whole - dof):
        return
    if mistake.of is not None and not _agree(mistake.undone, mistake.of, base, (chi2, dof)):
        return
    raise Contradiction(
        f"{poses.triad}: the poses contradict each other, and they agree once one mistake is "
        f"undone: {mistake.words} (chi²/dof {chi2 / dof:.3g} instead of "
        f"{whole / dof:.3g}). Check the files and the configuration of these poses."
    )


def _hopeful(mistakes: Sequence[Mistake], whole: float, rows: int) -> list[Mistake]:
    """Mistakes that can leave little enough of the misfit to be named; fitting all would take long.

    ``whole`` is the chi-square as the session stands, of ``rows``.
    """
    enough = LEFT_OVER * whole + rows
    least = least_chi2([mistake.undone for mistake in mistakes])
    return [mistake for mistake, chi2 in zip(mistakes, least, strict=True)
            if chi2 < BOUND_SLACK * enough]


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


def runs_by_name(poses: PoseSet) -> dict[str, BoolArray]:
    """The poses of each run by its name; of runs at one setting by their first pose, too."""
    runs = np.array(poses.run)
    begins = np.flatnonzero(np.r_[True, runs[1:] != runs[:-1]])
    number = np.cumsum(np.r_[True, runs[1:] != runs[:-1]]) - 1
    often = {name for name in poses.run if (runs[begins] == name).sum() > 1}
    return {
        f"run '{runs[k]}'" + (f" from {poses.label[k]} on" if runs[k] in often else ""): number == i
        for i, k in enumerate(begins)
    }


def _blocks(poses: PoseSet) -> dict[str, BoolArray]:
    """One run among several, each in words; of one run alone, what follows a pose."""
    runs = runs_by_name(poses)
    if len(runs) > 1:
        return {f"in the poses of {name}": member for name, member in runs.items()}
    index = np.arange(len(poses))
    last = len(poses) - FEWEST_OF_BLOCK
    return {f"from {poses.label[k]} on": index >= k for k in range(FEWEST_OF_BLOCK, last + 1)}


def _of_blocks(poses: PoseSet) -> Iterator[Mistake]:
    """Mistakes of one run among several; of one run alone, from some pose on."""
    alone = len(runs_by_name(poses)) == 1
    for where, member in _blocks(poses).items():
        yield from _of_readings(poses, member, where, within=alone)


def _of_worst_poses(poses: PoseSet, fitted: Fit | None) -> Iterator[Mistake]:
    """Mistakes of the poses that are farthest from what the others say.

    By their residuals, to first order: a refit without each pose takes seconds under Huber's loss,
    and would only put poses in order. Without a fit by the lengths of their readings.
    """
    for k in np.argsort(_off_by_length(poses) if fitted is None else _off_by_residual(fitted))[
            : -WORST_POSES - 1 : -1]:
        yield from _of_readings(poses, np.arange(len(poses)) == k, f"in {poses.label[k]}")


def _off_by_residual(fitted: Fit) -> FloatArray:
    """Mean square of what the rows of each pose are off when it is left out, (n,)."""
    root, pose = np.sqrt(fitted.weight), fitted.equations.row_pose
    jacobian = fitted.rows.jacobian @ fitted.directions * root[:, None]
    left_out = left_out_residual(fitted.rows.residual * root, jacobian, pose) / root[: len(pose)]
    return np.asarray(np.bincount(pose, left_out**2) / np.bincount(pose))


def _off_by_length(poses: PoseSet) -> FloatArray:
    """Logarithm of each reading's length over the reference, from the median, (n,); 0 at rest."""
    turning = ~poses.reference.is_null
    off = np.zeros(len(poses))
    length = np.maximum(np.linalg.norm(poses.reading[turning], axis=1), NO_LENGTH)
    ratio = np.log(length / poses.reference.magnitude[turning])
    off[turning] = np.abs(ratio - np.median(ratio))
    return off


def _of_readings(
    poses: PoseSet, member: BoolArray, where: str, *, within: bool = True
) -> Iterator[Mistake]:
    """Axes exchanged or mirrored, a wrong range or unit, in poses ``member`` within a run."""
    for matrix, words in CHANGES[poses.triad]:
        reading, sd = poses.reading.copy(), poses.sd.copy()
        reading[member] = reading[member] @ matrix.T
        sd[member] = sd[member] @ np.abs(matrix.T)
        yield Mistake(replace(poses, reading=reading, sd=sd), f"{words} {where}",
                      member if within else None)


def _of_rates(poses: PoseSet, base: Model) -> Iterator[Mistake]:
    """The rate of one run is wrong by whatever factor the other runs say."""
    runs = runs_by_name(poses)
    turning = {name: member for name, member in runs.items()
               if not poses.reference.is_null[member].any()}
    if len(turning) < 2 or poses.triad != "gyroscope":
        return
    for name, member in turning.items():
        try:
            others = fit(poses.take(~member), base)
        except CalibrationError:
            continue
        s = _corrected(others, poses.reading[member])
        stated = poses.reference.magnitude[member]
        ratio = float(np.median(np.linalg.norm(s, axis=1) / stated))
        if abs(ratio - 1) < SAME_RATE:
            continue
        rpm = ratio * float(np.median(stated)) / RPM
        yield Mistake(
            _at_rates(poses, [(member, ratio)]),
            f"by the gain that the other runs give, the plate turned at {rpm:.4g} rpm in "
            f"{name}{_whose(turning, poses, name, ratio)}, not at "
            f"{np.median(stated) / RPM:.4g} rpm",
        )


def _whose(turning: Mapping[str, BoolArray], poses: PoseSet, name: str, ratio: float) -> str:
    """The other run that turned at this rate, in words."""
    magnitude = poses.reference.magnitude
    rate = ratio * float(np.median(magnitude[turning[name]]))
    for other, member in turning.items():
        if other != name and abs(float(np.median(magnitude[member])) / rate - 1) < SAME_RATE:
            return f", as in {other}"
    return ""


def _exchanged_rates(poses: PoseSet) -> Iterator[Mistake]:
    """The rates (the clips) of two runs are exchanged."""
    magnitude = poses.reference.magnitude
    turning = {name: member for name, member in runs_by_name(poses).items()
               if not poses.reference.is_null[member].any()}
    for a, b in combinations(turning, 2):
        ratio = float(np.median(magnitude[turning[b]]) / np.median(magnitude[turning[a]]))
        if abs(ratio - 1) > SAME_RATE:
            yield Mistake(
                _at_rates(poses, [(turning[a], ratio), (turning[b], 1 / ratio)]),
                f"the rates (or the clips, or the files) of {a} and {b} are exchanged",
            )


def _at_rates(poses: PoseSet, changes: Sequence[tuple[BoolArray, float]]) -> PoseSet:
    """The poses with the rates of some of them multiplied."""
    factor = np.ones(len(poses))
    for member, ratio in changes:
        factor[member] = ratio
    reference = poses.reference
    return replace(
        poses,
        spin_rad_s=poses.spin_rad_s * factor,
        reference=replace(reference, magnitude=reference.magnitude * factor,
                          common=reference.common * factor[:, None]),
    )


def _corrected(fitted: Fit, reading: FloatArray) -> FloatArray:
    """The readings (m, 3) by the nine parameters of a fit."""
    columns = stack_columns(fitted.model.effects, Conditions.of_vectors(reading), {})
    return np.asarray(reading - columns @ fitted.theta)
