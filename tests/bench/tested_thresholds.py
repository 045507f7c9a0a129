"""Which tests fail with a threshold halved, doubled, or switched off.

    python -m tests.bench.tested_thresholds [--only MODULE[.NAME]]

For thresholds that a few quick tests hold: how sensors are mounted, how pose means are weighed,
which samples froze, what the noise of a log shows, what a lot shows, what a recording does. Tests
are real cases with an answer that is known otherwise; one that fails may mean that the answer is
wrong, or that a message states the threshold. "No case fails" means that no case is near. A
threshold is switched off at zero or at infinity (a count at a million): of the two the one with
which fewer tests fail stands under "off", since the other leaves the condition always true.
"""

import argparse
import math
import os
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, redirect_stdout
from importlib import import_module
from types import ModuleType
from typing import Any

import pytest

from tests.paths import ROOT

FACTORS = (0.5, 2.0)
MANY = 1_000_000  #: in the place of infinity where a threshold is a count
#: Module, thresholds, and the tests that hold them.
HELD: tuple[tuple[str, Sequence[str], Sequence[str]], ...] = (
    ("pipeline.record.pose_detector", (
        "HOP_S", "WINDOW_HOPS", "STEADY_HOPS", "CEILING", "MOVED_RATIO", "STEADY_CHANGE",
        "STEADY_SD", "MOVED_DEG", "SAME_SPEED"), ("pipeline/record/test_pose_detector.py",)),
    ("calib.poses.averaging.average_pose", ("LEAST_PER_TURN", "LONGEST_PAUSE"),
     ("calib/poses/test_averaging.py",)),
    ("calib.poses.averaging.mean_noise", (
        "LEAST_BY_CHANCE", "LARGEST_FACTOR", "SIMILAR_LENGTH", "NOISE_DOF_PER_POSE", "SHORTEST_S"),
     ("calib/poses/test_averaging.py", "calib/poses/test_mean_sds.py")),
    ("calib.poses.samples.batches", ("SEEN_CHI2",), ("calib/poses",)),
    ("calib.poses.averaging.drift_within", ("FEWEST_OTHERS",),
     ("calib/poses/test_drift_within.py",)),
    ("calib.poses.checks.frozen", ("FALSE_ALARM", "SHORTEST_BLOCK"),
     ("calib/poses/test_frozen.py",)),
    ("calib.poses.reference", ("PLAUSIBLE_RATIO",), ("calib/poses/test_runs.py",)),
    ("calib.poses.runs.reference_runs", ("TURNING_RAD_S",),
     ("calib/poses/test_runs.py", "calib/mounting")),
    ("calib.mounting.levelling", ("STEEPEST_FLOOR_RAD", "REVERSAL_SD_RAD"), ("calib/mounting",)),
    ("calib.mounting.heading", (
        "MEAN_S", "STRETCH_MEANS", "LARGEST_STUDENT", "SHORTEST_DRIVE_S", "WEAKEST_PUSH_M_S2",
        "LARGEST_ACROSS", "MARKED_SHARE"), ("calib/mounting/test_heading.py",)),
    ("calib.mounting.mounting", ("EXPLAINED_SD", "LOCK_COSINE", "SHORTEST_LOG_S"),
     ("calib/mounting",)),
    ("calib.mounting.still_reading", ("LARGEST_OFFSET_RAD_S", "SAME_PLACE_M_S2", "SAME_PLACE_SD"),
     ("calib/mounting",)),
    ("calib.noise.allan", ("LONGEST",), ("calib/noise",)),
    ("calib.noise.coefficients", ("OPTIONAL_SDS", "SEEN_SDS", "LUCK"), ("calib/noise",)),
    ("calib.consistency.clipping", ("CLIPPED_SHARE", "FEWEST_LEVELS"),
     ("calib/consistency/test_clipping.py",)),
    ("calib.consistency.clock", (
        "LEAST_SHARE", "LEFT_SHARE", "LARGEST_CLOCK_ERROR", "FEWEST_TURNS",
        "LARGEST_GAIN"), ("calib/consistency/test_clock.py",)),
    ("calib.consistency.data_sheet", ("SHEET_TOLERANCE",),
     ("calib/consistency/test_data_sheet.py",)),
    ("calib.consistency.force", ("PLATE_RADIUS_M", "FEWEST_POSES", "UNKNOWN_SD", "NOTICEABLE"),
     ("calib/consistency/test_force.py",)),
    ("calib.consistency.common_mistakes", (
        "SAME_RATE", "FEWEST_OF_BLOCK"),
     ("calib/consistency/test_mistakes.py",)),
    ("calib.consistency.mistakes", ("LEFT_OVER",),
     ("calib/consistency/test_mistakes.py",)),
    ("calib.consistency.one_sensor", ("OTHER_GAIN", "CERTAIN_SD"),
     ("calib/consistency/test_mistakes.py",)),
    ("calib.consistency.plate_axes", (
        "FEWEST_POSES", "LEAST_SPREAD", "MOST_RUNS", "LARGEST_SCATTER", "OTHER_POSE"),
     ("calib/consistency/test_plate_axes.py",)),
    ("calib.consistency.repeated_means", ("REPEATED",),
     ("calib/consistency/test_repeated_means.py",)),
    ("calib.consistency.repeats", (
        "CORRELATED", "LEAST_ENTROPY", "SHORTEST_COPY"), ("calib/consistency/test_repeats.py",)),
    ("calib.fit.triad.determined", ("LARGEST_SHARE",), ("calib/fit/triad",)),
    ("calib.fit.triad.frame_alignment", ("LARGEST_PLACEMENT_M", "EFFECTIVE_SAMPLES"),
     ("calib/fit/triad",)),
    ("calib.fit.validation.prediction", ("LARGEST_TO_POSE", "LEAST_REDUNDANCY"),
     ("calib/fit/validation",)),
    ("calib.fit.least_squares.identifiability", (
        "CONDITION_LIMIT", "VISIBLE_SHARE", "LARGEST_REFERENCE_ERROR"),
     ("calib/fit/least_squares/test_solver.py", "calib/fit/least_squares/test_stopped.py")),
    ("calib.fit.least_squares.result", ("UNDETERMINED_SHARE",),
     ("calib/fit/least_squares/test_solver.py", "calib/fit/least_squares/test_stopped.py")),
    ("calib.fit.least_squares.unknown_sd", ("LEAST_REPEATS", "SAME_ATTITUDE"), ("calib/notebook",)),
    ("calib.notebook.tables", ("FAR", "NEAR"), ("calib/notebook",)),
    ("calib.diagnosis.next_measurement.kind", ("FEW_ATTITUDES", "SAME_SPEED", "SWEEP_K"),
     ("calib/diagnosis/test_session_kinds.py",)),
    ("calib.diagnosis.unseen", ("LEAST_SHARE",), ("calib/diagnosis/test_unseen.py",)),
    ("calib.diagnosis.population.pool", (
        "FALSE_ALARM", "AS_STRONG", "WILD_P_VALUE", "FEWEST_DOF_OF_VARIANCE"),
     ("calib/diagnosis/population",)),
    ("calib.diagnosis.population.repeatability", ("FEWEST_DOF_OF_MEAN", "DRIFT_LEVEL"),
     ("calib/diagnosis/population",)),
    ("calib.diagnosis.population.spread", ("UNLIKE_LEVEL", "FEWEST_SENSORS"),
     ("calib/diagnosis/population",)),
)


