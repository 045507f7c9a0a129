"""How often the diagnosis finds what is hidden: sessions of the simulated bench, counted.

    python -m tests.bench.study_diagnosis listed rich gyroscope --sizes 2 5 10 --trials 40
    python -m tests.bench.study_diagnosis nothing paper gyroscope --trials 200
    python -m tests.bench.study_diagnosis two rich gyroscope --sizes 5 --trials 100
    python -m tests.bench.study_diagnosis unlisted rich gyroscope --sizes 10 --trials 50
    python -m tests.bench.study_diagnosis settle paper gyroscope --sizes 5 10 --trials 40
    python -m tests.bench.study_diagnosis sets rich gyroscope --count 3 --sizes 5 300 --trials 100
    python -m tests.bench.study_diagnosis sets soak accelerometer --count 1 --disturb wander
    python -m tests.bench.study_diagnosis sets paper gyroscope --trials 2000 --workers 8

``listed`` hides every listed effect in turn, in sizes given as root mean square over the pose
equations in noise units, and prints the share of trials in which these poses see it at all, in
which it (or one that these poses cannot tell from it) stood first in the ranking, was named, in
which something else was named, what the errors fell to, and how many 2-sigma intervals held the
truth. ``settle`` follows the advice of every verdict that leaves something open: it records the
block that was asked for and diagnoses again. ``sets`` hides ``--count`` effects at once, drawn
with sizes between the two of ``--sizes``, and a disturbance that no catalogue has; it prints the
share of hidden effects that were named, offered, and of sessions with a wrong name; each session
is repeated with nothing hidden, since half of all are sound by the prior of the diagnosis, and over
both halves stated probabilities stand beside frequencies; its designs are also ``hand`` and
``free``. ``--list`` shows the trials that went wrong. ``--workers`` and ``--scheduler`` spread the
trials over processes or a Dask cluster; the figures are the same.
"""

import argparse
from collections.abc import Iterator, Sequence
from functools import partial

from calib.errors import CalibrationError
from tests.bench import study_tables as tables
from tests.bench.pair_trials import one_pair
from tests.bench.trial_workers import Each, trials_on
from tests.recorded_blocks import Settled, settle
from tests.set_trials import (
    DISTURBANCES,
    NAMES,
    OF_THE_DESIGN,
    SetOutcome,
    design_of,
    disturbed,
    draw_set,
    set_trial,
    sound_trial,
)
from tests.trials import (
    DESIGNS,
    LISTED,
    Outcome,
    calibrates,
    drawn,
    hidden_of,
    run_trial,
)
from tests.world.bench import Design
from tests.world.hidden import TriadName

COLUMNS = ("humidity_pct", "supply_v")
UNLISTED = (
    *(f"column:{c}" for c in COLUMNS), *(f"column_squared:{c}" for c in COLUMNS), "jump",
    "bad_pose", "periodic",
)
ACCEPTED = {
    "jump": {"bias_step", "time_s"},
    "periodic": {"time_s"},
    "bad_pose": {"bad_pose"},
}
"""What counts as finding an effect that no catalogue has; a column's square is its column."""


def went_wrong(o: Outcome) -> bool:
    return o.visible and (not o.first or not o.named or o.named_wrong)


def listed(asked: argparse.Namespace, each: Each) -> None:
    """Every listed effect at every size."""
    design = DESIGNS[asked.design]()
    print(tables.HEAD)
    seen: dict[float, list[Outcome]] = {}
    for name in asked.effects or LISTED:
        if not calibrates(name, asked.triad):
            continue
        for size in asked.sizes:
            found = list(trials_of([name], size, design, asked, each))
            if not found:
                continue
            print(tables.table_row(name, size, found), flush=True)
            if tables.share([o.visible for o in found]) > 0.5:
                seen.setdefault(size, []).extend(found)
            if asked.list:
                for o in filter(went_wrong, found):
                    print(f"    seed {o.seed}: {o.verdict} {'/'.join(o.says)}, first {o.top}")
    for size, found in seen.items():
        print(tables.table_row("all that is visible", size, found), flush=True)


