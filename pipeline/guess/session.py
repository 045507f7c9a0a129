"""Tables put together to a session: what is a pose, which sets of poses, at which rate."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from calib.errors import CalibrationError
from calib.numbers import RPM
from calib.poses.averaging import average_pose
from calib.poses.data_sheet import TriadSpec
from calib.poses.imu_log import TRIADS
from pipeline.config.types import STOPPED
from pipeline.guess.magnitudes import record_rpm
from pipeline.guess.table_guess import FEWEST_MEANS, TableGuess
from pipeline.guess.triads import TriadGuess

MOST_POSE_S = 120.0
"""A longer file is a log of many poses. Half and double change nothing in
``tests.bench.study_import``; chosen."""

SI = TriadSpec(float("inf"), 0, "si")
RECORD_SD = 0.003
"""Relative sd of a record player's nominal speed: what belt drives and worn idlers are off by."""

Layout = Literal["files", "log", "means"]


@dataclass(frozen=True, eq=False)
class PoseSource:
    """Files that a configuration names together as poses at one rate of the plate.

    ``rate`` is the name of the setting, ``stopped`` at rest, None where the rate is not known.
    """

    layout: Layout
    tables: tuple[TableGuess, ...]
    rate: str | None
    rate_rad_s: float = 0.0

    @property
    def has_gyroscope(self) -> bool:
        """Whether any of its tables has one."""
        return any(each.gyroscope for each in self.tables)

    @property
    def has_accelerometer(self) -> bool:
        """Whether any of its tables has one."""
        return any(each.accelerometer for each in self.tables)


@dataclass(frozen=True, eq=False)
class SessionGuess:
    """Everything that was guessed of the files."""

    sources: tuple[PoseSource, ...]
    doubts: tuple[str, ...]

    @property
    def tables(self) -> tuple[TableGuess, ...]:
        """All tables, in the order of the sources."""
        return tuple(table for source in self.sources for table in source.tables)

    @property
    def accelerometer(self) -> TriadGuess | None:
        """That of the first table that has one."""
        return next((t.accelerometer for t in self.tables if t.accelerometer), None)

    @property
    def gyroscope(self) -> TriadGuess | None:
        """That of the first table that has one; a doubtful unit gives way to a sure one."""
        every = [t.gyroscope for t in self.tables if t.gyroscope]
        return next((each for each in every if not each.doubt), every[0] if every else None)

    @property
    def at_rest(self) -> PoseSource | None:
        """Where the accelerometer is best calibrated: poses at rest, else any."""
        able = [source for source in self.sources if source.has_accelerometer]
        return min(able, key=lambda source: source.rate_rad_s > 0, default=None)


def guess_session(tables: Sequence[TableGuess]) -> SessionGuess:
    """Group tables by what their rows are and by the rate at which they turn."""
    doubts = _together(tables)
    groups: dict[tuple[Layout, str | None], list[TableGuess]] = {}
    rates: dict[tuple[Layout, str | None], list[float]] = {}
    layout = _layout(tables)
    for table in tables:
        name, rate = _setting(table)
        kind: Layout = "means" if table.are_means else layout
        groups.setdefault((kind, name), []).append(table)
        rates.setdefault((kind, name), []).append(rate)
    sources = tuple(
        PoseSource(kind, tuple(_in_pairs(each) if kind == "log" else each), name,
                   float(np.median(rates[kind, name])))
        for (kind, name), each in groups.items()
    )
    doubts += _about_rates(sources)
    doubts += _differing(tables)
    return SessionGuess(sources, tuple(dict.fromkeys(doubts)))


def _together(tables: Sequence[TableGuess]) -> list[str]:
    """What is not sure of the tables; said once where it is the same of many."""
    names: dict[str, list[str]] = {}
    for table in tables:
        for doubt in table.doubts:
            names.setdefault(doubt, []).append(table.path.name)
    return [f"{files[0]}{f' and {len(files) - 1} more' if files[1:] else ''}: {doubt}"
            for doubt, files in names.items()]


def _setting(table: TableGuess) -> tuple[str | None, float]:
    """The name of the plate setting of a table, and its rate in rad/s."""
    turning = table.turning_rad_s
    if turning == 0:
        return STOPPED, 0.0
    rpm = record_rpm(turning)
    return (f"{rpm:.3g}rpm", rpm * RPM) if rpm else (None, turning)


def _layout(tables: Sequence[TableGuess]) -> Layout:
    """Files of one pose each, or long logs that hold many."""
    alone = [table for table in tables if table.accelerometer] or list(tables)
    if len(alone) < FEWEST_MEANS:
        return "log"
    return "files" if sum(map(_is_pose, alone)) > len(alone) / 2 else "log"


def _is_pose(table: TableGuess) -> bool:
    log = table.log()
    if log is None or log.time_s[-1] - log.time_s[0] > MOST_POSE_S:
        return False
    try:
        average_pose(log, SI if table.accelerometer else None, SI if table.gyroscope else None,
                     table.turning_rad_s)
    except CalibrationError:
        return False
    return True


def _in_pairs(tables: Sequence[TableGuess]) -> list[TableGuess]:
    """Accelerometers' and gyroscopes' logs of the same times beside each other."""
    waiting = [table for table in tables if table.accelerometer is None]
    ordered = []
    for table in tables:
        if table.accelerometer is None:
            continue
        ordered.append(table)
        if table.gyroscope is None:
            beside = next((other for other in waiting if _overlap(table, other)), None)
            if beside is not None:
                waiting.remove(beside)
                ordered.append(beside)
    return ordered + waiting


def _overlap(one: TableGuess, other: TableGuess) -> bool:
    a, b = one.clock.time_s, other.clock.time_s
    common = min(a[-1], b[-1]) - max(a[0], b[0])
    return bool(common > 0.5 * min(a[-1] - a[0], b[-1] - b[0]))


def _about_rates(sources: Sequence[PoseSource]) -> list[str]:
    doubts = []
    for source in sources:
        turning = [table.turning_rad_s for table in source.tables if table.turning_rad_s]
        if source.rate is None:
            doubts.append(
                f"{source.tables[0].path.name}: the gyroscope turns at about "
                f"{np.median(turning):.3g} rad/s, which is no speed of a record player; state the "
                f"rate of the plate, or a clip of it, to calibrate the gyroscope by it"
            )
        elif source.rate != STOPPED:
            doubts.append(
                f"{source.tables[0].path.name}: the gyroscope turns as on a record player at "
                f"{source.rate}; the nominal rate is taken with an sd of {RECORD_SD:.1%}, which "
                f"the scale of the gyroscope inherits. A clip of the plate gives 50 ppm"
            )
    return doubts


def _differing(tables: Sequence[TableGuess]) -> list[str]:
    """Tables whose units differ: one sensor has one."""
    doubts = []
    for name in TRIADS:
        units = {each.unit for table in tables if (each := getattr(table, name)) and not each.doubt}
        if len(units) > 1:
            doubts.append(f"the units of the {name} differ from file to file: "
                          f"{', '.join(sorted(units))}")
    return doubts
