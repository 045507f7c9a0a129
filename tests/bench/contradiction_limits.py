"""What halving and doubling each limit of the contradiction checks does.

    python -m tests.bench.contradiction_limits [--sessions 4] [--only NAME]

Each limit is multiplied by a half and by two. Printed are the ordinary sessions that are then
refused or warned of, and those mistakes of the corpus (``tests/attack``) which the limit decides
that are no longer refused by their name.
"""

import argparse
import contextlib
import io
import shutil
import sys
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

from calib.poses import data_sheet as spec
from calib.poses.averaging import sway
from calib.poses.checks import frozen, pose_checks
from pipeline.stages import session_logs
from tests.attack.mistakes import CASES
from tests.attack.spoilt import copy_of, write_base
from tests.bench.study_contradictions import outcome_of
from tests.sessions import pipeline

FACTORS = (0.5, 2.0)
FIRST = 700
"""Number of the first ordinary session; those of ``study_contradictions`` begin at 0."""

RUNS = ("rates exchanged, gyroscope alone",)
COPIES = ("the same files under new names", "a copied block", "a pose that froze")
MOVED = ("a pose turned to and fro", "a pose turned half way", "moved on the plate",
         "a pose that rocks", "a dead axis of the accelerometer",
         "a dead axis of the gyroscope in one run")
#: Module, limits, and the mistakes of the corpus that they decide. Those of ``calib.consistency``
#: are held by tests on arrays: ``tests.bench.tested_thresholds``.
LIMITS: tuple[tuple[object, Sequence[str], Sequence[str]], ...] = (
    (spec, ("LARGEST_DRIFT",), ()),
    (frozen, ("FALSE_ALARM",), (*RUNS, *COPIES)),
    (session_logs, ("OTHER_UNIT",), ("milliseconds",)),
    (pose_checks, ("LARGEST_SHIFT_SD", "LARGEST_TURN", "MUST_MOVE", "STANDS_STILL"), MOVED),
    (pose_checks, ("RAIL_SHARE", "LARGEST_RATE_CHANGE"), ()),
    (sway, ("NOTICEABLE_M_S2",), ()),
)


@contextmanager
def changed(module: object, name: str, factor: float) -> Iterator[None]:
    """Another value of a limit, in every module that has imported it."""
    value = getattr(module, name)
    holders = [each for path, each in list(sys.modules.items())
               if path.split(".")[0] in ("calib", "pipeline") and vars(each).get(name) is value]
    for each in holders:
        setattr(each, name, value * factor)
    try:
        yield
    finally:
        for each in holders:
            setattr(each, name, value)


def missed(base: Path, names: Sequence[str]) -> list[str]:
    """Those of the mistakes that are not refused by their name."""
    out = []
    for case in names:
        name, spoil, _, code, said = CASES[case]
        with tempfile.TemporaryDirectory() as folder:
            config = copy_of(base, name, Path(folder))
            spoil(config)
            printed = io.StringIO()
            with contextlib.redirect_stderr(printed), contextlib.redirect_stdout(io.StringIO()):
                ended = pipeline("check", config)
            if ended != code or any(part not in printed.getvalue() for part in said.split("|")):
                out.append(case)
            shutil.rmtree(config.parent)
    return out


def contradicted(sessions: int) -> int:
    """How many ordinary sessions are refused or warned of."""
    return sum(bool(outcome_of(FIRST + k)[1]) for k in range(sessions))


def main() -> None:
    """Print a line for each value of each limit."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--sessions", type=int, default=4)
    parser.add_argument("--only")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        base = Path(folder)
        write_base(base)
        print(f"{'limit':28} {'value':>9}  ordinary contradicted, mistakes missed")
        for module, names, cases in LIMITS:
            for name in names:
                if options.only not in (None, name):
                    continue
                for factor in FACTORS:
                    with changed(module, name, factor):
                        print(f"{name:28} {getattr(module, name):9.3g}  "
                              f"{contradicted(options.sessions)} of {options.sessions}, "
                              f"{len(each := missed(base, cases))} of {len(cases)}"
                              f"{': ' + ', '.join(each) if each else ''}", flush=True)


if __name__ == "__main__":
    main()
