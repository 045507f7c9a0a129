"""How long a log of 51 175 rows takes to read, beside NumPy's bare parser.

Run: ``python -m tests.bench.bench_log``. The fastest of ``REPEATS`` is shown.
"""

import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

from pipeline.logs.read import read_log
from pipeline.logs.write import csv_rows

ROWS = 51_175  #: of the public MTi log that the tests read
REPEATS = 9
HEADER = b"time_s,acc_x,acc_y,acc_z,gyr_x,gyr_y,gyr_z\n"
LIMIT = 3.0  #: times the bare parser; decoding and checking the text take about as long as parsing


def best_ms(read: Callable[[], object]) -> float:
    """The fastest of a few calls, in milliseconds."""
    fastest = float("inf")
    for _ in range(REPEATS):
        begun = time.perf_counter()
        read()
        fastest = min(fastest, time.perf_counter() - begun)
    return fastest * 1e3


def write_log(path: Path, decimals: int) -> None:
    """Readings at 100 Hz, as whole counts or with ``decimals``."""
    rng = np.random.default_rng(0)
    readings = rng.uniform(20_000, 45_000, (6, ROWS)) / 10.0**decimals
    rows = csv_rows([np.arange(ROWS) / 100, *readings], [2, *[decimals] * 6])
    path.write_bytes(HEADER + b"".join(rows))


def main() -> None:
    """Print both times and their ratio; exit 1 where the ratio is over its limit."""
    late = False
    with tempfile.TemporaryDirectory() as folder:
        for words, decimals in (("whole counts", 0), ("six decimals", 6)):
            path = Path(folder) / f"{decimals}.csv"
            write_log(path, decimals)
            ours = best_ms(lambda path=path: read_log(path))
            bare = best_ms(lambda path=path: np.loadtxt(path, delimiter=",", skiprows=1))
            late |= ours > LIMIT * bare
            print(f"{words}: read_log {ours:6.1f} ms, np.loadtxt {bare:6.1f} ms, "
                  f"{ours / bare:.2f} x (limit {LIMIT:g})")
    sys.exit(late)


if __name__ == "__main__":
    main()
