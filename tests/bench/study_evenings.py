"""How often stated probabilities come true: simulated evenings by the thousand.

    python -m tests.bench.study_evenings paper --evenings 20000 --workers 2
    python -m tests.bench.study_evenings hand --evenings 20000 --sizes 2 50
    python -m tests.bench.study_evenings plate --evenings 20000 --workers 2
    python -m tests.bench.study_evenings mixture --evenings 20000 --workers 2

``paper`` and ``hand`` are accelerometers in poses at rest, ``plate`` gyroscopes in the paper's 18
poses on the turning plate with the humidity logged. Half of the evenings hide nothing, as the prior
of the diagnosis has it; each of the others hides one listed effect in a direction and of a size of
its own, log-uniform between ``--sizes`` (root mean square over the pose equations, noise units).
``mixture`` hides in the poses of ``paper`` what the diagnosis believes in before it sees data: the
effects, steps, bad poses, biases that wander or swing, and two of these at once, each as often as
its prior has it, in sizes of the prior's half-Cauchy distribution, alike for all parameters of an
effect; every evening has its own moments, periods and time constants, so that each is a case of its
own.
The others are drawn as stacks (``tests.world.lot``, ``tests.world.turning_lot``). Each is fitted
and diagnosed by itself. The tables show what was named, and every stated probability beside how
often it came true. ``--workers`` and ``--scheduler`` are those of ``tests.bench.study_diagnosis``.
"""

import argparse
import time
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import combinations
from itertools import count as count_from

from calib.diagnosis.constants import CONSTANTS
from calib.diagnosis.finding import find
from calib.effects.catalogue import BASE
from calib.errors import CalibrationError
from calib.fit.least_squares.solver import fit
from calib.fit.model import Model
from calib.fit.noise_size import ODDS_RARE
from calib.poses.pose_set import PoseSet
from tests.bench import study_tables as tables
from tests.bench.trial_workers import trials_on
from tests.lots import pose_sets_of
from tests.set_trials import SetOutcome, hand_design, scored
from tests.world.bench import HUMIDITY, Design
from tests.world.designs import paper_design
from tests.world.imu import mpu6050
from tests.world.lot import LotPlan, draw_lot
from tests.world.turning_lot import draw_turning_lot

HIDDEN = ("quadratic", "cubic", "asymmetry", "cross_quadratic", "temperature_bias",
          "temperature_scale", "bias_drift", "scale_drift", "warm_up", "hysteresis")
OF_GYROSCOPES = (*HIDDEN, "g_squared_sensitivity", "reference_drift", "column:humidity_pct")
EACH = 100
"""Evenings of one lot that hide one effect; as many as of all effects hide nothing."""

LISTED_HERE = 17
"""Effects of an accelerometer among which the prior of the listed ones is shared out; those that
poses at rest do not show are not hidden."""

FUNCTIONS_HERE = 4
"""Covariates among which that of unknown functions is shared out: time, temperature, the attitude
and the pose before."""

MIXED_SOUND = 900
"""Evenings of one seed of the mixture that hide nothing."""


@dataclass(frozen=True)
class Part:
    """The evenings of a seed: with an effect hidden, with nothing, and what the times were."""

    hidden: tuple[SetOutcome, ...]
    sound: tuple[SetOutcome, ...]
    refused: int
    seconds: dict[str, float]


def design_called(name: str) -> Design:
    """18 wedge poses of the paper, or 26 laid by hand."""
    if name == "hand":
        return hand_design()
    columns = {"humidity_pct": HUMIDITY} if name == "plate" else {}
    return replace(paper_design(mpu6050()), columns=columns)


def hidden_in(name: str) -> tuple[str, ...]:
    """What the evenings of a design may hide."""
    return OF_GYROSCOPES if name == "plate" else HIDDEN


def mixed(sound: int) -> list[tuple[tuple[str, ...], int]]:
    """What the mixture hides beside so many evenings with nothing, and in how many evenings."""
    odds = dict.fromkeys(HIDDEN, CONSTANTS.odds_listed / LISTED_HERE)
    odds |= {"periodic": CONSTANTS.odds_unknown / FUNCTIONS_HERE, "wander": CONSTANTS.odds_wander,
             "jump": ODDS_RARE, "bad_pose": ODDS_RARE}
    one = [((name,), share) for name, share in odds.items()]
    two = [(pair, odds[pair[0]] * odds[pair[1]]) for pair in combinations(odds, 2)]
    return [(names, round(share * sound)) for names, share in (*one, *two)]


def in_one(name: str) -> int:
    """Evenings that one seed stands for."""
    if name == "mixture":
        return MIXED_SOUND + sum(count for _, count in mixed(MIXED_SOUND))
    return 2 * EACH * len(hidden_in(name))


