"""How often an ordinary session is contradicted: simulated evenings, refusals and warnings counted.

    python -m tests.bench.study_contradictions --sessions 200

Every session is a fresh evening with another unit of the sensor, in turn the paper's (one speed)
and the rich one (two speeds, both directions, stopped), with nothing hidden or one hidden effect.
Printed are all refusals and the warnings that are no remark on short poses. The seeds are not used
in any test.
"""

import argparse
import tempfile
from pathlib import Path

import numpy as np

from calib.errors import CalibrationError
from pipeline.config.load import load_config
from pipeline.errors import PipelineError
from pipeline.stages.context import RunContext
from pipeline.stages.run import run_stages
from tests.calib.fit.least_squares.coverage import another_evening
from tests.world.designs import paper_design, rich_design
from tests.world.hidden import Hidden
from tests.world.session import simulate
from tests.world.write import write_session

FIRST_SEED = 95_000
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
        is_refused, words = outcome_of(k)
        refused += is_refused
        warned += bool(words) and not is_refused
        for each in words:
            print(f"{k}: {each}", flush=True)
        if k % 20 == 19:
            print(f"{k + 1} sessions: {refused} refused, {warned} warned", flush=True)


def outcome_of(k: int) -> tuple[bool, list[str]]:
    """Whether session ``k`` is refused, and by what words; else its warnings."""
    design = (paper_design, rich_design)[k % 2]().scaled(sample_rate=SAMPLE_RATE)
    seed = FIRST_SEED + k
    session = simulate(another_evening(design, seed), seed, HIDDEN[k // 2 % len(HIDDEN)])
    with tempfile.TemporaryDirectory() as folder:
        written = write_session(Path(folder), session, film=False)
        try:
            outcome = run_stages(load_config(written.config), RunContext())
        except (PipelineError, CalibrationError) as error:
            return True, [str(error)]
        return False, [each for each in outcome.warnings if "are short" not in each]


if __name__ == "__main__":
    main()
