"""How long a log of 51 175 rows takes to read, beside NumPy's bare parser.

Run: ``python -m tests.bench.bench_log``. The median of ``REPEATS`` is shown.
"""

import sys
import tempfile
from pathlib import Path

import numpy as np

from pipeline.logs.read import read_log
from pipeline.logs.write import csv_rows
from tests.bench.timing import median_ms

ROWS = 51_175  #: of the public MTi log that the tests read
REPEATS = 9
HEADER = b"time_s,acc_x,acc_y,acc_z,gyr_x,gyr_y,gyr_z\n"
LIMIT = 3.0  #: times the bare parser; decoding and checking the text take about as long as parsing


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
            ours = median_ms(lambda path=path: read_log(path), REPEATS)
            bare = median_ms(
                lambda path=path: np.loadtxt(path, delimiter=",", skiprows=1), REPEATS)
            late |= ours > LIMIT * bare
            print(f"{words}: read_log {ours:6.1f} ms, np.loadtxt {bare:6.1f} ms, "
                  f"{ours / bare:.2f} x (limit {LIMIT:g})")
    sys.exit(late)


if __name__ == "__main__":
    main()
