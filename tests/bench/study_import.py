"""What half and double of each threshold of `pipeline import` changes.

Run: ``python -m tests.bench.study_import``. The files are those of ``tests.pipeline.guess`` in the
manner of 21 tools, from one recording, and the public logs where they are there. Counted are the
files whose columns, units, clock or motion are guessed otherwise.
"""

import sys
import tempfile
from collections.abc import Callable, Iterator
from importlib import import_module
from pathlib import Path
from typing import Any

from pipeline.errors import UnreadableInput
from pipeline.guess.files import guess_files
from pipeline.guess.session import guess_session
from tests.paths import REAL
from tests.pipeline.guess.foreign_files import TOOLS
from tests.pipeline.guess.hand_log import hand_log

THRESHOLDS = (
    ("magnitudes", "RPM_TOLERANCE"), ("magnitudes", "GRAVITY_TOLERANCE"),
    ("magnitudes", "LOOSEST_SPREAD"), ("magnitudes", "MOST_INNER"),
    ("triads", "LEAST_AGREEMENT"), ("magnitudes", "LEAST_TURN"), ("magnitudes", "BLOCK_S"),
    ("triads", "LEAST_SCATTER"), ("triads", "FASTEST_HAND_RAD_S"), ("triads", "NOISIEST_RAD_S"),
    ("triads", "LARGEST_BIAS_RAD_S"), ("table_guess", "MEANS_APART"),
    ("table_guess", "MOST_MEANS"), ("table_guess", "TURNING_RAD_S"),
    ("magnitudes", "FEWEST_TURNS"), ("table_guess", "FEWEST_MEANS"), ("session", "MOST_POSE_S"),
)
PUBLIC = (
    "snu/imu_good3.txt.gz", "sundevil/imu_data_int.txt.gz", "sundevil/IMU_Rev2_Data_Long.txt.gz",
    "sundevil/imu_cal_data_with_table.txt.gz", "mpu9150_mikoff/imu0.log.gz", "ck/acc_log.csv.gz",
    "mpu6050_tomisuarez/example_data_calibration.csv.gz", "kerf/mpu6050_board1_cal_data.txt",
    "imucal_ferraris/example_ferraris_session.csv.gz", "shenshikexmu/caldata.mat",
    "ouranos_rate_table/GSDataLogBoost1.csv.gz", "freeimucal/33RPMgyr.txt.gz",
    "freeimucal/0RPMgyr.txt.gz", "nexus5_tyrex/calib_acc_d2_gyroscope.txt.gz",
    "czech_tu_static/measured_accelerations.mat", "magneto_michaelwro/acceldata-example.txt",
)

SEEDS = (0,)
Guess = Callable[[], object]


def guesses(folder: Path) -> Iterator[Guess]:
    """A guess of every set of files, to be made anew."""
    for seed in SEEDS:
        for name, write in TOOLS.items():
            place = folder / f"{name}{seed}"
            place.mkdir()
            foreign = write(place, hand_log(seed))
            yield lambda files=foreign.files, hz=foreign.rate_hz: essence(files, hz)  # type: ignore[misc]
    for name in PUBLIC if REAL.exists() else ():
        yield lambda files=[REAL / name]: essence(files, None)  # type: ignore[misc]


def essence(files: list[Path], rate_hz: float | None) -> object:
    """What a configuration would state of the files."""
    try:
        tables, _ = guess_files(files, rate_hz)
        guess = guess_session(tables)
    except UnreadableInput as error:
        return str(error)
    return [(source.layout, source.rate, [
        (table.theirs, table.clock.unit, table.clock.rate_hz,
         table.accelerometer and table.accelerometer.sheet,
         table.gyroscope and table.gyroscope.sheet) for table in source.tables])
        for source in guess.sources]


def main() -> None:
    """Print the table; exit 1 where a threshold is missing."""
    with tempfile.TemporaryDirectory() as folder:
        every = list(guesses(Path(folder)))
        as_it_is = [guess() for guess in every]
        print(f"{len(every)} sets of files\n")
        print("| threshold | value | × 0.5 | × 2 |\n|---|---|---|---|")
        for module_name, name in THRESHOLDS:
            module: Any = import_module(f"pipeline.guess.{module_name}")
            value = getattr(module, name)
            changed = []
            for factor in (0.5, 2.0):
                setattr(module, name, value * factor)
                changed.append(sum(guess() != before
                                   for guess, before in zip(every, as_it_is, strict=True)))
            setattr(module, name, value)
            words = [f"{n} change" if n else "no effect" for n in changed]
            print(f"| `{module_name}.{name}` | {value:g} | {words[0]} | {words[1]} |")
            sys.stdout.flush()


if __name__ == "__main__":
    main()
