"""What a lot shows that one sensor cannot: how often the pool is right, on simulated lots.

    python -m tests.bench.study_population --lots 100 --sensors 100 --first-seed 70000
    python -m tests.bench.study_population --design soak --lots 20 --sizes 0.25 0.5 1
    python -m tests.bench.study_population --lots 1000 --sensors 100 --only-nothing

Lots of accelerometers of one make (``tests.world.lot``), fitted and scored one by one. First lots
in which nothing is missing, with sds that are right, with sds that are all 5 % too small, and with
a bias that differs from evening to evening: the share of lots in which the pool names something (a
false alarm). Then an effect in each sensor, of one size in all of them, or of sizes that scatter
about zero: the share of lots in which it is named as such or in a class with it, and in which
something else is named. Sizes are root mean squares over the pose equations in noise units; the
last column is the share of single sensors whose own evidence, at the same level, shows the effect.
"""

import argparse
import time
from collections.abc import Callable, Iterator
from dataclasses import replace

from calib.diagnosis.population.evidence import evidence_of
from calib.diagnosis.population.lot import LotEvidence
from calib.diagnosis.population.pool import FALSE_ALARM, Pool, judge, pool
from calib.diagnosis.population.sums import sums_of
from calib.effects.catalogue import BASE
from calib.fit.least_squares.solver import fit
from calib.fit.model import Model
from tests.lots import pose_sets_of
from tests.world.bench import Design
from tests.world.designs import paper_design, soak_design
from tests.world.imu import mpu6050
from tests.world.lot import Lot, LotPlan, draw_lot

HIDDEN = ("quadratic", "cubic", "asymmetry", "cross_quadratic", "temperature_bias",
          "temperature_scale", "bias_drift", "hysteresis")
DESIGNS: dict[str, Callable[[], Design]] = {
    "paper": lambda: paper_design(mpu6050()), "soak": soak_design,
}


def lots_of(
    design: Design, plan: LotPlan, asked: argparse.Namespace, widened: float = 1.0
) -> Iterator[LotEvidence]:
    """The evidence of every lot, ``widened`` times its noise over what is stated."""
    for seed in range(asked.first_seed, asked.first_seed + asked.lots):
        lot: Lot = draw_lot(design, plan, seed)
        sets = pose_sets_of(replace(lot, sd_counts=lot.sd_counts / widened))
        names = [f"{unit}" for unit in lot.unit]
        lot_evidence = LotEvidence.of((name, evidence_of(fit(poses, Model.of(BASE))))
                                      for name, poses in zip(names, sets, strict=True))
        assert lot_evidence is not None
        yield lot_evidence


def share_named(pools: list[Pool]) -> float:
    return sum(bool(each.effects) for each in pools) / len(pools)


def nothing(design: Design, asked: argparse.Namespace) -> int:
    """False alarms; the number of evenings."""
    cases = {
        "sds right": (LotPlan(asked.sensors), 1.0),
        "sds 5 % too small": (LotPlan(asked.sensors), 1.05),
        "three evenings each, bias moves by 3 sd": (
            LotPlan(asked.sensors // 3, evenings=3, evening_sd=3.0), 1.0),
    }
    evenings = 0
    for name, (plan, widened) in cases.items():
        pools = [pool_of(lot) for lot in lots_of(design, plan, asked, widened)]
        evenings += plan.sensors * plan.evenings * len(pools)
        print(f"nothing missing, {name:40s} {len(pools)} lots: an effect named in "
              f"{100 * share_named(pools):.2f} % ({100 * FALSE_ALARM:.0f} % is the level)",
              flush=True)
    return evenings


def effects(design: Design, asked: argparse.Namespace) -> int:
    """Detection of each effect in each form; the number of evenings."""
    print("effect               size   form     lots  named  in a class  another  one sensor shows")
    evenings = 0
    for name in asked.effects:
        for size in asked.sizes:
            for form in ("common", "spread"):
                plan = LotPlan(asked.sensors, hidden=name, **{f"{form}_sd": size})
                alone, right, among, wrong, count = 0.0, 0, 0, 0, 0
                for lot in lots_of(design, plan, asked):
                    evenings += len(lot)
                    count += 1
                    found = pool_of(lot).effects
                    right += any(each.name == name for each in found)
                    among += any(name in (each.name, *each.alternatives) for each in found)
                    wrong += any(name not in (each.name, *each.alternatives) for each in found)
                    alone += shown_alone(lot, name)
                print(f"{name:20s} {size:5.2f}  {form}  {count:5d}  {right / count:5.2f}  "
                      f"{among / count:10.2f}  {wrong / count:7.2f}  {alone / count:8.3f}",
                      flush=True)
    return evenings


def pool_of(lot: LotEvidence) -> Pool:
    return pool(lambda _trials: [lot])


def session(lot: LotEvidence, i: int) -> LotEvidence:
    """The lot of one session alone."""
    rows = {name: value[i : i + 1] for name, value in vars(lot).items() if name != "trials"}
    return LotEvidence(trials=lot.trials, **rows)


def shown_alone(lot: LotEvidence, name: str) -> float:
    """Share of the first sensors that show the effect by themselves, all candidates counted."""
    trials = [trial for trial in lot.trials if trial.name == name]
    level = FALSE_ALARM / len(lot.trials)
    first = [session(lot, i) for i in range(min(10, len(lot)))]
    shown = [any((seen := judge(trial, sums_of(one, trial))) is not None and seen.p_any < level
                 for trial in trials) for one in first]
    return sum(shown) / len(shown)


def main() -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--design", choices=list(DESIGNS), default="paper")
    parser.add_argument("--lots", type=int, default=20)
    parser.add_argument("--sensors", type=int, default=100)
    parser.add_argument("--sizes", type=float, nargs="+", default=[0.5])
    parser.add_argument("--effects", nargs="+", choices=HIDDEN, default=list(HIDDEN))
    parser.add_argument("--first-seed", type=int, default=0)
    parser.add_argument("--only-nothing", action="store_true")
    asked = parser.parse_args()
    design = DESIGNS[asked.design]()
    begun, cpu = time.perf_counter(), time.process_time()
    evenings = nothing(design, asked)
    if not asked.only_nothing:
        evenings += effects(design, asked)
    print(f"{evenings} simulated evenings of {asked.sensors} sensors a lot, design {asked.design}: "
          f"{time.process_time() - cpu:.0f} s of one processor, {time.perf_counter() - begun:.0f} "
          f"s by the clock")


if __name__ == "__main__":
    main()
