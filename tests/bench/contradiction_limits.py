"""What halving and doubling each limit of the contradiction checks does.

    python -m tests.bench.contradiction_limits [--sessions 4] [--only NAME]

Each limit is multiplied by a half and by two. Printed are the ordinary sessions that are then
refused or warned of, and how many mistakes of the kinds that the limit decides, drawn from the
grammar of ``tests/attack`` with fixed seeds, are then silent or claimed to be others.
"""

import argparse
import tempfile
from collections.abc import Sequence
from itertools import product
from pathlib import Path
from types import ModuleType

from calib.poses import data_sheet as spec
from calib.poses.averaging import sway
from calib.poses.checks import frozen, pose_checks
from pipeline.stages import session_logs
from tests.attack.grammar import drawn
from tests.bench.study_false_alarms import SAMPLE_RATE, counted
from tests.bench.threshold_records import FACTORS, changed, multiplied
from tests.world.sensor_classes import sensors

FIRST = 720_000  #: seed of the first ordinary session, and of the first mistake
DRAWN = 4  #: of each kind
MOVED = ("turned", "turned back", "dead axis")
#: Module, limits, and the kinds of mistakes that they decide. Those of ``calib.consistency`` are
#: held by tests on arrays: ``tests.bench.tested_thresholds``.
LIMITS: tuple[tuple[ModuleType, Sequence[str], Sequence[str]], ...] = (
    (spec, ("LARGEST_DRIFT",), ()),
    (frozen, ("FALSE_ALARM",), ("files", "copy", "frozen")),
    (session_logs, ("OTHER_UNIT",), ("clock",)),
    (pose_checks, ("LARGEST_SHIFT_SD", "LARGEST_TURN", "MUST_MOVE", "STANDS_STILL"), MOVED),
    (pose_checks, ("RAIL_SHARE", "LARGEST_RATE_CHANGE"), ()),
    (sway, ("NOTICEABLE_M_S2",), ()),
)


def missed(kinds: Sequence[str]) -> list[str]:
    """Mistakes that are silent, or claimed to be others."""
    out = []
    for what, seed in product(kinds, range(FIRST, FIRST + DRAWN)):
        attack = drawn(seed, what)
        with tempfile.TemporaryDirectory() as folder:
            if attack.outcome(attack.judged(Path(folder)))[0] in ("silent", "wrong"):
                out.append(attack.words)
    return out


def contradicted(sessions: int) -> int:
    """How many ordinary sessions are refused or warned of."""
    sensor = sensors(100 * SAMPLE_RATE)["Xsens MTi"]
    counts = counted(sensor, range(FIRST, FIRST + sessions), ((),)).counts
    return counts["refused"] + counts["warned"]


def main() -> None:
    """Print a line for each value of each limit."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--sessions", type=int, default=4)
    parser.add_argument("--only")
    options = parser.parse_args()
    print(f"{'limit':28} {'value':>9}  ordinary contradicted, mistakes missed")
    for module, names, kinds in LIMITS:
        for name in names:
            if options.only not in (None, name):
                continue
            for factor in FACTORS:
                value = multiplied(getattr(module, name), factor)
                with changed(module.__name__, name, value):
                    out = missed(kinds)
                    print(f"{name:28} {value:9.3g}  "
                          f"{contradicted(options.sessions)} of {options.sessions}, "
                          f"{len(out)} of {DRAWN * len(kinds)}"
                          f"{': ' + ', '.join(out) if out else ''}", flush=True)


if __name__ == "__main__":
    main()
