"""Names of log columns: ours, and those of well-known programs with the same meaning."""

from collections import Counter
from collections.abc import Container, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

ACCELEROMETER = ("acc_x", "acc_y", "acc_z")
GYROSCOPE = ("gyr_x", "gyr_y", "gyr_z")
TIME = "time_s"
COUNTER = "counter"  #: sample counter; with a sample rate it gives the time, including gaps
READINGS = (TIME, COUNTER, *ACCELEROMETER, *GYROSCOPE)
SKIP = "skip"  #: a column that is not read
MINUS = "minus_"  #: before the name of an axis that reads less along what points up, as Apple's do

SAMPLE_RATES_HZ = (1e-3, 1e6)  #: lowest and highest sample rate that may be stated; a judgement

TimeUnit = Literal["s", "ms", "us", "ns", "min", "d"]
SECONDS_PER: Mapping[TimeUnit, float] = {
    "s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9, "min": 60.0, "d": 86_400.0}

_OURS: Mapping[str, tuple[str, float]] = {
    **{name: (name, 1.0) for name in READINGS},
    **{f"time_{unit}": (TIME, size) for unit, size in SECONDS_PER.items() if unit != "s"},
    **{f"{MINUS}{name}": (name, -1.0) for name in ACCELEROMETER},
    "packetcounter": (COUNTER, 1.0), "sampletimefine": (TIME, 1e-4)}  # MT Manager; ticks at 10 kHz
"""Names in a header, in lower case, with our name and the factor to our unit."""


@dataclass(frozen=True)
class Renamed:
    """Columns that a configuration selects by their names in the file: pairs (ours, theirs)."""

    pairs: tuple[tuple[str, str], ...]

    @property
    def ours(self) -> tuple[str, ...]:
        """Our names, in the order of the configuration."""
        return tuple(ours for ours, _ in self.pairs)

    def apply(self, names: Sequence[str]) -> list[str] | None:
        """``names`` of a file with theirs replaced by ours; None if one of theirs is absent.

        A column that is not selected but has the name of one that is, or of what its name means
        (``time_s`` beside a selected ``time_ms``), is skipped.
        """
        by_theirs = {bare(theirs): ours for ours, theirs in self.pairs}
        selected = {*self.ours, *(our_name(ours)[0] for ours in self.ours)}
        if not by_theirs.keys() <= {bare(name) for name in names}:
            return None
        return [by_theirs.get(bare(name), SKIP if bare(name) in selected else bare(name))
                for name in names]


#: Names of a file's columns in a configuration.
ColumnNames = Sequence[str] | Renamed


def bare(name: str) -> str:
    """A name of a header without enclosing blanks and quotation marks."""
    return name.strip().strip('"').strip()


def our_name(theirs: str) -> tuple[str, float]:
    """Our name of a header's column, and the factor to our unit.

    A column that no dialect knows keeps its name and its unit; one without a name is skipped.
    """
    return _OURS.get(bare(theirs).lower(), (bare(theirs) or SKIP, 1.0))


def parts_missing(names: Container[str]) -> Iterator[str]:
    """A phrase on the missing columns of each incomplete triad in ``names``."""
    for triad in (ACCELEROMETER, GYROSCOPE):
        lacking = [name for name in triad if name not in names]
        if 0 < len(lacking) < len(triad):
            yield f"{' and '.join(lacking)} missing beside the rest of the triad"


def missing_columns(names: Sequence[str]) -> str | None:
    """A phrase on what these columns lack for a log; None if nothing.

    A log needs at least one complete triad, and no repeated name except ``skip``.
    """
    counts = Counter(names)
    repeated = [name for name in counts if name != SKIP and counts[name] > 1]
    if repeated:
        return f"the column '{repeated[0]}' is there twice"
    if lacks := next(parts_missing(names), None):
        return lacks
    if ACCELEROMETER[0] not in names and GYROSCOPE[0] not in names:
        return "neither acc_x, acc_y, acc_z nor gyr_x, gyr_y, gyr_z is there"
    return None