def trials_of(
    names: Sequence[str], size: float, design: Design, asked: argparse.Namespace, each: Each
) -> Iterator[Outcome]:
    """The trials of one effect and size; one that is refused is no trial, but told."""
    trial = partial(trial_of, names, size, design, asked.triad)
    for seed, outcome in each(trial, seeds_of(asked)):
        if isinstance(outcome, CalibrationError):
            print(f"    seed {seed} is refused: {outcome}")
        elif outcome is not None:
            yield outcome


def trial_of(
    names: Sequence[str], size: float, design: Design, triad: TriadName, seed: int
) -> Outcome | None:
    hidden = hidden_of(names, triad, size, design, seed)
    return None if hidden is None else run_trial(design, seed, triad, hidden)


def seeds_of(asked: argparse.Namespace) -> range:
    return range(asked.first_seed, asked.first_seed + asked.trials)


def nothing(asked: argparse.Namespace, each: Each) -> None:
    """Sessions in which nothing is hidden."""
    design = DESIGNS[asked.design]()
    found = list(trials_of([], 0.0, design, asked, each))
    quiet = tables.share([o.verdict == "nothing_missing" for o in found])
    named = tables.share([o.verdict == "effect" for o in found])
    print(
        f"nothing hidden, {asked.design} {asked.triad}, {len(found)} trials: "
        f"'nothing missing' {quiet:.4f}, an effect named {named:.4f}; "
        f"{tables.verdict_counts(found)}"
    )
    for o in found:
        if asked.list and o.verdict != "nothing_missing":
            print(f"    seed {o.seed}: {o.verdict} {'/'.join(o.says)}, first {o.top}")


def two(asked: argparse.Namespace, each: Each) -> None:
    """Two effects at once, the pair drawn anew for every trial; the loop is run to its end."""
    for size in asked.sizes:
        both = exactly = one = wrong = 0
        for seed, added in each(partial(one_pair, asked), seeds_of(asked)):
            if isinstance(added, CalibrationError):
                print(f"    seed {seed} is refused: {added}")
                continue
            both += added.right == 2
            one += added.right >= 1
            exactly += added.right == 2 and not added.innocent
            wrong += added.innocent
            if asked.list and (added.right < 2 or added.innocent):
                print(f"    seed {seed}: {added.text}")
        n = asked.trials
        print(f"two effects at {size:g}, {asked.design} {asked.triad}, {n} trials: both found "
              f"{both / n:.3f}, exactly these {exactly / n:.3f}, one or more {one / n:.3f}, an "
              f"innocent one added {wrong / n:.3f}", flush=True)


def unlisted(asked: argparse.Namespace, each: Each) -> None:
    """Effects that no catalogue has, and biases that follow a logged column."""
    design = DESIGNS[asked.design]()
    possible = [n for n in UNLISTED if n.partition(":")[2] in ("", *design.columns)]
    for name in asked.effects or possible:
        kind, _, column = name.partition(":")
        accepted = ACCEPTED.get(kind, {column, f"column:{column}"})
        for size in asked.sizes:
            found = list(trials_of([name], size, design, asked, each))
            hit = tables.share([o.verdict in ("unknown", "effect", "bad_pose") and (
                bool(accepted & set(o.says)) or o.verdict in accepted) for o in found])
            blamed = tables.share(
                [o.verdict == "effect" and not accepted & set(o.says) for o in found])
            print(f"{name:28s} {size:4g}: found {hit:.3f}, a listed effect blamed {blamed:.3f}; "
                  f"{tables.verdict_counts(found)}", flush=True)
            if asked.list:
                for o in found:
                    if not accepted & {*o.says, o.verdict}:
                        print(f"    seed {o.seed}: {o.verdict} {'/'.join(o.says)}, first {o.top}")


