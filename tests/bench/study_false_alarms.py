"""How often a sound session is refused or doubted, by the class of its sensor.

    python -m tests.bench.study_false_alarms --sessions 40 [--class NAME] [--hidden]

Every session is a fresh evening with another unit, in turn the paper's design (one speed) and the
rich one (two speeds, both directions, stopped), with nothing hidden, or two thirds of them with
effects as large as data sheets have them. Counted are refusals, warnings that are no remark on
short poses, and verdicts other than that nothing is missing; and how many stated sds the parameters
are off. The seeds are not used in any test.
"""

import argparse
import tempfile
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from tests.attack.judged import judge
from tests.calib.fit.least_squares.coverage import another_evening
from tests.world.designs import paper_design, rich_design
from tests.world.hidden import Hidden
from tests.world.imu import Sensor
from tests.world.sensor_classes import sensors
from tests.world.session import simulate
from tests.world.write import write_session

FIRST_SEED = 97_000
SAMPLE_RATE = 0.5  #: of the designs' rates, to halve the time
FASTEST_RAD_S = 4.0  #: of the rich design, with an offset; a smaller range has the paper's alone
REMARKS = ("are short", "frozen blocks")
"""Warnings that a sound session may have: what a pose was too short for, readings held."""


ONES = np.array([1.0, -0.7, 0.4])
HIDDEN: tuple[tuple[Hidden, ...], ...] = (
    (),
    (Hidden("g_sensitivity", "gyroscope", 1e-4 * np.outer(ONES, ONES[::-1])),),
    (Hidden("quadratic", "gyroscope", 1e-3 * ONES),),
    (),
    (Hidden("quadratic", "accelerometer", 2e-4 * ONES),),
    (Hidden("bias_drift", "gyroscope", 1e-6 * ONES),),
)
"""Sizes of data sheets: 0.06 °/s per g, 0.1 % of 1 rad/s, 20 mg/g², 0.2 °/s in an hour."""


def main() -> None:
    """Print a line for each class."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--sessions", type=int, default=40)
    parser.add_argument("--first", type=int, default=FIRST_SEED)
    parser.add_argument("--class", dest="only")
    parser.add_argument("--hidden", action="store_true")
    options = parser.parse_args()
    print(f"{'class':36} {'n':>4} refused warned other  rms z, largest", flush=True)
    for name, sensor in sensors(100 * SAMPLE_RATE).items():
        if options.only in (None, name):
            seeds = range(options.first, options.first + options.sessions)
            found = counted(sensor, seeds, HIDDEN if options.hidden else ((),))
            print(line_of(name, found, options.sessions), flush=True)


@dataclass(frozen=True)
class Counted:
    """Sessions that were refused, warned of or given another verdict, why, and errors in sds."""

    counts: Counter[str]
    words: list[str]
    off: list[np.ndarray]


def counted(sensor: Sensor, seeds: range, hidden: Sequence[tuple[Hidden, ...]]) -> Counted:
    """What comes of the sessions of a class with these seeds."""
    found = Counted(Counter(), [], [])
    for k, seed in enumerate(seeds):
        rich = k % 2 == 1 and sensor.gyroscope.full_scale > FASTEST_RAD_S
        design = (rich_design if rich else paper_design)(sensor).scaled(sample_rate=SAMPLE_RATE)
        session = simulate(another_evening(design, seed), seed, hidden[k // 2 % len(hidden)])
        with tempfile.TemporaryDirectory() as folder:
            judged = judge(write_session(Path(folder), session, film=False).config, session)
        warned = [one for one in judged.warnings if not any(word in one for word in REMARKS)]
        others = [one for one in judged.verdicts.values() if one != "nothing_missing"]
        if judged.refusal:
            found.counts["refused"] += 1
            found.words.append(f"{seed}: {judged.refusal}")
        elif warned or others:
            found.counts["warned" if warned else "other"] += 1
            found.words.extend(f"{seed}: {one}" for one in (*warned, *others))
        found.off.extend(judged.off.values())
    return found


def line_of(name: str, found: Counted, sessions: int) -> str:
    """The counts of a class, and below them the words."""
    z = np.concatenate([off.ravel() for off in found.off]) if found.off else np.zeros(1)
    counts = found.counts
    line = (f"{name:36} {sessions:4d} {counts['refused']:7d} {counts['warned']:6d} "
            f"{counts['other']:5d}  {np.sqrt(np.nanmean(z**2)):.2f}, {np.nanmax(np.abs(z)):.1f}")
    return "\n    ".join([line, *found.words])


if __name__ == "__main__":
    main()
