"""The text of the configuration of a guessed session."""

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from calib.earth import STANDARD_GRAVITY_M_S2
from calib.effects.catalogue import BASE
from calib.numbers import RPM
from calib.poses.imu_log import TEMPERATURE, TRIADS, Triad
from pipeline.config.file_patterns import names_of, relative_name
from pipeline.config.types import STOPPED
from pipeline.config.yaml_syntax import yaml_word
from pipeline.guess.session import RECORD_SD, PoseSource, SessionGuess
from pipeline.guess.table_guess import TableGuess
from pipeline.guess.units import TriadGuess
from pipeline.logs.clock import ASSUMED_HZ
from pipeline.logs.columns import SECONDS_PER, TIME, our_name
from pipeline.logs.header_words import read_name

#: Sd of gravity at an unknown place on Earth: 9.780 at the equator, 9.832 at the poles.
GRAVITY_SD_M_S2 = 0.02
WIDTH = 96  #: largest width of a list of names on one line


@dataclass(frozen=True)
class Choices:
    """Input beside the files: the site stated by the user, and the results of the check.

    ``site`` is the text of the section, None if the site is unknown; ``left_out`` gives the reason
    why a triad is not calibrated.
    """

    site: str | None = None
    left_out: Mapping[str, str] = field(default_factory=dict)


def config_text(guess: SessionGuess, folder: Path, choices: Choices) -> str:
    """The configuration, with a comment for every doubt."""
    first = dict.fromkeys(relative_name(table.path, folder) for table in guess.tables[:3])
    names = ", ".join(first)
    more = " and others" if len(guess.tables) > 3 else ""
    lines = [f"# Written by `pipeline import` from {_comment(names)}{more}.",
             f"title: {yaml_word(_comment(_title(guess)))}", ""]
    lines += [f"# Not sure: {_comment(doubt)}" for doubt in guess.doubts]
    lines += ["", "sensor:"]
    for name in TRIADS:
        triad = getattr(guess, name)
        if triad is not None and not (guess.scales and name == "gyroscope"):
            lines.append(f"  {name}: {_sheet(triad)}   # {_comment(triad.unit)}")
    lines += _covariates(guess)
    lines += ["", *_site(choices.site), *_rates(guess, folder)]
    lines += [line for name in TRIADS for line in _triad(guess, name, folder, choices)]
    return "\n".join(lines).replace("\n\n\n", "\n\n") + "\n"


def _title(guess: SessionGuess) -> str:
    """The name of the only file, or of the folder that all are in."""
    where = Path(os.path.commonpath([table.path.resolve() for table in guess.tables]))
    return where.name.partition(".")[0] or "session"


def _covariates(guess: SessionGuess) -> list[str]:
    """The lines ``covariates``, if a column that counts the rows would be taken for one."""
    columns = {name: table.table.columns[name] for table in guess.tables[:1]
               if not table.table.positions for name in table.further}
    counters = [name for name, values in columns.items()
                if len(values) > 2 and values[0] != values[1] and np.ptp(np.diff(values)) == 0]
    if not counters:
        return []
    temperature = [TEMPERATURE] if all(TEMPERATURE in t.theirs for t in guess.tables) else []
    known = [*temperature, *(yaml_word(name) for name in columns if name not in counters
                             and read_name(name).quantity == "")]
    return ["", f"# {_comment(', '.join(counters))} only counts the rows.",
            f"covariates: [{', '.join(known)}]"]


def _site(site: str | None) -> list[str]:
    if site is not None:
        return [f"site: {site}"]
    return ["# Gravity anywhere on Earth. Your latitude makes the scale 200 times more certain:",
            "#   site: {latitude_deg: ..., height_m: ...}",
            f"site: {{gravity_m_s2: {STANDARD_GRAVITY_M_S2:g}, sd_m_s2: {GRAVITY_SD_M_S2:g}}}"]


def _rates(guess: SessionGuess, folder: Path) -> list[str]:
    turning = {source.rate: source for source in guess.sources
               if source.rate not in (None, STOPPED)}
    if not turning:
        return []
    lines = ["", "rate:"]
    for name, source in turning.items():
        rate = source.rate_rad_s
        if source.clip is not None:
            stated = (f"{{video: {yaml_word(relative_name(source.clip.path, folder))}, "
                      f"nominal_rpm: {abs(rate) / RPM:.4g}}}")
        else:
            stated = (f"{{rate_rad_s: {rate:.6g}, sd_rad_s: {RECORD_SD * abs(rate):.2g}}}   "
                      f"# the nominal speed; a clip is better: {{video: clip.mp4}}")
        lines.append(f"  {yaml_word(str(name))}: {stated}")
    return lines


