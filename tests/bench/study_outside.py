"""What the diagnosis says of errors that no catalogue has: wrong names, stated against frequency.

    python -m tests.bench.study_outside hand --each 20 --sizes 5 100
    python -m tests.bench.study_outside paper --each 20 --sizes 5 100 --held-out
    python -m tests.bench.study_outside gyroscope --each 4 --sizes 5 100 --held-out

Hides each formula of :mod:`tests.outside_formulas` in the evenings of one sensor each (18 or 26
poses of an accelerometer; ``gyroscope`` and ``accelerometer`` have 130 and 78 that show every
effect), on every axis in a size of its own, the root mean square over the pose equations
log-uniform between ``--sizes`` sds; as many evenings hide nothing. No listed effect is there, so
that whatever is named is wrong. One of which the verdict says that another function of the same
looks alike is no claim on a formula, and is counted apart; so is one that *stands in*: under the
conditions of the session, in attitudes of its own, the refit with it corrects magnitudes as well as
it states, by two sds (its own and those of a pose together) in the root mean square.
"""

import argparse
from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from calib.diagnosis.finding import Finding, find
from calib.diagnosis.verdict.decision import refit_of
from calib.effects.catalogue import BASE
from calib.errors import CalibrationError
from calib.fit.least_squares.result import Fit
from calib.fit.least_squares.solver import fit
from calib.fit.model import Model
from calib.fit.rows.residuals import Equations
from calib.poses.imu_log import FloatArray
from calib.poses.pose_set import PoseSet
from tests.bench.study_evenings import design_called
from tests.bench.trial_workers import trials_on
from tests.calib.made_poses import GRAVITY, noisy, rich_poses
from tests.hidden_formulas import Formula
from tests.lots import pose_sets_of
from tests.outside_formulas import HELD_OUT, SEEN
from tests.set_trials import OFFERED, SetOutcome, reliability, scored
from tests.world.bench import HUMIDITY, SUPPLY_V
from tests.world.lot import LotPlan, draw_lot

STANDS_IN_SD = 2.0  #: stated sds, in the root mean square, up to which a name does no harm
DESIGNS = ("hand", "paper")  #: those of a lot
NEW = 8  #: sets of new attitudes of as many poses as the session


@dataclass(frozen=True, eq=False)
class Hiding:
    """One formula, times ``size`` (3,) about ``mean`` (3,), SI."""

    formula: Formula
    size: FloatArray
    mean: FloatArray

    def errors(self, poses: PoseSet, true: FloatArray) -> FloatArray:
        """Errors (n, 3) of the readings, SI."""
        unit = true / np.linalg.norm(true, axis=1).max()
        return np.broadcast_to(self.formula(poses, unit), true.shape) * self.size - self.mean


def drawn(formula: Formula, sound: Fit, sizes: tuple[float, float], seed: int) -> Hiding:
    """A formula in a direction and of a size of its own."""
    random = np.random.default_rng([seed, 80])
    true, nothing = sound.rows.vector, np.zeros(3)
    direction = random.standard_normal(3)
    errors = Hiding(formula, direction, nothing).errors(sound.poses, true)
    mean = errors.mean(axis=0)
    rows = sound.equations.whitened((errors - mean)[:, :, None], true)
    size = np.exp(random.uniform(*np.log(sizes))) / np.sqrt(np.mean(rows**2))
    return Hiding(formula, size * direction, size * mean)


def new_sets(sound: Fit, seed: int) -> Iterator[tuple[PoseSet, FloatArray]]:
    """The session with its conditions in new attitudes, without noise, and the true vectors."""
    random, poses = np.random.default_rng([seed, 81]), sound.poses
    affine = np.linalg.lstsq(
        np.column_stack([sound.rows.vector, np.ones(len(poses))]), poses.reading, rcond=None)[0]
    for _ in range(NEW):
        up = random.standard_normal((len(poses), 3))
        up /= np.linalg.norm(up, axis=1, keepdims=True)
        true = poses.reference.magnitude[:, None] * up
        reading = np.column_stack([true, np.ones(len(poses))]) @ affine
        yield replace(poses, reading=reading, force=force_of(poses, reading, GRAVITY * up)), true


def force_of(poses: PoseSet, reading: FloatArray, otherwise: FloatArray) -> FloatArray:
    """The specific force (n, 3) where an accelerometer reads ``reading``; else ``otherwise``."""
    return reading if poses.triad == "accelerometer" else otherwise


def stands_in(joint: Fit, sound: Fit, hiding: Hiding, seed: int) -> bool:
    """Whether the refit ``joint`` corrects magnitudes in new attitudes as well as it states."""
    squares = []
    for poses, true in new_sets(sound, seed):
        poses = replace(poses, reading=poses.reading + hiding.errors(poses, true))
        equations = Equations.of_sets(
            (poses,), joint.model, joint.equations.start.take(None)).take(0)
        rows = equations.rows(joint.theta, joint.eta, joint.shapes)
        slope = rows.jacobian[:, : joint.model.size]
        variance = 1 + np.einsum("ri,ij,rj->r", slope, joint.cov, slope)
        squares.append(rows.residual**2 / variance)
    return bool(np.sqrt(np.mean(squares)) <= STANDS_IN_SD)