def multiplied(value: Any, factor: float) -> Any:
    """A number, or each number of a mapping, times ``factor``."""
    if isinstance(value, dict):
        return {key: multiplied(each, factor) for key, each in value.items()}
    return type(value)(value * factor)


def switched_off(value: Any, *, high: bool) -> Any:
    """A threshold that nothing exceeds, or that everything does."""
    if isinstance(value, dict):
        return {key: switched_off(each, high=high) for key, each in value.items()}
    largest = MANY if isinstance(value, int) else math.inf
    return largest if high else type(value)(0)


@contextmanager
def changed(module: ModuleType, name: str, new: Any) -> Iterator[None]:
    """Another value of a threshold, in every module of the product that has imported it."""
    value = getattr(module, name)
    holders = [each for path, each in list(sys.modules.items())
               if path.split(".")[0] in ("calib", "pipeline") and vars(each).get(name) is value]
    for each in holders:
        setattr(each, name, new)
    try:
        yield
    finally:
        for each in holders:
            setattr(each, name, value)


class Counted:
    """How many tests ran, and the names of those that failed."""

    def __init__(self) -> None:
        self.count = 0
        self.failed: list[str] = []

    @property
    def words(self) -> str:
        """How many tests failed, as a cell of the table."""
        failed = len(self.failed) or "none"
        return f"{failed} of {self.count} cases {'fails' if failed in (1, 'none') else 'fail'}"

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        """Called by pytest for each part of each test."""
        self.count += report.when == "call"
        if report.failed:
            self.failed.append(report.nodeid.partition("::")[2])


def outcome(tests: Sequence[str]) -> Counted:
    """The tests in files or folders of ``tests/``."""
    counted = Counted()
    paths = [str(ROOT / "tests" / each) for each in tests]
    with open(os.devnull, "w", encoding="utf-8") as nowhere, redirect_stdout(nowhere):
        pytest.main(["--numprocesses=0", *paths], plugins=[counted])
    return counted


def main() -> None:
    """A row of a table for each threshold."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--only", default="")
    only = parser.parse_args().only
    print("| threshold | value | × 0.5 | × 2 | off |\n|---|---|---|---|---|")
    for path, names, tests in HELD:
        for name in names:
            if not f"{path}.{name}.".startswith(f"{only}." if only else ""):
                continue
            module = import_module(path)
            value = getattr(module, name)
            every = []
            for new in (*(multiplied(value, factor) for factor in FACTORS),
                        switched_off(value, high=False), switched_off(value, high=True)):
                with changed(module, name, new):
                    every.append(outcome(tests))
                for each in every[-1].failed:
                    print(f"  {name} = {new}: {each}", file=sys.stderr)
            off = min(every[len(FACTORS):], key=lambda cases: len(cases.failed))
            cells = [cases.words for cases in (*every[:len(FACTORS)], off)]
            print(f"| `{path}.{name}` | {getattr(module, name)} | {' | '.join(cells)} |",
                  flush=True)


if __name__ == "__main__":
    main()
