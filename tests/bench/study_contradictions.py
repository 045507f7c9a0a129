"""How often an ordinary session is contradicted: simulated evenings, refusals and warnings counted.

    python -m tests.bench.study_contradictions --sessions 200

Every session is a fresh evening with another unit of the sensor, in turn the paper's (one speed)
and the rich one (two speeds, both directions, stopped), with nothing hidden or one hidden effect.
Printed are all refusals and the warnings that are no remark on short poses. The seeds are not used
in any test.
"""

import argparse
import contextlib
import io
import tempfile
from pathlib import Path

import numpy as np

from pipeline import cli
from tests.calib.fit.coverage import another_evening
from tests.world.designs import paper_design, rich_design
from tests.world.hidden import Hidden
from tests.world.session import simulate
from tests.world.write import write_session

FIRST_SEED = 91_000
SAMPLE_RATE = 0.4
"""Of the designs' rates, to halve the time."""

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
    """Print the contradictions and their number."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--sessions", type=int, default=200)
    asked = parser.parse_args()
    refused = warned = 0
    for k in range(asked.sessions):
        code, said = outcome_of(k)
        refused += code != 0
        lines = [line for line in said.splitlines() if "are short" not in line]
        warned += bool(lines) and code == 0
        for line in lines:
            print(f"{k} (exit {code}): {line}", flush=True)
    print(f"{asked.sessions} sessions: {refused} refused, {warned} warned")


def outcome_of(k: int) -> tuple[int, str]:
    """Exit code and standard error of `pipeline run` on session ``k``."""
    design = (paper_design, rich_design)[k % 2]().scaled(sample_rate=SAMPLE_RATE)
    seed = FIRST_SEED + k
    session = simulate(another_evening(design, seed), seed, HIDDEN[k // 2 % len(HIDDEN)])
    error = io.StringIO()
    with (tempfile.TemporaryDirectory() as folder, contextlib.redirect_stderr(error),
          contextlib.redirect_stdout(io.StringIO())):
        written = write_session(Path(folder), session, film=False)
        return cli.main(["run", str(written.config)]), error.getvalue()


if __name__ == "__main__":
    main()
