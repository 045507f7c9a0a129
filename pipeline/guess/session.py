"""A session from tables: the poses, their sets and the rate of each set."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Literal

import numpy as np

from calib.earth import STANDARD_GRAVITY_M_S2
from calib.errors import CalibrationError
from calib.numbers import RPM
from calib.poses.averaging.average_pose import average_pose
from calib.poses.imu_log import AXES, TRIADS, Triad
from calib.poses.runs.ring import LEAST_TILT_RAD
from pipeline.config.types import STOPPED
from pipeline.guess.files import NUMBER
from pipeline.guess.magnitudes import record_rpm, sample_noise_sd
from pipeline.guess.plate import (
    SI,
    MeasuredClip,
    ScaleChoice,
    clocked_by_plate,
    matching_clip,
    nominal_rpm,
    settle_scale,
    without_rate_bias,
)
from pipeline.guess.pool import FEWEST_MEANS
from pipeline.guess.repeated import drop_alternatives, without_continuations
from pipeline.guess.speeds import speeds_in, speeds_of
from pipeline.guess.table_guess import TURNING_RAD_S, TableGuess
from pipeline.guess.units import TriadGuess
from pipeline.text.names import short_name

MOST_POSE_S = 120.0
"""Duration from which a file is a log of many poses. Half and double change nothing in
``tests.bench.study_import``; chosen."""

RECORD_SD = 0.01
"""Relative sd of a record player's nominal speed. Fact: DIN 45500 allows -1 to +1.5 % in high
fidelity, and cheap players turn up to 2 % too fast."""

Layout = Literal["files", "log", "means"]

LEAST_MOVE: dict[Triad, float] = {"accelerometer": STANDARD_GRAVITY_M_S2,
                                  "gyroscope": TURNING_RAD_S}
"""Least range of an axis beside which one that reads one number is dead: it was laid on another
side, or turned. Derived."""
SO_DEAD: dict[Triad, str] = {"accelerometer": "", "gyroscope": (
    "What turned about it looks as if it were at rest, and the speed of a plate does not show. ")}


@dataclass(frozen=True, eq=False)
class PoseSource:
    """Files that a configuration lists together as poses at one rate of the plate.

    ``rate`` is the name of the setting, ``stopped`` at rest, None if the rate is not known.
    ``rate_rad_s`` is signed, positive counter-clockwise; ``clip`` is the clip that shows it.
    """

    layout: Layout
    tables: tuple[TableGuess, ...]
    rate: str | None
    rate_rad_s: float = 0.0
    clip: MeasuredClip | None = None

    def has(self, triad: Triad) -> bool:
        """Whether any of its tables has the triad."""
        return any(getattr(table, triad) for table in self.tables)

    @property
    def leans(self) -> bool:
        """Whether its files show a plate that leans: gravity goes round in the accelerometer."""
        forces = [table.si(table.accelerometer) for table in self.tables if table.accelerometer]
        squares = [(force.var(axis=0).sum() - len(AXES) * sample_noise_sd(force) ** 2)
                   / (force.mean(axis=0) ** 2).sum() for force in forces]
        return (self.rate not in (None, STOPPED) and self.layout == "files" and bool(squares)
                and float(np.median(squares)) >= LEAST_TILT_RAD**2)


@dataclass(frozen=True, eq=False)
class SessionGuess:
    """Everything that was guessed about the files.

    ``scales`` are the possible scales of the gyroscope that remain; empty if its scale is known.
    ``dead`` says of a triad which of its axes does not answer.
    """

    sources: tuple[PoseSource, ...]
    doubts: tuple[str, ...]
    scales: tuple[ScaleChoice, ...] = ()
    dead: Mapping[Triad, str] = field(default_factory=dict)

    @property
    def tables(self) -> tuple[TableGuess, ...]:
        """All tables, in the order of the sources."""
        return tuple(table for source in self.sources for table in source.tables)

    @property
    def accelerometer(self) -> TriadGuess | None:
        """The accelerometer of the first table that has one."""
        return next((t.accelerometer for t in self.tables if t.accelerometer), None)

    @property
    def gyroscope(self) -> TriadGuess | None:
        """The gyroscope of the first table that has one."""
        return next((t.gyroscope for t in self.tables if t.gyroscope), None)

    @property
    def turns(self) -> bool:
        """Whether a source turns at a rate of the plate that is known."""
        return any(source.rate not in (None, STOPPED) for source in self.sources)

    @property
    def at_rest(self) -> PoseSource | None:
        """The best source to calibrate the accelerometer: poses at rest, else any."""
        able = [source for source in self.sources if source.has("accelerometer")]
        return min(able, key=lambda source: source.rate_rad_s != 0, default=None)


def guess_session(
    tables: Sequence[TableGuess],
    clips: Sequence[MeasuredClip] = (),
    per_deg: float | None = None,
) -> SessionGuess:
    """Group tables by the type of their rows and by the rate at which they turn.

    Parameters
    ----------
    tables : sequence of TableGuess
    clips : sequence of MeasuredClip
    per_deg : float or None
        Units of the gyroscope per °/s, stated by the user.
    """
    alone, doubts = drop_alternatives(tables)
    dead = {triad: why for triad in TRIADS if (why := _dead_axis(alone, triad))}
    settled, scales = settle_scale(without_rate_bias(alone), clips, per_deg)
    scales = () if "gyroscope" in dead else scales
    settled = settled if scales else clocked_by_plate(settled)
    beside = _gyroscopes_beside(settled)
    layout: Layout = "log" if beside else _layout(settled)  # a pose is one file, or find: still
    if layout == "files":
        settled, notes = without_continuations(settled)
        doubts += notes
    doubts += [*_doubts_of_tables(settled, beside)]
    groups: dict[tuple[Layout, float | None, bool], dict[TableGuess, float]] = {}
    rates = [beside.get(table, table) for table in settled]
    for table, rate, usual in zip(settled, rates, speeds_of([t.turning_rad_s for t in rates]),
                                  strict=True):
        kind: Layout = "means" if table.are_means else layout
        force = next((one for one, other in beside.items() if other is rate), table)
        is_open = bool(scales or "gyroscope" in dead or _has_no_unit(rate))
        every = speeds_in(force, rate) if kind == "log" and not is_open else []
        for turns, clockwise in every or [(usual, "gyroscope" not in dead and bool(usual)
                                           and rate.turns_clockwise(force))]:
            rpm = 0.0 if not turns else None if is_open else _speed_rpm(turns, clips)
            groups.setdefault((kind, rpm, clockwise), {})[table] = turns
    sources = tuple(
        _source("log", rpm, clockwise, _paired([*group], beside), [*group.values()], clips)
        if kind == "log" or (kind == "files" and not _are_poses([*group])) else
        _source(kind, rpm, clockwise, [*group], [*group.values()], clips)
        for (kind, rpm, clockwise), group in groups.items())
    used = {source.clip.path for source in sources if source.clip}
    doubts += [f"{clip.path.name}: the plate turns at {clip.rate_rad_s / RPM:+.4g} rpm in it, and "
               f"no log does; the clip is not used" for clip in clips if clip.path not in used]
    if not (scales or "gyroscope" in dead or any(map(_has_no_unit, settled))):
        doubts += _rate_doubts(sources)
    return SessionGuess(sources, tuple(dict.fromkeys(doubts)), scales, dead)


def _has_no_unit(table: TableGuess) -> bool:
    """Whether no unit and no range explains its gyroscope, so that no speed follows from it."""
    return table.gyroscope is not None and table.gyroscope.is_unusual


def _dead_axis(tables: Sequence[TableGuess], triad: Triad) -> str:
    """A triad of which one axis reads one number in all tables, while another one turns."""
    seen = [(one, table) for table in tables if (one := getattr(table, triad))]
    if not seen:
        return ""
    values = [table.si(one) for one, table in seen]
    low, high = (of([of(readings, axis=0) for readings in values], axis=0)
                 for of in (np.nanmin, np.nanmax))
    axis, (first, table) = int((high - low).argmin()), seen[0]
    if high[axis] > low[axis] or (high - low).max() < LEAST_MOVE[triad]:
        return ""
    name = first.columns[axis]
    return (f"{triad} {AXES[axis]} is dead: '{name}' reads {table.table.columns[name][0]:g} in "
            f"every row of all logs, where the other axes turn. {SO_DEAD[triad]}Check its wiring, "
            f"and whether its column is that of the axis.")


def _speed_rpm(rate_rad_s: float, clips: Sequence[MeasuredClip]) -> float | None:
    """Nominal speed of a turning table, by the clip or the speeds of record players; else None."""
    clip = matching_clip(rate_rad_s, clips)
    return nominal_rpm(clip.rate_rad_s) if clip else record_rpm(rate_rad_s)


def _source(
    layout: Layout, rpm: float | None, clockwise: bool, tables: Sequence[TableGuess],
    speeds: Sequence[float], clips: Sequence[MeasuredClip],
) -> PoseSource:
    """Tables of one setting with their speeds, rad/s, and their clip; ``rpm`` is 0 at rest and None
    if not known."""
    if rpm == 0:
        return PoseSource(layout, tuple(tables), STOPPED)
    sign = -1.0 if clockwise else 1.0
    turning = sign * float(np.median([speed for speed in speeds if speed]))
    if rpm is None:
        return PoseSource(layout, tuple(tables), None, turning)
    clip = matching_clip(turning, clips)
    if clip is not None and len(clips) > 1 and clip.rate_rad_s * turning < 0:
        clip = None  # another clip shows the other direction
    name = f"{'m' if clockwise else ''}{rpm:.3g}rpm"
    return PoseSource(layout, tuple(tables), name, sign * rpm * RPM, clip)


def _doubts_of_tables(
    tables: Sequence[TableGuess], beside: Mapping[TableGuess, TableGuess]
) -> list[str]:
    """The doubts about the tables, each reported once with its number of files, whatever its
    numbers; a gyroscope in a table ``beside`` is not missed."""
    alike: dict[str, list[str]] = {}
    for table in tables:
        for doubt in (*table.doubts, *(() if table in beside else table.misses)):
            alike.setdefault(NUMBER.sub("", doubt), [
                short_name(table.path, [each.path for each in tables]), doubt]).append("")
    return [f"{file}{f' and {len(more) - 1} more' if more[1:] else ''}: {doubt}"
            for file, doubt, *more in alike.values()]


def _layout(tables: Sequence[TableGuess]) -> Layout:
    """``files`` if each table is one pose, ``log`` if tables hold many poses."""
    alone = [table for table in tables if table.accelerometer] or list(tables)
    return "files" if len(alone) >= FEWEST_MEANS and _are_poses(alone) else "log"


def _are_poses(tables: Sequence[TableGuess]) -> bool:
    """Whether more than half of the tables are single poses."""
    return sum(map(_is_pose, tables)) > len(tables) / 2


def _is_pose(table: TableGuess) -> bool:
    log = table.log()
    if log is None or log.time_s[-1] - log.time_s[0] > MOST_POSE_S:
        return False
    try:
        average_pose(log, dict.fromkeys(TRIADS, SI), table.turning_rad_s)
    except CalibrationError:
        return False
    return True


def _gyroscopes_beside(tables: Sequence[TableGuess]) -> dict[TableGuess, TableGuess]:
    """For each accelerometer table the gyroscope table of the same times and the same recording
    (one archive, or one folder); of several that which turns gravity."""
    waiting = [table for table in tables if table.accelerometer is None and not table.are_means]
    beside = {}
    for table in tables:
        if table.gyroscope is None and not table.are_means:
            able = [other for other in waiting if other.path.parent == table.path.parent
                    and table.clock.overlaps(other.clock)]
            if able:
                beside[table] = able[0] if len(able) == 1 else max(
                    able, key=lambda other: turn.agreement if (turn := other.turn([table])) else 0)
                waiting.remove(beside[table])
    return beside


def _paired(
    tables: Sequence[TableGuess], beside: Mapping[TableGuess, TableGuess]
) -> list[TableGuess]:
    """The tables with each accelerometer before its gyroscope, and other gyroscopes last."""
    waiting = [table for table in tables if table.accelerometer is None]
    ordered: list[TableGuess] = []
    for table in (table for table in tables if table.accelerometer):
        other = None if table.gyroscope else beside.get(table) or next(
            (one for one in waiting if table.clock.overlaps(one.clock)), None)
        ordered += [table, *(one for one in waiting if one is other)]
        waiting = [one for one in waiting if one is not other]
    return ordered + waiting


def _rate_doubts(sources: Sequence[PoseSource]) -> list[str]:
    doubts, paths = [], [table.path for source in sources for table in source.tables]
    for source in sources:
        name = short_name(source.tables[0].path, paths)
        if source.rate is None:
            doubts.append(
                f"{name}: the gyroscope turns at about {abs(source.rate_rad_s) / RPM:.3g} rpm, "
                f"which is no speed of a record player; add a clip of the plate, or state its "
                f"rate in the configuration, to calibrate the gyroscope by it")
        elif source.rate != STOPPED and source.clip is None:
            doubts.append(
                f"{name}: the plate turns as a record player at "
                f"{abs(source.rate_rad_s) / RPM:.3g} rpm; the nominal rate "
                f"is taken with an sd of {RECORD_SD:.0%}, which the scale of the gyroscope "
                f"inherits. A clip of the plate gives 50 ppm")
    return doubts
