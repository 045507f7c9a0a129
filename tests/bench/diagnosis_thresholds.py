"""What halving and doubling each number of the diagnosis changes.

    python -m tests.bench.diagnosis_thresholds [--trials 12] [--first 43000] [--only FIELD]

Sessions of the simulated bench hide none, one or two effects, in rich designs, in those of the
paper and in poses laid by hand, for both triads. They are fitted once. Each field of
``calib.diagnosis.constants`` is multiplied by a half and by two, one at a time, as are counts and
shares of its modules (waves of an unknown function, lags, refits that are asked what they predict,
sets that are weighed, the memory of a pose); all are diagnosed again. Of a share close to one, the
rest to one is halved and doubled. Printed per value,
as rows of the table in ``data/docs/thresholds.md``: sessions whose verdict changes (its code, its
names or what it leaves open), hidden effects that are named, of those that can be seen, and wrong
names.
"""

import argparse
import dataclasses
from collections.abc import Callable, Iterator, Sequence
from contextlib import AbstractContextManager, contextmanager
from dataclasses import dataclass
from types import ModuleType

import numpy as np

from calib.diagnosis.constants import CONSTANTS, Constants
from calib.diagnosis.finding import find
from calib.diagnosis.hypotheses import courses, listed, unlisted
from calib.diagnosis.search import candidates, evidence, search, sizes
from calib.effects.catalogue import BASE
from calib.errors import CalibrationError
from calib.fit import noise_size
from calib.fit.least_squares.result import Fit
from calib.fit.least_squares.solver import fit
from calib.fit.model import Model
from tests.bench.threshold_records import FACTORS, replaced
from tests.set_trials import SetOutcome, design_of, draw_set, scored
from tests.trials import poses_of

KINDS = (("gyroscope", "rich"), ("accelerometer", "hand"), ("gyroscope", "paper"),
         ("accelerometer", "rich"))
SIZES = (4.0, 100.0)  #: noise units over the rows, from hardly seen to plain
COUNTS = ((courses, "STEP_MARGIN"), (courses, "STEPS_TRIED"), (listed, "MODES"),
          (candidates, "BEST_OF_EACH_SIZE"), (search, "ROUNDS"), (search, "FAR_ROUNDS"),
          (search, "REFITTED"), (search, "GROWN"))
SHARES = ((noise_size, "LEAST_EXTRA"), (noise_size, "ODDS_LARGER"), (noise_size, "FORMULA_ERROR"),
          (unlisted, "MEMORY"), (unlisted, "SMOOTH"), (sizes, "SEEN_SHARE"))
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
        seed, (triad, title) = first + i, KINDS[i % 4]
        design = design_of(title, seed)
        hidden = draw_set(design, seed, triad, i % 3, SIZES)
        try:
            base = fit(poses_of(design, seed, triad, hidden), Model.of(BASE))
        except CalibrationError as error:
            print(f"{seed}: refused: {error}")
            continue
        yield Session(seed, base, tuple(each.name for each in hidden))


def outcomes(every: Sequence[Session]) -> list[tuple[SetOutcome, tuple[str, ...]]]:
    """What the diagnosis says of each, and what it leaves open."""
    findings = [(each, find(each.base)) for each in every]
    return [(scored(each.seed, finding, each.hidden), finding.verdict.group)
            for each, finding in findings]


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
    derived = ("TAUS", "HALF_CAUCHY", "LOG_PRIOR")
    usual = {name: getattr(evidence, name) for name in derived}
    taus = 2.0 ** np.arange(new.octaves_of_size)
    density = taus / (1.0 + (taus / new.typical_size) ** 2)
    changed = dict(zip(derived, (taus, density, np.log(density / density.sum())), strict=True))
    with replaced(CONSTANTS, new):
        try:
            for name, value in changed.items():
                setattr(evidence, name, value)
            yield
        finally:
            for name, value in usual.items():
                setattr(evidence, name, value)


@contextmanager
def other(module: ModuleType, name: str, value: object) -> Iterator[None]:
    """The diagnosis with another value of a constant of one of its modules."""
    usual = getattr(module, name)
    setattr(module, name, value)
    _forget(module)
    try:
        yield
    finally:
        setattr(module, name, usual)
        _forget(module)


def _forget(module: ModuleType) -> None:
    """Empty the caches of a module's functions."""
    for each in vars(module).values():
        if hasattr(each, "cache_clear"):
            each.cache_clear()


def lags(count: float) -> AbstractContextManager[None]:
    """The diagnosis with so many lags of the temperature, over the same range."""
    usual = unlisted.LAGS_S
    return other(unlisted, "LAGS_S",
                 tuple(np.geomspace(usual[0], usual[-1], int(count)).tolist()))


def summary(found: Sequence[tuple[SetOutcome, tuple[str, ...]]]) -> str:
    """Effects named, of those visible, and wrong names."""
    named, visible, wrong = (sum(len(getattr(one, name)) for one, _ in found)
                             for name in ("named", "visible", "wrong"))
    return f"{named} of {visible} named, {wrong} wrong"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--trials", type=int, default=12)
    parser.add_argument("--first", type=int, default=43000)
    parser.add_argument("--only", default="")
    options = parser.parse_args()
    every = list(sessions(options.first, options.trials))
    usual = outcomes(every)
    print(f"{len(every)} sessions, as it is: {summary(usual)}\n")
    print("| constant | value | origin | × 0.5 | × 2 |\n|---|---|---|---|---|")

    def row(name: str, value: float, origin: str,
            changed_to: Callable[[float], AbstractContextManager[None]]) -> None:
        if options.only not in ("", name):
            return
        cells = []
        for factor in FACTORS:
            with changed_to(moved(value, factor)):
                now = outcomes(every)
            changed = sum(verdict(a) != verdict(b) for a, b in zip(usual, now, strict=True))
            cells.append(f"{changed} change: {summary(now)}" if changed else "no effect")
        print(f"| {name} | {value:g} | {origin} | {' | '.join(cells)} |", flush=True)

    for field in dataclasses.fields(CONSTANTS):
        row(field.name, getattr(CONSTANTS, field.name), field.metadata["origin"],
            lambda value, name=field.name: constants(
                dataclasses.replace(CONSTANTS, **{name: value})))
    for module, name in COUNTS:
        row(name, getattr(module, name), "a count",
            lambda value, module=module, name=name: other(module, name, int(value)))
    for module, name in SHARES:
        row(name, getattr(module, name), "a share",
            lambda value, module=module, name=name: other(module, name, value))
    row("LAGS_S", len(unlisted.LAGS_S), "derived", lags)


if __name__ == "__main__":
    main()