def evenings(
    name: str, seed: int, sizes: tuple[float, float]
) -> Iterator[tuple[tuple[str, ...], list[PoseSet]]]:
    """The pose sets of one seed of the design called ``name``, with what they hide."""
    design = design_called(name)
    lot_seed = count_from(1000 * seed)
    if name == "mixture":
        for names, count in ((), MIXED_SOUND), *mixed(MIXED_SOUND):
            hidden, beside = (*names, None, None)[:2]
            lots, each = (count, 1) if names else (1, count)  # one lot has one period, one moment
            plan = LotPlan(each, hidden=hidden, beside=beside, cauchy_sd=CONSTANTS.typical_size)
            for _ in range(lots):
                yield names, pose_sets_of(draw_lot(design, plan, next(lot_seed)))
        return
    draw = draw_turning_lot if name == "plate" else draw_lot
    for hidden in hidden_in(name):
        plan = LotPlan(EACH, hidden=hidden, own_sd=sizes)
        yield (hidden,), pose_sets_of(draw(design, plan, seed))
    yield (), pose_sets_of(draw(design, LotPlan(in_one(name) // 2), seed))


def part_of(name: str, sizes: tuple[float, float], seed: int) -> Part:
    """Draw, fit and diagnose the evenings of one seed."""
    seconds: Counter[str] = Counter()
    hidden: list[SetOutcome] = []
    sound: list[SetOutcome] = []
    refused, begun = 0, time.process_time()
    drawn = [(what, poses) for what, sets in evenings(name, seed, sizes) for poses in sets]
    seconds["drawing"] = time.process_time() - begun
    for what, poses in drawn:
        begun = time.process_time()
        try:
            one = fit(poses, Model.of(BASE))
        except CalibrationError:
            refused += 1
            continue
        fitted_at = time.process_time()
        finding = find(one)
        seconds["fitting"] += fitted_at - begun
        seconds["diagnosing"] += time.process_time() - fitted_at
        (hidden if what else sound).append(scored(seed, finding, what))
    return Part(tuple(hidden), tuple(sound), refused, dict(seconds))


BARS = (CONSTANTS.sure, 0.9, 0.95)


def names_from(hidden: Sequence[SetOutcome]) -> str:
    """Evenings with a right name and with a wrong one, were names given from a probability on."""
    lines = []
    for bar in BARS:
        told = [[each for each in o.told if each[0] >= bar] for o in hidden]
        expected = sum(1 - p for each in told for p, _ in each)
        wrong = sum(not is_right for each in told for _, is_right in each)
        right = sum(any(is_right for _, is_right in each) for each in told)
        lines.append(f"named from {bar:4.2f} on: {right} evenings right, {wrong} names wrong, "
                     f"{expected:.1f} by the stated probabilities")
    return "\n".join(lines)


def main() -> None:
    """Print the tables and the times."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("design", choices=("paper", "hand", "plate", "mixture"))
    parser.add_argument("--evenings", type=int, default=20_000)
    parser.add_argument("--sizes", type=float, nargs=2, default=(5.0, 5.0))
    parser.add_argument("--first-seed", type=int, default=0)
    parser.add_argument("--workers", type=int, default=1, help="processes of this machine")
    parser.add_argument("--scheduler", help="address of a Dask cluster")
    asked = parser.parse_args()
    low, high = asked.sizes
    count = max(1, round(asked.evenings / in_one(asked.design)))
    seeds = range(asked.first_seed, asked.first_seed + count)
    trial = partial(part_of, asked.design, (low, high))
    begun = time.perf_counter()
    with trials_on(asked.workers, asked.scheduler) as each:
        parts = [part for _, part in each(trial, seeds) if isinstance(part, Part)]
    by_the_clock = time.perf_counter() - begun
    hidden = [outcome for part in parts for outcome in part.hidden]
    sound = [outcome for part in parts for outcome in part.sound]
    count = len(hidden) + len(sound)
    what = ("what the prior has" if asked.design == "mixture"
            else f"half with one effect of {low:g} to {high:g} sd")
    wrong, falsely = (tables.share([bool(o.wrong) for o in each]) for each in (hidden, sound))
    print(f"{count} evenings, {asked.design}, seeds {seeds[0]} to {seeds[-1]}, {what}; "
          f"{sum(p.refused for p in parts)} refused; a wrong name in {wrong:.5f} of those with an "
          f"effect, in {falsely:.5f} of those without")
    print(tables.set_text(hidden, sound))
    print(names_from(hidden))
    for name in hidden_in(asked.design):
        of_one = [o for o in hidden if o.hidden == (name,)]
        if not of_one:
            continue
        print(f"{name:20s} {tables.share([bool(o.named) for o in of_one]):.3f} named as a class, "
              f"{tables.share([bool(o.single) for o in of_one]):.3f} as one, a wrong name in "
              f"{tables.share([bool(o.wrong) for o in of_one]):.4f}")
    seconds: Counter[str] = Counter()
    for part in parts:
        seconds.update(part.seconds)
    for step, total in seconds.items():
        print(f"{step:34s} {total:8.1f} s of one processor, {1e3 * total / count:7.3f} ms each")
    print(f"{by_the_clock:.0f} s by the clock")


if __name__ == "__main__":
    main()
