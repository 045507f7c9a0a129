"""How often the diagnosis finds what is hidden: sessions of the simulated bench, counted.

    python -m tests.bench.study_diagnosis rich gyroscope --sizes 2 5 10 --trials 20

prints, for every effect and size (root mean square over the pose equations, in noise units), the
share of trials in which the true effect, or one that these poses cannot tell from it, was ranked
first and was named, in which something else was named, and what the error fell to.
"""

import argparse
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from calib.catalogue import BASE
from calib.compare import compare
from calib.diagnose import diagnose
from calib.errors import CalibrationError
from calib.model import Model
from calib.poses import PoseSet
from calib.solver import fit
from tests.fitting import pose_sets
from tests.world.bench import Design
from tests.world.designs import paper_design, rich_design, soak_design
from tests.world.hidden import GYROSCOPE_ONLY, Hidden
from tests.world.session import simulate
from tests.world.sizes import draw_effect

DESIGNS = {"paper": paper_design, "rich": rich_design, "soak": soak_design}
LISTED = (
    "quadratic",
    "cubic",
    "asymmetry",
    "cross_quadratic",
    "temperature_bias",
    "temperature_scale",
    "bias_drift",
    "scale_drift",
    "warm_up",
    "hysteresis",
    "vibration_rectification",
    "g_sensitivity",
    "g_squared_sensitivity",
    "reference_offset",
    "reference_drift",
    "direction_dependent_rate",
)
EQUIVALENT = {"reference_drift": "scale_drift"}
"""A drift of the plate is a drift of all gains alike: finding one is finding the other."""


@dataclass(frozen=True)
class Outcome:
    """One trial: what was hidden, what was said, and the whitened errors before and after."""

    hidden: str
    size: float
    visible: bool
    first: bool
    named: bool
    named_wrong: bool
    verdict: str
    rms_before: float
    rms_after: float
    loo_after: float


def poses_of(design: Design, seed: int, triad: str, hidden: Sequence[Hidden]) -> PoseSet:
    """The poses of ``triad`` of one evening."""
    accelerometer, gyroscope, _ = pose_sets(simulate(design, seed, tuple(hidden)))
    return accelerometer if triad == "accelerometer" else gyroscope


def _whitened(rows: np.ndarray) -> float:
    return float(np.sqrt(np.mean(rows**2)))


def run_trial(design: Design, seed: int, triad: str, hidden: Sequence[Hidden]) -> Outcome:
    """Hide, calibrate, diagnose, add what was named."""
    poses = poses_of(design, seed, triad, hidden)
    base = fit(poses, Model.of(BASE))
    found = diagnose(base)
    names = {h.name for h in hidden}
    right = names | {EQUIVALENT[n] for n in names if n in EQUIVALENT}
    listed = [c for c in found.ranking if c.kind == "listed"]
    top = {listed[0].name, *listed[0].aliases} if listed else set()
    is_named = found.verdict == "effect"
    after = base
    if is_named and found.name is not None:
        try:
            after = fit(poses, Model.of((*BASE, found.name)))
        except CalibrationError:
            after = base  # named, but these poses cannot carry it
    return Outcome(
        hidden="+".join(sorted(names)) or "none",
        size=0.0,
        visible=not names & set(found.blind),
        first=bool(top & right),
        named=is_named and bool(set(found.group) & right),
        named_wrong=is_named and not set(found.group) & right,
        verdict=found.verdict,
        rms_before=_whitened(base.rows.residual),
        rms_after=_whitened(after.rows.residual),
        loo_after=compare(after).loo_rms / float(np.sqrt(np.mean(after.equations.row_sd**2))),
    )


def outcomes(
    design_name: str, triad: str, names: Sequence[str], sizes: Sequence[float], trials: int
) -> Iterator[tuple[str, float, list[Outcome]]]:
    """The trials of every effect and size."""
    design = DESIGNS[design_name]()
    for name in names:
        for size in sizes if name != "none" else (0.0,):
            found = []
            for seed in range(trials):
                try:
                    hidden = (
                        [] if name == "none" else [draw_effect(name, triad, size, design, seed)]
                    )
                except ValueError:  # does not reach these pose equations at all
                    break
                found.append(run_trial(design, seed, triad, hidden))
            if found:
                yield name, size, found


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("design", choices=DESIGNS)
    parser.add_argument("triad", choices=("accelerometer", "gyroscope"))
    parser.add_argument("--effects", nargs="+", default=["none", *LISTED])
    parser.add_argument("--sizes", nargs="+", type=float, default=[2.0, 5.0, 10.0])
    parser.add_argument("--trials", type=int, default=20)
    asked = parser.parse_args()
    names = [n for n in asked.effects if asked.triad == "gyroscope" or n not in GYROSCOPE_ONLY]
    print(f"{'hidden':26s} size visible first named wrong   rms -> after   loo  verdicts")
    for name, size, found in outcomes(asked.design, asked.triad, names, asked.sizes, asked.trials):
        share = {
            key: np.mean([getattr(o, key) for o in found])
            for key in ("visible", "first", "named", "named_wrong")
        }
        verdicts = {v: sum(o.verdict == v for o in found) for v in {o.verdict for o in found}}
        print(
            f"{name:26s} {size:4.0f} {share['visible']:7.2f} {share['first']:5.2f} "
            f"{share['named']:5.2f} {share['named_wrong']:5.2f} "
            f"{np.mean([o.rms_before for o in found]):6.2f} -> "
            f"{np.mean([o.rms_after for o in found]):5.2f} "
            f"{np.mean([o.loo_after for o in found]):5.2f}  {verdicts}",
            flush=True,
        )


if __name__ == "__main__":
    main()