def settle_open(asked: argparse.Namespace, each: Each) -> None:
    """Verdicts that leave something open: record what is asked for, diagnose again."""
    total: list[Settled] = []
    for name in asked.effects or LISTED:
        if not calibrates(name, asked.triad):
            continue
        for size in asked.sizes:
            trials = each(partial(one_settled, asked, name, size), seeds_of(asked))
            found = [settled for _, settled in trials if isinstance(settled, Settled)]
            if found:
                print(tables.settled_row(name, size, found), flush=True)
                if asked.list:
                    for s in found:
                        if not s.right:
                            print(f"    seed {s.seed}: {'/'.join(s.before)}; after {s.block}: "
                                  f"{s.verdict} {'/'.join(s.after)}")
            total += found
    if total:
        print(tables.settled_row("all that stayed open", 0, total))


def one_settled(asked: argparse.Namespace, name: str, size: float, seed: int) -> Settled | None:
    """The session of one seed with what was asked for recorded too; None where nothing was open."""
    design = DESIGNS[asked.design]()
    hidden = hidden_of([name], asked.triad, size, design, seed)
    return None if hidden is None else settle(design, seed, asked.triad, hidden)


def sets(asked: argparse.Namespace, each: Each) -> None:
    """Several effects at once, with a disturbance; one diagnosis each."""
    low, high = (asked.sizes * 2)[:2]
    results = [outcome for _, outcome in each(partial(one_set, asked), seeds_of(asked))]
    pairs = [o for o in results if not isinstance(o, CalibrationError)]
    found: list[SetOutcome] = [hidden for hidden, _ in pairs]
    sound: list[SetOutcome] = [nothing for _, nothing in pairs]
    refused = len(results) - len(pairs)
    print(f"{asked.count} effects of {low:g} to {high:g} sd, {asked.design} {asked.triad}, "
          f"disturbed by {asked.disturb} ({refused} refused): "
          f"{tables.set_text(found, sound)}", flush=True)
    for o in found:
        if asked.list and (o.wrong or len(o.offered) < len(o.visible)):
            print(f"    seed {o.seed}: hidden {o.hidden} wrong {o.wrong} not offered "
                  f"{set(o.visible) - set(o.offered)}: {o.text}")


def one_set(asked: argparse.Namespace, seed: int) -> tuple[SetOutcome, SetOutcome]:
    """The session of one seed with what is asked to be hidden in it, and with nothing hidden."""
    low, high = (asked.sizes * 2)[:2]
    design = disturbed(design_of(asked.design, seed), asked.disturb)
    hidden = draw_set(design, seed, asked.triad, asked.count, (low, high),
                      asked.effects or NAMES, asked.nested)
    if asked.disturb not in OF_THE_DESIGN:
        more = drawn(asked.disturb, asked.triad, asked.strength, design, seed)
        hidden += [] if more is None else [more]
    return (set_trial(design, seed, asked.triad, hidden), sound_trial(design, seed, asked.triad))


QUESTIONS = {
    "sets": sets,
    "listed": listed,
    "nothing": nothing,
    "two": two,
    "unlisted": unlisted,
    "settle": settle_open,
}


def main() -> None:
    """Ask one question and print its table."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("question", choices=QUESTIONS)
    parser.add_argument("design", choices=(*DESIGNS, "hand", "free"))
    parser.add_argument("triad", choices=("accelerometer", "gyroscope"))
    parser.add_argument("--effects", nargs="+", default=None)
    parser.add_argument("--sizes", nargs="+", type=float, default=[5.0])
    parser.add_argument("--trials", type=int, default=40)
    parser.add_argument("--first-seed", type=int, default=0)
    parser.add_argument("--count", type=int, default=1)
    parser.add_argument("--disturb", choices=DISTURBANCES, default="none")
    parser.add_argument("--nested", action="store_true",
                        help="also pairs of which one holds the other")
    parser.add_argument("--strength", type=float, default=5.0, help="of the disturbance, sd")
    parser.add_argument("--list", action="store_true", help="show the trials that went wrong")
    parser.add_argument("--workers", type=int, default=1, help="processes of this machine")
    parser.add_argument("--scheduler", help="address of a Dask cluster")
    asked = parser.parse_args()
    with trials_on(asked.workers, asked.scheduler) as each:
        QUESTIONS[asked.question](asked, each)


if __name__ == "__main__":
    main()
