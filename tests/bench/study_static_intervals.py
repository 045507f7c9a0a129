"""What the search for static intervals finds in simulated hand-turned logs, and by which constants.

    python -m tests.bench.study_static_intervals [SEEDS [CONSTANT ...]]

For each kind of log: rests found of those there, and found stretches that are mostly movement. Then
the same, all kinds together, with each constant halved and doubled, or with those named.
"""

import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from types import ModuleType

import numpy as np

from calib.poses.rests import attitude_fit, rest_candidates, static_intervals
from tests.calib.poses.hand_turned_logs import KINDS, count, made

CONSTANTS: tuple[tuple[ModuleType, str], ...] = (
    (rest_candidates, "WINDOW_S"),
    (rest_candidates, "QUIETEST_SHARE"),
    (rest_candidates, "LARGEST_TURN"),
    (rest_candidates, "MARGIN_SHARE"),
    (rest_candidates, "MARGIN_S"),
    (rest_candidates, "SAME_ATTITUDE"),
    (rest_candidates, "MOST_BLOCKS"),
    (static_intervals, "STILL_RATIO"),
    (static_intervals, "THRESHOLD_STEP"),
    (attitude_fit, "ALIKE"),
    (attitude_fit, "WORTHLESS"),
)


@contextmanager
def changed(module: ModuleType, name: str, factor: float) -> Iterator[None]:
    """A constant of a module multiplied for a while."""
    before = getattr(module, name)
    setattr(module, name, type(before)(before * factor))
    try:
        yield
    finally:
        setattr(module, name, before)


#: Halved it is no possible value: no steps at all.
IMPOSSIBLE = {("THRESHOLD_STEP", 0.5)}


def main(seeds: int, only: Sequence[str]) -> None:
    """Print both tables."""
    logs = {kind: [made(kind, seed) for seed in range(seeds)] for kind in KINDS}

    def line(title: str, kinds: tuple[str, ...]) -> None:
        counts = np.array([count(log) for kind in kinds for log in logs[kind]]).sum(axis=0)
        print(f"{title:<34} {counts[0]:5d} of {counts[1]:5d} rests, {counts[2]:3d} wrong")

    for kind in KINDS:
        line(kind, (kind,))
    line("all", KINDS)
    for module, name in CONSTANTS:
        for factor in (0.5, 2.0):
            if (name, factor) in IMPOSSIBLE or (only and name not in only):
                continue
            with changed(module, name, factor):
                line(f"{name} x {factor:g}", KINDS)
    for factor in (0.5, 2.0) if not only or "LARGEST_SWING" in only else ():
        largest = {key: factor * swing for key, swing in rest_candidates.LARGEST_SWING.items()}
        before = dict(rest_candidates.LARGEST_SWING)
        rest_candidates.LARGEST_SWING.update(largest)
        line(f"LARGEST_SWING x {factor:g}", KINDS)
        rest_candidates.LARGEST_SWING.update(before)


if __name__ == "__main__":
    main(int(sys.argv[1]) if sys.argv[1:] else 10, sys.argv[2:])
