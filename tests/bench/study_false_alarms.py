"""How often a sound session is refused or doubted, by the class of its sensor.

    python -m tests.bench.study_false_alarms --sessions 40 [--class NAME] [--hidden]

Every session is a fresh evening with another unit, in turn the paper's design (one speed) and the
rich one (two speeds, both directions, stopped), with nothing hidden, or two thirds of them with
effects as large as data sheets have them. Counted are refusals, warnings that are no remark on
short poses, and verdicts other than that nothing is missing; and how many stated sds the parameters
are off. The seeds are not used in any test.
"""

import argparse

import numpy as np

from tests.attack.sound_sessions import SAMPLE_RATE, Counted, counted
from tests.world.hidden import Hidden
from tests.world.sensor_classes import sensors

FIRST_SEED = 97_000
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


def line_of(name: str, found: Counted, sessions: int) -> str:
    """The counts of a class, and below them the words."""
    z = np.concatenate([off.ravel() for off in found.off]) if found.off else np.zeros(1)
    counts = found.counts
    line = (f"{name:36} {sessions:4d} {counts['refused']:7d} {counts['warned']:6d} "
            f"{counts['other']:5d}  {np.sqrt(np.nanmean(z**2)):.2f}, {np.nanmax(np.abs(z)):.1f}")
    return "\n    ".join([line, *found.words])


if __name__ == "__main__":
    main()
