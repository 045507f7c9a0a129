"""How long whole commands take: ``python -m tests.bench.bench_run``.

Each command runs in a process of its own, as a user's does, imports and report included; the
fastest of ``REPEATS`` is shown, because everything else on the machine only ever adds time. Beside
it stands its ratio to a process that only imports NumPy, SciPy's optimizers and OpenCV; beside that
of `pipeline --help`, which imports none of them, a bare Python.
"""

import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from pipeline.logs.write import csv_rows
from tests.paths import ROOT, SHARED

REPEATS = 3
MILLION = 1_000_000

XSENS = """
sensor: xsens-mti
site: {{gravity_m_s2: 9.81744}}
accelerometer:
  poses:
    log: [{real}/imu_tk_xsens/xsens_acc.mat.gz, {real}/imu_tk_xsens/xsens_gyro.mat.gz]
    columns: [[time_s, acc_x, acc_y, acc_z], [time_s, gyr_x, gyr_y, gyr_z]]
    find: still
"""


LIBRARIES = "import numpy, scipy.optimize, scipy.stats, cv2"


def seconds(*arguments: str | Path, fresh: Path | None = None) -> float:
    """The fastest of a few runs of one command; ``fresh`` is a folder removed before each."""
    return fastest_run(["-m", "pipeline", *map(str, arguments)], fresh)


def fastest_run(arguments: list[str], fresh: Path | None = None) -> float:
    """The same of Python with any arguments."""
    fastest = float("inf")
    for _ in range(REPEATS):
        if fresh is not None:
            shutil.rmtree(fresh, ignore_errors=True)
        start = time.perf_counter()
        subprocess.run([sys.executable, *arguments], cwd=ROOT, check=True, capture_output=True)
        fastest = min(fastest, time.perf_counter() - start)
    return fastest


def measured(folder: Path) -> Iterator[tuple[str, float, float]]:
    """Command in words, limit and measured time in seconds."""
    out = folder / "out"
    example = ROOT / "data/example/config.yaml"
    run = ("run", example, "--output", out)
    yield "shipped session, first run (a 60 s clip)", 15.0, seconds(*run, fresh=out)
    yield "shipped session, clip known already", 2.0, seconds(*run)
    log = folder / "million.csv"
    write_log(log)
    yield "apply to a million rows", 2.0, seconds("apply", out, log, "--output", folder / "o.csv")
    real = SHARED / "real"
    if real.is_dir():
        config = folder / "xsens.yaml"
        config.write_text(XSENS.format(real=real), encoding="utf-8")
        yield "real MTi log, 51 175 rows", 2.0, seconds("run", config)
    for name in ("a", "b", "c"):
        config = SHARED / "bench" / name / "config.yaml"
        if config.exists():
            own = folder / name
            run = ("run", config, "--output", own)
            yield f"bench/{name}, first run", 15.0, seconds(*run, fresh=own)


def write_log(path: Path) -> None:
    """Counts of a sensor at 100 Hz for three hours."""
    rng = np.random.default_rng(0)
    counts = rng.integers(20_000, 45_000, (6, MILLION)).astype(float)
    header = b"time_s,acc_x,acc_y,acc_z,gyr_x,gyr_y,gyr_z\n"
    rows = csv_rows([np.arange(MILLION) / 100, *counts], [2, 0, 0, 0, 0, 0, 0])
    path.write_bytes(header + b"".join(rows))


def main() -> None:
    """Print the table; exit 1 where a limit is exceeded."""
    late = False
    bare, floor = fastest_run(["-c", "pass"]), fastest_run(["-c", LIBRARIES])
    print(f"{seconds('--help'):6.2f} s  pipeline --help; {bare:.2f} s a bare Python")
    print(f"{floor:6.2f} s  imports of the libraries alone")
    with tempfile.TemporaryDirectory() as folder:
        for words, limit, took in measured(Path(folder)):
            late |= took > limit
            print(f"{took:6.2f} s  {took / floor:5.1f} x  "
                  f"(limit {limit:g} s{', EXCEEDED' * (took > limit)})  {words}", flush=True)
    sys.exit(late)


if __name__ == "__main__":
    main()
