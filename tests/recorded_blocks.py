"""The block of poses that a diagnosis asks for, recorded on the simulated bench.

The evening goes on with the same unit and the same hidden physics; the new poses are joined to
the old ones as one session, as a user does who names the new logs in the configuration.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from calib.diagnosis.diagnose import diagnose
from calib.effects.catalogue import BASE, find_effect
from calib.fit.least_squares.solver import fit
from calib.fit.model import Model
from tests.fitting import pose_sets
from tests.trials import COMMON_PARTS, said_names
from tests.world.bench import Design, corner_directions, wedge_directions
from tests.world.bench import Run as BenchRun
from tests.world.designs import FAST, SLOW, still_run
from tests.world.designs import turning_run as turning
from tests.world.hidden import Hidden
from tests.world.physics import triad_of
from tests.world.plate import PlateMotion
from tests.world.session import simulate

TILT_RAD = float(np.radians(9.0))
SOAK_C = 20.0


@dataclass(frozen=True)
class Settled:
    """An open verdict, the block that was recorded, and what was said then.

    ``right`` says whether the hidden effect is named at last, alone or with what is part of it.
    """

    seed: int
    before: tuple[str, ...]
    block: str | None
    verdict: str
    after: tuple[str, ...]
    right: bool


def block_runs(code: str, triad: str) -> tuple[BenchRun, ...]:
    """The runs that the advice ``code`` asks for."""
    wedge = wedge_directions()
    if triad == "accelerometer":
        return {
            "corners": (still_run(corner_directions(), "corners"),),
            "repeat": (still_run(wedge, "repeat"),),
            "soak": (
                still_run(wedge, "warm", soak_c=SOAK_C, lead_s=1800.0),
                still_run(wedge, "cooled", lead_s=5400.0),
            ),
        }[code]
    slow, fast = PlateMotion(SLOW), PlateMotion(FAST)
    return {
        "stopped": (still_run(wedge, "rest"),),
        "speed": (turning("another speed", fast, wedge),),
        "direction": (turning("other way", PlateMotion(-SLOW), wedge),),
        "tilt": (turning("tilted", slow, wedge),),
        "repeat": (turning("repeat", slow, wedge),),
        "clips": (turning("clips", slow, wedge),),
        "corners": (turning("corners", slow, corner_directions()),),
        "soak": (
            replace(turning("warm", slow, wedge), soak_c=SOAK_C, lead_s=1800.0),
            replace(turning("cooled", slow, wedge), lead_s=5400.0),
        ),
    }[code]


def block_design(design: Design, code: str, triad: str) -> Design:
    """The evening that goes on after ``design`` with the block ``code``."""
    first, *rest = block_runs(code, triad)
    first = replace(first, lead_s=first.lead_s + design.end_s)
    table = design.turntable
    if code == "tilt":
        table = replace(table, tilt_rad=(TILT_RAD, 0.0))
    return replace(design, runs=(first, *rest), turntable=table, rests_count_for_gyroscope=True)


def settle(design: Design, seed: int, triad: str, hidden: Sequence[Hidden]) -> Settled | None:
    """Diagnose; where it stays open, record what is advised and diagnose again. None if settled."""
    session = simulate(design, seed, tuple(hidden))
    full_scale = triad_of(design, triad).full_scale
    found = diagnose(fit(pose_sets(session, triad=triad)[1], Model.of(BASE)), (), full_scale)
    if found.verdict not in ("effect", "ambiguous") or found.addable:
        return None
    if found.advice is None:
        return Settled(seed, found.group, None, found.verdict, found.group, False)
    # A clip with each pose measures whatever the plate does: it errs in none of them.
    remaining = [h for h in hidden
                 if found.advice.block != "clips" or find_effect(h.name).acts_on != "reference"]
    more = simulate(block_design(design, found.advice.block, triad), seed, tuple(remaining))
    _, poses, _ = pose_sets(session, more, triad=triad)
    after = diagnose(fit(poses, Model.of(BASE)), (), full_scale)
    names = {h.name for h in hidden}
    right = names.union(*(COMMON_PARTS.get(name, set()) for name in names))
    said = said_names(after)
    one = after.verdict == "effect" and (len(after.group) == 1 or set(after.group) <= right)
    return Settled(
        seed=seed,
        before=found.group,
        block=found.advice.block,
        verdict=after.verdict,
        after=said or after.group,
        right=one and bool(set(said) & right),
    )
