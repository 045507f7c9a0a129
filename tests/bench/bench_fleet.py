"""Many sessions: what each costs, how much memory it takes, and the page of a large lot.

    python -m tests.bench.bench_fleet sessions --count 1000 --workers 2
    python -m tests.bench.bench_fleet page --sensors 10000 --output /tmp/page

``sessions`` writes sessions of an accelerometer (18 poses of a second), links them ``--count``
times and runs ``pipeline fleet`` on them twice: the cost of a session and of one that is kept, and
the largest memory of the command and of each worker. ``page`` draws a lot of accelerometers
(``tests.world.lot``), of which some are unlike it and all have an effect of half a sd, two evenings
each, and writes the page of them: seconds, size, memory. Its sessions themselves are not run.
"""

import argparse
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from pipeline.fleet.finish import finish_fleet
from tests.lot_records import lot_records
from tests.world.designs import paper_design
from tests.world.imu import mpu6050
from tests.world.lot import LotPlan, draw_lot
from tests.world.session import simulate
from tests.world.write import write_session

KB = 1024
DIFFERENT = 10


def sessions(asked: argparse.Namespace) -> None:
    """``pipeline fleet`` on many sessions, twice."""
    with tempfile.TemporaryDirectory() as folder:
        root = Path(folder)
        design = paper_design(mpu6050()).scaled(seconds=0.125)
        for seed in range(DIFFERENT):
            config = write_session(root / f"made/{seed}", simulate(design, seed), film=False).config
            text = config.read_text(encoding="utf-8")
            config.write_text(text[: text.index("gyroscope:  #")], encoding="utf-8")
        for i in range(asked.count):
            link = root / f"sessions/unit{i:05d}"
            link.parent.mkdir(exist_ok=True)
            link.symlink_to(root / f"made/{i % DIFFERENT}")
        command = [sys.executable, "-m", "pipeline", "fleet", f"{root}/sessions/*/config.yaml",
                   "--output", str(root / "fleet"), "--workers", str(asked.workers),
                   "--no-reports"]
        for what in ("run", "kept"):
            begun = time.perf_counter()
            before = _cpu()
            said = subprocess.run(command, check=True, capture_output=True, text=True)
            wall, cpu = time.perf_counter() - begun, _cpu() - before
            print(f"{asked.count} sessions {what}, {asked.workers} workers: {wall:.0f} s by the "
                  f"clock, {1e3 * cpu / asked.count:.0f} ms of a processor each")
            if what == "run":
                print(said.stdout.splitlines()[-2])
        largest = resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss / KB
        print(f"largest memory of one process (command or worker): {largest:.0f} MB, at most "
              f"{largest * (asked.workers + 1):.0f} MB together")


def _cpu() -> float:
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def page(asked: argparse.Namespace) -> None:
    """The table, the population and the page of a large lot."""
    plan = LotPlan(asked.sensors // 2, evenings=2, hidden="cubic", common_sd=0.5)
    lot = draw_lot(paper_design(mpu6050()), plan, 1)
    lot.counts[:: len(lot) // 20] *= 1.05  # 20 evenings at another supply
    output = asked.output or Path(tempfile.mkdtemp())
    records = lot_records(lot, [f"unit{unit:05d}/evening{i % plan.evenings + 1}"
                                for i, unit in enumerate(lot.unit)], output)
    del lot
    before = _memory()
    begun, cpu = time.perf_counter(), time.process_time()
    finish_fleet(records, output, reports=True)
    size = (output / "fleet.html").stat().st_size / KB
    cpu, seconds = time.process_time() - cpu, time.perf_counter() - begun
    print(f"{len(records)} sessions: table, population and page in {cpu:.1f} s of one processor, "
          f"{seconds:.1f} s by the clock; fleet.html {size:.0f} kB; largest memory {_memory():.0f} "
          f"MB, {before:.0f} MB of it before, to draw the lot; {output}")


def _memory() -> float:
    """Largest memory of this process so far, MB."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / KB


def main() -> None:
    """Print the figures."""
    parser = argparse.ArgumentParser()
    commands = parser.add_subparsers(required=True)
    of_sessions = commands.add_parser("sessions")
    of_sessions.add_argument("--count", type=int, default=100)
    of_sessions.add_argument("--workers", type=int, default=2)
    of_sessions.set_defaults(task=sessions)
    of_page = commands.add_parser("page")
    of_page.add_argument("--sensors", type=int, default=10_000)
    of_page.add_argument("--output", type=Path)
    of_page.set_defaults(task=page)
    asked = parser.parse_args()
    asked.task(asked)


if __name__ == "__main__":
    main()
