"""What halving, doubling and switching off each number of the diagnosis changes.

    python -m tests.bench.diagnosis_thresholds [--trials 105] [--first 640000] [--only NAME ...]

Evenings of simulated pose means hide none, one or two effects, of 4 to 100 sd, in poses of the
paper, at rest and turning, and in poses laid by hand; a fifth of those at rest hides a step, a bad
pose, a wander or a swing. They are fitted once.
Each field of ``calib.diagnosis.constants`` is multiplied by a half and by two, one at a time, and
put to where it decides nothing; so are counts and shares of its modules. All are diagnosed again.
Of a share close to one, the rest to one is halved and doubled. Printed per value, as rows of the
table in ``data/docs/thresholds.md``: sessions whose verdict changes (its code, its names or what it
leaves open), hidden effects that are named, of those that can be seen, and wrong names.
"""

import argparse
import dataclasses
from collections.abc import Callable, Iterator, Sequence
from contextlib import AbstractContextManager, contextmanager
from dataclasses import dataclass

import numpy as np

from calib.diagnosis.constants import CONSTANTS, Constants
from calib.diagnosis.finding import find
from calib.diagnosis.hypotheses import courses, listed, unlisted
from calib.diagnosis.search import candidates, evidence, search
from calib.diagnosis.verdict import ranking
from calib.effects.catalogue import BASE
from calib.errors import CalibrationError
from calib.fit import noise_size
from calib.fit.least_squares.result import Fit
from calib.fit.least_squares.solver import fit
from calib.fit.model import Model
from tests.bench.study_evenings import design_called, hidden_in
from tests.bench.threshold_records import FACTORS, changed
from tests.lots import pose_sets_of
from tests.set_trials import SetOutcome, scored
from tests.world.lot import LotPlan, draw_lot
from tests.world.turning_lot import draw_turning_lot

KINDS = ("paper", "plate", "hand")
SIZES = (4.0, 100.0)  #: noise units over the rows, from hardly seen to plain
DISTURBED_BY = ("jump", "bad_pose", "wander", "periodic")
COUNTS = {(courses, "STEPS_TRIED"): 4, (listed, "MODES"): 200,
          (candidates, "BEST_OF_EACH_SIZE"): 0, (candidates, "LARGEST_LISTED"): 2,
          (search, "ROUNDS"): 0, (search, "REFITTED"): 30,
          (search, "GROWN"): 0, (search, "MOST_SETS_OF_PLACES"): 0}
"""Counts of its modules, with the value by which each is switched off."""

SHARES = {(noise_size, "LEAST_EXTRA"): 1e-3, (noise_size, "ODDS_RARE"): 1e-300,
          (noise_size, "FORMULA_ERROR"): 0.0, (unlisted, "SMOOTH"): 1e-3,
          (listed, "LEAST_BEND"): 0.0, (courses, "PAUSE"): 1e9, (ranking, "SEEN_SHARE"): 0.0}
OFF = {
    "odds_listed": 1e-300, "odds_unknown": 1e-300, "odds_wander": 1e-300,
    "alias_correlation": 1.0, "fewest_dof": 1, "near": 0.0, "negligible": 1e3,
    "sure": 0.0, "least_offered": 0.0, "least_listed": 0.0, "misfit_p_value": 0.0, "told_apart":
    0.0, "limit_sd": 0.0, "prior_nothing": 0.0,
}
"""Values of the constants at which each decides nothing; of the others there is none."""

CLOSE_TO_ONE = 0.75  #: a share above it is moved by its rest to one


@dataclass(frozen=True, eq=False)
class Session:
    """A session and what is hidden in it."""

    seed: int
    base: Fit
    hidden: tuple[str, ...]


