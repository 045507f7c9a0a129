"""How often a sound session is refused or doubted, by the class of its sensor.

    python -m tests.bench.study_false_alarms --sessions 40 [--class NAME]

Every session is a fresh evening with another unit, in turn the paper's design (one speed) and the
rich one (two speeds, both directions, stopped), with nothing hidden. Counted are refusals, warnings
that are no remark on short poses, and verdicts other than that nothing is missing; and how many
stated sds the parameters are off. The seeds are not used in any test.
"""

import argparse
import tempfile
from collections import Counter
from pathlib import Path

import numpy as np

from tests.attack.judged import judge
from tests.calib.fit.least_squares.coverage import another_evening
from tests.world.designs import paper_design, rich_design
from tests.world.imu import Sensor
from tests.world.sensor_classes import sensors
from tests.world.session import simulate
from tests.world.write import write_session

FIRST_SEED = 97_000
SAMPLE_RATE = 0.5  #: of the designs' rates, to halve the time
FASTEST_RAD_S = 4.0  #: of the rich design, with an offset; a smaller range has the paper's alone
REMARKS = ("are short", "frozen blocks")
"""Warnings that a sound session may have: what a pose was too short for, readings held."""


def main() -> None:
    """Print a line for each class."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--sessions", type=int, default=40)
    parser.add_argument("--class", dest="only")
    options = parser.parse_args()
    print(f"{'class':36} {'n':>4} refused warned other  rms z, largest", flush=True)
    for name, sensor in sensors(100 * SAMPLE_RATE).items():
        if options.only in (None, name):
            print(line_of(name, sensor, options.sessions), flush=True)


def line_of(name: str, sensor: Sensor, sessions: int) -> str:
    """The counts of a class, and below them the words."""
    counts: Counter[str] = Counter()
    off: list[np.ndarray] = []
    words = []
    for k in range(sessions):
        seed = FIRST_SEED + k
        rich = k % 2 == 1 and sensor.gyroscope.full_scale > FASTEST_RAD_S
        design = (rich_design if rich else paper_design)(sensor).scaled(sample_rate=SAMPLE_RATE)
        session = simulate(another_evening(design, seed), seed)
        with tempfile.TemporaryDirectory() as folder:
            judged = judge(write_session(Path(folder), session, film=False).config, session)
        warned = [each for each in judged.warnings if not any(word in each for word in REMARKS)]
        others = [each for each in judged.verdicts.values() if each != "nothing_missing"]
        if judged.refusal:
            counts["refused"] += 1
            words.append(f"{k}: {judged.refusal}")
        elif warned or others:
            counts["warned" if warned else "other"] += 1
            words += [f"{k}: {each}" for each in (*warned, *others)]
        off += list(judged.off.values())
    z = np.concatenate([each.ravel() for each in off]) if off else np.zeros(1)
    line = (f"{name:36} {sessions:4d} {counts['refused']:7d} {counts['warned']:6d} "
            f"{counts['other']:5d}  {np.sqrt(np.nanmean(z**2)):.2f}, {np.nanmax(np.abs(z)):.1f}")
    return "\n    ".join([line, *words])


if __name__ == "__main__":
    main()
