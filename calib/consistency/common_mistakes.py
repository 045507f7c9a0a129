"""Common mistakes in the files of a session, and the poses as they would be without each."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial
from itertools import combinations

import numpy as np

from calib.consistency.force import FACTORS
from calib.consistency.signed_axes import SIGNED_PERMUTATIONS, permutation_words
from calib.errors import CalibrationError
from calib.fit.least_squares.solver import fit
from calib.fit.model import Model
from calib.fit.triad.correction import linear_form
from calib.numbers import RPM
from calib.poses.imu_log import BoolArray, FloatArray, Triad
from calib.poses.pose_set import PoseSet
from calib.poses.reference import PLAUSIBLE_RATIO

SAME_RATE = 0.02
"""Relative difference of two plate rates that are too close for one to be mistaken for the other.
Fact: drives keep their speed to 2 %, and the speeds of records differ by 35 % and more."""

FEWEST_OF_BLOCK = 3  #: poses; derived: fewer are bad poses, which have their own verdict

CHANGED_AXES: tuple[tuple[FloatArray, str], ...] = tuple(
    (matrix.T, permutation_words(matrix)) for matrix in SIGNED_PERMUTATIONS[1:])
"""Matrices (3, 3) that undo exchanged or mirrored axes; the mistake in words."""

FACTORS_ALONE: Mapping[Triad, tuple[tuple[FloatArray, str], ...]] = {
    triad: tuple((factor * np.eye(3), f"the readings are {words}")
                 for factor, words in factors.items())
    for triad, factors in FACTORS.items()
}
"""Matrices that undo a wrong range or unit, for the triads for which these are known."""

CHANGES: Mapping[Triad, tuple[tuple[FloatArray, str], ...]] = {
    triad: (*CHANGED_AXES, *factors) for triad, factors in FACTORS_ALONE.items()
}
"""Both."""


@dataclass(frozen=True, eq=False)
class Mistake:
    """One mistake: what gives the poses without it, and what it is, in words.

    ``of`` are the affected poses, (n,), where they are not the whole run; ``mapped`` those, (n,),
    whose readings one matrix changes.
    """

    undo: Callable[[], PoseSet]
    words: str
    of: BoolArray | None = None
    mapped: BoolArray | None = None

    @cached_property
    def undone(self) -> PoseSet:
        """The poses without it."""
        return self.undo()


def runs_by_name(poses: PoseSet) -> dict[str, BoolArray]:
    """Poses of each run by its name; of runs at one setting by their first pose, too."""
    runs = np.array(poses.run)
    begins = np.flatnonzero(np.r_[True, runs[1:] != runs[:-1]])
    number = np.cumsum(np.r_[True, runs[1:] != runs[:-1]]) - 1
    often = {name for name in poses.run if (runs[begins] == name).sum() > 1}
    return {
        f"run '{runs[k]}'" + (f" from {poses.label[k]} on" if runs[k] in often else ""): number == i
        for i, k in enumerate(begins)
    }


def blocks(poses: PoseSet) -> dict[str, BoolArray]:
    """Poses of one run among several, by its name in words; of a single run, those after a pose."""
    runs = runs_by_name(poses)
    if len(runs) > 1:
        return {f"in the poses of {name}": member for name, member in runs.items()}
    index = np.arange(len(poses))
    last = len(poses) - FEWEST_OF_BLOCK
    return {f"from {poses.label[k]} on": index >= k for k in range(FEWEST_OF_BLOCK, last + 1)}


def block_mistakes(poses: PoseSet) -> Iterator[Mistake]:
    """Axes exchanged or mirrored, a wrong range or unit in one run among several.

    In a single run, from some pose on. Poses of a gyroscope at rest show no gain: another range
    cannot be told from another bias.
    """
    alone = len(runs_by_name(poses)) == 1
    for where, member in blocks(poses).items():
        at_rest = bool(poses.reference.is_null[member].all())
        changes = CHANGED_AXES if at_rest else CHANGES.get(poses.triad, CHANGED_AXES)
        for matrix, words in _readable(changes, poses, member):
            yield _mistake(poses, matrix, member, f"{words} {where}", within=alone)


def odd_mistakes(poses: PoseSet, odd: BoolArray) -> Iterator[Mistake]:
    """Mistakes of the poses ``odd`` that contradict the others.

    An exchange of axes in a single pose changes one length, which some exchange always explains.
    """
    labels = [label for label, is_odd in zip(poses.label, odd, strict=True) if is_odd]
    changes = CHANGES.get(poses.triad, CHANGED_AXES) if len(labels) > 1 else FACTORS_ALONE.get(
        poses.triad, ())
    for matrix, words in _readable(changes, poses, odd):
        yield _mistake(poses, matrix, odd, f"{words} in {' and '.join(labels)}", within=True)


def _readable(
    changes: Sequence[tuple[FloatArray, str]], poses: PoseSet, member: BoolArray
) -> Iterator[tuple[FloatArray, str]]:
    """The changes after which the data sheet allows the readings of ``member``.

    Readings that become a fiftieth of the reference leave a shifted bias as much less, and explain
    every misfit.
    """
    turning = member & ~poses.reference.is_null
    reading, magnitude = poses.reading[turning], poses.reference.magnitude[turning]
    for matrix, words in changes:
        ratio = np.median(np.linalg.norm(reading @ matrix.T, axis=1) / magnitude) if len(
            magnitude) else 1.0
        if 1 / PLAUSIBLE_RATIO < ratio < PLAUSIBLE_RATIO:
            yield matrix, words


def _mistake(
    poses: PoseSet, matrix: FloatArray, member: BoolArray, words: str, *, within: bool
) -> Mistake:
    """The mistake that multiplication of the readings of ``member`` by a matrix undoes."""
    return Mistake(partial(_mapped, poses, matrix, member), words, member if within else None,
                   member)


def _mapped(poses: PoseSet, matrix: FloatArray, member: BoolArray) -> PoseSet:
    """The poses with the readings of some multiplied by a matrix."""
    reading, sd = poses.reading.copy(), poses.sd.copy()
    reading[member] = reading[member] @ matrix.T
    sd[member] = sd[member] @ np.abs(matrix.T)
    return replace(poses, reading=reading, sd=sd)


def rate_mistakes(poses: PoseSet, base: Model) -> Iterator[Mistake]:
    """Mistakes where the rate of one run is wrong by the factor that the other runs give."""
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
        matrix, offset = linear_form(others.model, others.theta)
        s, stated = poses.reading[member] @ matrix.T + offset, poses.reference.magnitude[member]
        ratio = float(np.median(np.linalg.norm(s, axis=1) / stated))
        if abs(ratio - 1) < SAME_RATE:
            continue
        rpm = ratio * float(np.median(stated)) / RPM
        yield Mistake(
            partial(_at_rates, poses, [(member, ratio)]),
            f"by the gain that the other runs give, the plate turned at {rpm:.4g} rpm in "
            f"{name}{_other_run_at(turning, poses, name, ratio)}, not at "
            f"{np.median(stated) / RPM:.4g} rpm",
            member,
        )


def _other_run_at(turning: Mapping[str, BoolArray], poses: PoseSet, name: str, ratio: float) -> str:
    """Name of the other run that turned at this rate, in words."""
    magnitude = poses.reference.magnitude
    rate = ratio * float(np.median(magnitude[turning[name]]))
    for other, member in turning.items():
        if other != name and abs(float(np.median(magnitude[member])) / rate - 1) < SAME_RATE:
            return f", as in {other}"
    return ""


def exchanged_rates(poses: PoseSet) -> Iterator[Mistake]:
    """Mistakes where the rates (the clips) of two runs are exchanged."""
    magnitude = poses.reference.magnitude
    turning = {name: member for name, member in runs_by_name(poses).items()
               if not poses.reference.is_null[member].any()}
    for a, b in combinations(turning, 2):
        ratio = float(np.median(magnitude[turning[b]]) / np.median(magnitude[turning[a]]))
        if abs(ratio - 1) > SAME_RATE:
            yield Mistake(
                partial(_at_rates, poses, [(turning[a], ratio), (turning[b], 1 / ratio)]),
                f"the rates (or the clips, or the files) of {a} and {b} are exchanged",
                turning[a] | turning[b],
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