def sessions(first: int, trials: int) -> Iterator[Session]:
    """``trials`` sessions; one that is refused is left out."""
    for i in range(trials):
        seed, kind = first + i, KINDS[i % 3]
        possible = np.random.default_rng([seed, 33]).permutation(hidden_in(kind)).tolist()
        hidden = tuple(possible[: i // 3 % 3])
        if kind != "plate" and i % 5 == 4:
            hidden = (*hidden, DISTURBED_BY[i // 5 % len(DISTURBED_BY)])[-2:]
        elif kind == "plate":
            hidden = hidden[:1]
        one, other_one = (*hidden, None, None)[:2]
        draw = draw_turning_lot if kind == "plate" else draw_lot
        plan = LotPlan(1, hidden=one, beside=other_one, own_sd=SIZES)
        try:
            base = fit(pose_sets_of(draw(design_called(kind), plan, seed))[0], Model.of(BASE))
        except CalibrationError as error:
            print(f"{seed}: refused: {error}")
            continue
        yield Session(seed, base, hidden)


def outcomes(every: Sequence[Session]) -> list[tuple[SetOutcome, tuple[str, ...]]]:
    """What the diagnosis says of each, and what it leaves open."""
    results = [(each, find(each.base)) for each in every]
    return [(scored(each.seed, result, each.hidden), result.verdict.group)
            for each, result in results]


def verdict(outcome: tuple[SetOutcome, tuple[str, ...]]) -> tuple[str, object, object]:
    """What is compared of an outcome."""
    one, group = outcome
    return one.text.partition(")")[0], one.named, sorted(group)


def moved(value: float, factor: float) -> float:
    """A value times a factor; of a share close to one, its rest to one."""
    if CLOSE_TO_ONE < value < 1:
        return 1 - factor * (1 - value)
    return type(value)(factor * value)


@contextmanager
def constants(new: Constants) -> Iterator[None]:
    """The diagnosis with other constants, and what its modules derive from them."""
    derived = ("HALF_CAUCHY", "LOG_PRIOR")
    usual = {name: getattr(evidence, name) for name in derived}
    density = evidence.TAUS / (1.0 + (evidence.TAUS / new.typical_size) ** 2)
    others = dict(zip(derived, (density, np.log(density / density.sum())), strict=True))
    with changed("calib.diagnosis.constants", "CONSTANTS", new):
        try:
            for name, value in others.items():
                setattr(evidence, name, value)
            yield
        finally:
            for name, value in usual.items():
                setattr(evidence, name, value)


def lags(count: float) -> AbstractContextManager[None]:
    """The diagnosis with so many lags of the temperature, over the same range."""
    usual = unlisted.LAGS_S
    return changed(unlisted.__name__, "LAGS_S",
                   tuple(np.geomspace(usual[0], usual[-1], int(count)).tolist()))


def spans(count: float) -> AbstractContextManager[None]:
    """The diagnosis with so many correlation times of a wander, over the same range."""
    usual = courses.WANDER_SPANS
    return changed(courses.__name__, "WANDER_SPANS",
                   tuple(np.geomspace(usual[0], usual[-1], int(count)).tolist()))


def summary(found: Sequence[tuple[SetOutcome, tuple[str, ...]]]) -> str:
    """Effects named, of those visible, and wrong names."""
    named, visible, wrong = (sum(len(getattr(one, name)) for one, _ in found)
                             for name in ("named", "visible", "wrong"))
    return f"{named} of {visible} named, {wrong} wrong"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--trials", type=int, default=100)
    parser.add_argument("--first", type=int, default=640000)
    parser.add_argument("--only", nargs="*", default=())
    options = parser.parse_args()
    every = list(sessions(options.first, options.trials))
    usual = outcomes(every)
    print(f"{len(every)} sessions, as it is: {summary(usual)}\n")
    print("| constant | value | origin | × 0.5 | × 2 | off |\n|---|---|---|---|---|---|")

    def row(name: str, value: float, origin: str, off: float | None,
            changed_to: Callable[[float], AbstractContextManager[None]]) -> None:
        if options.only and name not in options.only:
            return
        cells = []
        for other_value in (off, *(moved(value, factor) for factor in FACTORS)):
            if other_value is None:
                cells.append("not to be had")
                continue
            if cells and cells[0] == "no effect":
                cells.append("no effect")
                continue
            with changed_to(other_value):
                now = outcomes(every)
            differ = sum(verdict(a) != verdict(b) for a, b in zip(usual, now, strict=True))
            cells.append(f"{differ} change: {summary(now)}" if differ else "no effect")
        cells = [*cells[1:], cells[0]]
        print(f"| {name} | {value:g} | {origin} | {' | '.join(cells)} |", flush=True)

    for field in dataclasses.fields(CONSTANTS):
        row(field.name, getattr(CONSTANTS, field.name), field.metadata["origin"],
            OFF.get(field.name), lambda value, name=field.name: constants(
                dataclasses.replace(CONSTANTS, **{name: value})))
    for (module, name), off in {**COUNTS, **SHARES}.items():
        row(name, getattr(module, name), "of a module", off,
            lambda value, module=module, name=name: changed(module.__name__, name, value))
    row("LAGS_S", len(unlisted.LAGS_S), "derived", 1, lags)
    row("WANDER_SPANS", len(courses.WANDER_SPANS), "derived", 1, spans)


if __name__ == "__main__":
    main()
