"""What half and double of each threshold of `pipeline import` changes.

Run: ``python -m tests.bench.study_import``; with the beginnings of names, as in ``... guess.pool
guess.triads``, these thresholds on the sets whose columns or units numbers alone tell, with the
names of their columns and with letters in the place of these. The files
are those of ``tests.pipeline.guess``, from one recording and from one evening at a record player,
and the public logs where they are there. Counted are the sets of files whose columns, units, clock
or motion are guessed otherwise.
"""

import re
import sys
import tempfile
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import cache
from pathlib import Path
from string import ascii_letters

from pipeline.errors import UnreadableInput
from pipeline.guess.raw_tables import RawTable, raw_tables
from pipeline.guess.session import guess_session
from pipeline.guess.table_guess import guess_tables
from tests.bench.threshold_records import with_factors
from tests.paths import REAL
from tests.pipeline.guess.corpus import READ
from tests.pipeline.guess.evening import Evening
from tests.pipeline.guess.hand_log import hand_log
from tests.thresholds import Threshold, thresholds

PUBLIC = (
    "snu/imu_good3.txt.gz", "sundevil/imu_data_int.txt.gz", "sundevil/IMU_Rev2_Data_Long.txt.gz",
    "sundevil/imu_cal_data_with_table.txt.gz", "mpu9150_mikoff/imu0.log.gz", "ck/acc_log.csv.gz",
    "mpu6050_tomisuarez/example_data_calibration.csv.gz", "kerf/mpu6050_board1_cal_data.txt",
    "imucal_ferraris/example_ferraris_session.csv.gz", "shenshikexmu/caldata.mat",
    "ouranos_rate_table/GSDataLogBoost1.csv.gz", "freeimucal/33RPMgyr.txt.gz",
    "freeimucal/0RPMgyr.txt.gz", "nexus5_tyrex/calib_acc_d2_gyroscope.txt.gz",
    "czech_tu_static/measured_accelerations.mat", "magneto_michaelwro/acceldata-example.txt",
)

BY_NUMBERS = {tool: READ[tool] for tool in (
    "unsigned", "offset_binary", "no_header_no_time", "gyroscope_first", "one_file_per_pose",
    "means", "unnamed_quaternion", "g_force", "in_turn", "magnetometer_first", "thingspeak",
    "increments", "micro_g", "nine_unnamed")}
FACT = re.compile(r"\bfacts?\b", re.IGNORECASE)
READERS = ("guess.no_log", "guess.raw_tables")
Guess = Callable[[], object]


def guesses(folder: Path) -> Iterator[Guess]:
    """A guess of every set of files, to be made anew."""
    log = hand_log(rate_hz=50.0)
    chosen = BY_NUMBERS if sys.argv[1:] else READ
    for name, write in chosen.items():
        place = folder / name
        place.mkdir()
        foreign = write(place, log)
        yield lambda files=foreign.files, hz=foreign.rate_hz: essence(files, hz)  # type: ignore[misc]
        if chosen is BY_NUMBERS:
            yield lambda files=foreign.files, hz=foreign.rate_hz: essence(  # type: ignore[misc]
                files, hz, names=False)
    for lean_deg, range_deg_s in ((0.6, 250.0), (0.6, 2000.0), (0.0, 500.0)):
        evening = Evening(range_deg_s=range_deg_s, lean_deg=lean_deg, rate_hz=100.0)
        place = folder / str((lean_deg, range_deg_s))
        place.mkdir()
        files = [*evening.write(place, "rest", 0.0, 1), *evening.write(place, "turn", 100 / 3, 2)]
        yield lambda files=files: essence(files, None)  # type: ignore[misc]
    for name in PUBLIC if REAL.exists() and chosen is READ else ():
        yield lambda files=[REAL / name]: essence(files, None)  # type: ignore[misc]


def nameless(table: RawTable) -> RawTable:
    """A table with letters in the place of the names of its columns."""
    letters = tuple(ascii_letters[: len(table.columns)])
    return replace(table, columns=dict(zip(letters, table.columns.values(), strict=True)),
                   header=letters if table.header else ())


@cache
def read(path: Path) -> list[RawTable]:
    """The tables of a file, read once unless a threshold of the reader changes."""
    return raw_tables(path)


def essence(files: list[Path], rate_hz: float | None, names: bool = True) -> object:
    """What a configuration would state of the files."""
    try:
        tables = [table if names else nameless(table) for path in files for table in read(path)]
        guess = guess_session([table for table in guess_tables(tables, rate_hz) if table])
    except UnreadableInput as error:
        return str(error)
    return [(source.layout, source.rate, [
        (table.theirs, table.clock.unit, table.clock.rate_hz,
         table.accelerometer and table.accelerometer.sheet,
         table.gyroscope and table.gyroscope.sheet) for table in source.tables])
        for source in guess.sources]


def decisive() -> Iterator[Threshold]:
    """The numbers of ``pipeline.guess`` that are no facts."""
    for each in thresholds("pipeline"):
        is_number = isinstance(each.value, int | float) and not isinstance(each.value, bool)
        wanted = each.path.startswith(tuple(sys.argv[1:] or ["guess."]))
        if wanted and is_number and not FACT.search(each.description):
            yield each


def main() -> None:
    """Print the table."""
    with tempfile.TemporaryDirectory() as folder:
        every = list(guesses(Path(folder)))
        as_it_is = [guess() for guess in every]
        print(f"{len(every)} sets of files\n")
        print("| threshold | value | × 0.5 | × 2 |\n|---|---|---|---|")
        for each in decisive():
            module, name = each.path.rsplit(".", 1)

            def changed(reads: bool = module in READERS) -> int:
                if reads:
                    read.cache_clear()
                return sum(guess() != before
                           for guess, before in zip(every, as_it_is, strict=True))

            words = [f"{n} sets change" if n and n > 1 else "1 set changes" if n else "no effect"
                     for n in with_factors("pipeline", each, changed)]
            if module in READERS:
                read.cache_clear()
            print(f"| `{module}.{name}` | {each.value:g} | {words[0]} | {words[1]} |")
            sys.stdout.flush()


if __name__ == "__main__":
    main()
