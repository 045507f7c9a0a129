"""Which cases of the pose detector's tests fail with a threshold of it halved or doubled.

    python -m tests.bench.pose_detector_thresholds [NAME ...]

Every test of ``tests/pipeline/record/test_pose_detector.py`` plays readings to the detector: poses
at rest, on a level and a tilted plate, moved, too short, of a noisy sensor.
"""

import os
import sys
from contextlib import redirect_stdout
from typing import Any

import pytest

from pipeline.record import pose_detector
from tests.paths import ROOT

NAMES = ("HOP_S", "WINDOW_HOPS", "STEADY_HOPS", "CEILING", "MOVED_RATIO", "STEADY_CHANGE",
         "STEADY_SD", "MOVED_DEG", "SAME_SPEED")
CASES = ROOT / "tests/pipeline/record/test_pose_detector.py"


def multiplied(value: Any, factor: float) -> Any:
    """A number, or each number of a mapping, times ``factor``."""
    if isinstance(value, dict):
        return {key: multiplied(each, factor) for key, each in value.items()}
    return type(value)(value * factor)


class Counted:
    """How many tests ran, and the names of those that failed."""

    def __init__(self) -> None:
        self.count = 0
        self.failed: list[str] = []

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        """Called by pytest for each part of each test."""
        self.count += report.when == "call"
        if report.failed:
            self.failed.append(report.nodeid.partition("::")[2])


def outcome(name: str, factor: float) -> Counted:
    """The tests with one threshold multiplied."""
    before = getattr(pose_detector, name)
    counted = Counted()
    setattr(pose_detector, name, multiplied(before, factor))
    try:
        with open(os.devnull, "w", encoding="utf-8") as nowhere, redirect_stdout(nowhere):
            pytest.main(["--numprocesses=0", str(CASES)], plugins=[counted])
    finally:
        setattr(pose_detector, name, before)
    return counted


def main(names: list[str]) -> None:
    """A line for each value of each threshold."""
    for name in names or NAMES:
        for factor in (0.5, 2.0):
            cases = outcome(name, factor)
            print(f"{name} x {factor:g}: {len(cases.failed)} of {cases.count} cases fail"
                  f"{': ' + ', '.join(cases.failed) if cases.failed else ''}", flush=True)


if __name__ == "__main__":
    main(sys.argv[1:])