@dataclass(frozen=True)
class Outside:
    """One evening: what is hidden, what the diagnosis says, whether its names stand in, and
    whether it says that another function looks the same.
    """

    formula: str
    size: float
    outcome: SetOutcome
    harmless: bool
    told: bool

    @property
    def standing(self) -> str:
        """What its name is, in a word or two."""
        return "stands in" if self.harmless else "told" if self.told else "WRONG"


def said(finding: Finding, sound: Fit, hiding: Hiding, seed: int) -> bool:
    """Whether what is named stands in."""
    joint = refit_of(finding.posterior, finding.verdict.names)
    return joint is not None and stands_in(joint.fit, sound, hiding, seed)


def evenings_of(design_name: str, count: int, seed: int) -> list[PoseSet]:
    """So many evenings without an error."""
    if design_name in DESIGNS:
        design = replace(design_called(design_name),
                         columns={"humidity_pct": HUMIDITY, "supply_v": SUPPLY_V})
        return list(pose_sets_of(draw_lot(design, LotPlan(count), seed)))
    evenings = []
    for each in range(1000 * seed, 1000 * seed + count):
        poses = rich_poses("gyroscope" if design_name == "gyroscope" else "accelerometer", each)
        supply_v = 3.3 + 0.1 * np.random.default_rng([each, 99]).standard_normal(len(poses))
        columns = {**poses.columns, "supply_v": supply_v}
        evenings.append(noisy(replace(poses, columns=columns), each))
    return evenings


def one_seed(
    design_name: str, formulas: Mapping[tuple[str, str], Formula], sizes: tuple[float, float],
    seed: int,
) -> tuple[list[Outside], list[SetOutcome], int]:
    """Every formula once, and as many evenings without."""
    lot = evenings_of(design_name, 2 * len(formulas), seed)
    hidden, sound, refused = [], [], 0
    for i, poses in enumerate(lot[len(formulas):]):
        sound.append(scored(1000 * seed + i, find(fit(poses, Model.of(BASE))), ()))
    for i, ((subject, name), poses) in enumerate(zip(formulas, lot, strict=False)):
        one, formula = 1000 * seed + i, formulas[subject, name]
        before = fit(poses, Model.of(BASE))
        hiding = drawn(formula, before, sizes, one)
        errors = hiding.errors(poses, before.rows.vector)
        size = float(np.sqrt(np.mean(
            before.equations.whitened(errors[:, :, None], before.rows.vector) ** 2)))
        reading = poses.reading + errors
        try:
            force = force_of(poses, reading, poses.force)
            found = find(fit(replace(poses, reading=reading, force=force), Model.of(BASE)))
        except CalibrationError:
            refused += 1
            continue
        names = found.verdict.names
        hidden.append(Outside(name, size, scored(one, found, ("outside",)),
                              bool(names) and said(found, before, hiding, one),
                              subject in found.verdict.straight))
    return hidden, sound, refused


def main() -> None:
    """Print wrong names by formula, verdicts, and stated probabilities beside frequencies."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("design", choices=(*DESIGNS, "gyroscope", "accelerometer"))
    parser.add_argument("--each", type=int, default=20, help="evenings of every formula")
    parser.add_argument("--sizes", type=float, nargs=2, default=(5.0, 100.0))
    parser.add_argument("--first-seed", type=int, default=0)
    parser.add_argument("--held-out", action="store_true")
    parser.add_argument("--list", action="store_true", help="show the evenings with a name")
    parser.add_argument("--workers", type=int, default=1, help="processes of this machine")
    asked = parser.parse_args()
    formulas = HELD_OUT if asked.held_out else SEEN
    trial = partial(one_seed, asked.design, formulas, tuple(asked.sizes))
    seeds = range(asked.first_seed, asked.first_seed + asked.each)
    with trials_on(asked.workers, None) as each:
        parts = [part for _, part in each(trial, seeds) if not isinstance(part, CalibrationError)]
    hidden = [one for part in parts for one in part[0]]
    sound = [one for part in parts for one in part[1]]
    for _, name in formulas:
        of_one = [one for one in hidden if one.formula == name]
        named = [one for one in of_one if one.outcome.wrong]
        kinds = Counter(one.outcome.verdict for one in of_one)
        print(f"{name:24s} {len(named):3d} of {len(of_one)} named, "
              f"{sum(one.harmless for one in named):3d} stand in; "
              + ", ".join(f"{kind} {count}" for kind, count in kinds.most_common()))
        for one in named if asked.list else ():
            print(f"    seed {one.outcome.seed}, {one.size:.0f} sd, "
                  f"{one.standing}: {one.outcome.text}")
    named = Counter(one.standing for one in hidden if one.outcome.wrong)
    print(f"{asked.design}, {len(hidden)} evenings with something outside, "
          f"{sum(part[2] for part in parts)} refused: {named.total()} named, of which "
          f"{named['stands in']} stand in and {named['told']} are said to look like others; wrong "
          f"{named['WRONG']}, {100 * named['WRONG'] / max(len(hidden), 1):.2f} %; of {len(sound)} "
          f"sound ones {sum(bool(one.wrong) for one in sound)} named")
    apart = [one.outcome if one.standing == "WRONG" else replace(one.outcome, stated=())
             for one in hidden]
    print(f"stated beside what came true, without those that stand in (from {OFFERED:g} on)")
    print(reliability([*apart, *sound]))


if __name__ == "__main__":
    main()