def _triad(guess: SessionGuess, name: Triad, folder: Path, choices: Choices) -> list[str]:
    """The section of a triad: the poses at rest of an accelerometer, all runs of a gyroscope."""
    best = guess.at_rest
    sources = ([best] if best else []) if name == "accelerometer" else [
        source for source in guess.sources if source.has(name) and source.rate]
    reason = open_scale_text(guess) if guess.scales and name == "gyroscope" else (
        choices.left_out.get(name))
    if reason or not sources:
        return ["", f"# {name}: left out, since {_comment(reason)}"] if reason else []
    as_runs = name == "gyroscope" or sources[0].leans
    lines = ["", f"{name}:", f"  {'runs' if as_runs else 'poses'}:"]
    for source in sources:
        lines += _run(source, folder) if as_runs else _poses(source, folder, "    ")
    model: Sequence[str] = BASE
    if name == "gyroscope" and all(source.rate == STOPPED for source in sources):
        lines.append("  # All at rest: that shows the bias. A turning plate shows scale and "
                     "misalignment.")
        model = ("bias",)
    return [*lines, f"  model: [{', '.join(model)}]"]


def _run(source: PoseSource, folder: Path) -> list[str]:
    """The lines of a source under ``runs``."""
    return ["    - poses:", *_poses(source, folder, "        "),
            f"      rate: {yaml_word(str(source.rate))}"]


def open_scale_text(
    guess: SessionGuess, other: str = "add a clip of the turning plate to the files"
) -> str:
    """Reason why the gyroscope is not used, and how to decide its unit or range: by an option, or
    by ``other``.
    """
    last = guess.scales[-1]
    answer = f"--gyroscope-{'unit' if last.unit else 'range'} {last.answer}"
    return (f"nothing shows its {'unit' if guess.scales[0].unit else 'range'}: "
            f"{', '.join(choice.says for choice in guess.scales)}. State it, for example by "
            f"{answer}, or {other}")


def _poses(source: PoseSource, folder: Path, indent: str) -> list[str]:
    """The lines of the section ``poses`` of a source."""
    paths = [yaml_word(name) for name in _names(source, folder)]
    lines = [f"{source.layout}:{_listed(paths)}"]
    columns = [table.columns for table in source.tables]
    if any(names is not None for names in columns):
        rows = [_columns(table, names) for table, names in zip(source.tables, columns, strict=True)]
        same = len(set(rows)) == 1
        lines.append(f"columns:{_listed(rows[:1] if same else rows)}")
    if source.layout != "means":
        lines += _clock(source)
    if source.layout == "log":
        lines.append("find: still")
    return [indent + line for line in "\n".join(lines).replace("\n", f"\n{indent}").split(
        f"\n{indent}")]


def _names(source: PoseSource, folder: Path) -> list[str]:
    """The files of a source, as a pattern if all of them have the same columns."""
    paths = [table.path for table in source.tables]
    uniform = all(table.columns == source.tables[0].columns for table in source.tables)
    return (names_of(paths, folder) if source.layout == "files" and uniform else
            [relative_name(path, folder) for path in paths])


def _clock(source: PoseSource) -> list[str]:
    """The line with the sample rate of tables of which none has times; at rest none is needed. Or
    that with the unit of times that is not that of their name, as of ``time_ms`` in seconds."""
    clock = source.tables[0].clock
    if clock.column and clock.unit and our_name(clock.column) not in (
            (clock.column, 1.0), (TIME, SECONDS_PER[clock.unit])):
        return [f"time_unit: {clock.unit}"]
    without = [table.clock for table in source.tables if table.clock.column is None]
    if len(without) < len(source.tables):
        return []
    rate_hz = without[0].rate_hz
    if rate_hz is None:
        return [f"sample_rate_hz: {ASSUMED_HZ:g}   # a guess: the file does not state it"]
    return [f"sample_rate_hz: {rate_hz:g}"]


def _columns(table: TableGuess, columns: list[str] | dict[str, str] | None) -> str:
    if isinstance(columns, list):
        return f"[{', '.join(columns)}]"
    pairs = table.theirs if columns is None else columns
    return "{" + ", ".join(f"{name}: {yaml_word(theirs)}" for name, theirs in pairs.items()) + "}"


def _listed(items: Sequence[str]) -> str:
    """One item alone, or a list, on several lines if it is long; the text after a key's colon."""
    if len(items) == 1:
        return f" {items[0]}"
    flat = f" [{', '.join(items)}]"
    if len(flat) <= WIDTH:
        return flat
    return "\n" + "\n".join(f"  - {item}" for item in items)


def _sheet(triad: TriadGuess) -> str:
    return "{" + ", ".join(
        f"{key}: {value:g}" if isinstance(value, int | float) else f"{key}: {value}"
        for key, value in triad.sheet) + "}"


def _comment(text: str) -> str:
    """``text`` with ``?`` for control characters, so that a name in a file cannot end a comment."""
    return "".join(sign if sign.isprintable() else "?" for sign in text)
