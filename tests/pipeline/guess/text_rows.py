"""What the modules of foreign logs share: lines of text, counts, readings as text."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from tests.pipeline.guess.foreign_files import DEG, G
from tests.pipeline.guess.hand_log import HandLog

EPOCH_S = 1_700_000_000


def write_lines(path: Path, lines: Sequence[str], encoding: str = "utf-8", end: str = "\n") -> Path:
    path.write_bytes((end.join(lines) + end).encode(encoding))
    return path


def si_rows(log: HandLog, acc: float = 1.0, gyr: float = 1.0) -> list[tuple[str, ...]]:
    """Time in s, then six readings, as text."""
    return [(f"{t:.3f}", *(f"{v:.6f}" for v in row)) for t, row in
            zip(log.time_s, np.hstack([log.acc * acc, log.gyr * gyr]), strict=True)]


def counts_of(log: HandLog, per_g: float = 16384.0, per_dps: float = 131.072) -> np.ndarray:
    return np.rint(np.hstack([log.acc / G * per_g, log.gyr / DEG * per_dps])).astype(int)
