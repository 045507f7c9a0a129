"""End of a fleet run: the table, the statistics of the lot, and the printed summary."""

import json
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from calib.diagnosis.population.evidence import Trial
from calib.diagnosis.population.lot import LotEvidence
from calib.diagnosis.population.pool import Pool, pool
from pipeline.errors import BUG, DONE, FIT_FAILED, UNDETERMINED, UNREADABLE, USAGE
from pipeline.fleet.limits import Limits, limit_lines, with_limits
from pipeline.fleet.over_time import sensors_over_time
from pipeline.fleet.page import PAGE_NAME, fleet_html
from pipeline.fleet.population import (
    POPULATION_NAME,
    Pooled,
    TriadPopulation,
    copies_text,
    pool_text,
    population_json,
    populations_of,
    repeat_text,
)
from pipeline.fleet.sessions import SessionRecord, evidence_blocks
from pipeline.fleet.table import CSV_NAME, PARQUET_NAME, fleet_table, write_table
from pipeline.results.json_values import Json
from pipeline.results.written import write_output
from pipeline.text.formatting import count

if TYPE_CHECKING:
    from pandas import DataFrame

OUTPUTS = (CSV_NAME, PARQUET_NAME, POPULATION_NAME, PAGE_NAME)  #: names of its files
MEANING = {
    BUG: "ended by a bug or a lost worker",
    USAGE: "wrong configuration",
    UNREADABLE: "unreadable input",
    UNDETERMINED: "the data do not determine the result",
    FIT_FAILED: "the fit failed its own check",
}
"""Meanings of the exit codes of sessions that were not calibrated."""


@dataclass(frozen=True, eq=False)
class FleetSummary:
    """Summary of a lot.

    ``table`` of all sessions, what the lot shows of each triad, the median ``seconds`` of each
    stage of a session, ``notes`` for the terminal.
    """

    output: Path
    table: "DataFrame"
    populations: Sequence[TriadPopulation]
    seconds: Mapping[str, float]
    notes: Sequence[str] = ()

    @property
    def exit_codes(self) -> Mapping[int, int]:
        """Number of sessions by exit code, 0 first."""
        ended = self.table.groupby("session")["exit_code"].max().value_counts()
        return {int(code): int(ended[code]) for code in sorted(ended.index)}

    @property
    def exit_code(self) -> int:
        """Exit code of the command: of a bug; done, if any session is calibrated; else that of all
        sessions, and of different ones that the data do not determine what was asked."""
        codes = self.exit_codes
        if BUG in codes or DONE in codes:
            return BUG if BUG in codes else DONE
        return next(iter(codes)) if len(codes) == 1 else UNDETERMINED


def finish_fleet(
    records: Sequence[SessionRecord], output: Path, reports: bool, limits: Limits | None = None
) -> FleetSummary:
    """Write table, population and page of ``records``; with links to ``reports`` if there are.

    ``limits`` are those of its sensors.

    Raises
    ------
    UnwritableOutput
        A file cannot be written, or is none that a fleet wrote.
    ConfigError
        A limit is of a column that the table does not have.
    """
    from pandas import DataFrame

    table = fleet_table([DataFrame.from_records([row for one in records for row in one.rows])])

    def pooled(triad: str, rows: "DataFrame") -> Pool | None:
        def blocks(_trials: Sequence[Trial] = ()) -> Iterator[LotEvidence]:
            pairs = zip(rows["session"], rows["sensor"], strict=True)
            return evidence_blocks(pairs, triad, output)

        return pool(blocks) if next(blocks(), None) is not None else None

    title = f"Fleet {output.absolute().name}"
    return write_lot(title, table, pooled, output, reports, limits=limits,
                     seconds=_typical_seconds(records))


def write_lot(
    title: str, table: "DataFrame", pooled: Pooled, output: Path, reports: bool = False, *,
    seconds: Mapping[str, float] | None = None, limits: Limits | None = None,
    more: Mapping[str, Json] | None = None, notes: Sequence[str] = (),
) -> FleetSummary:
    """Write the table of a lot, its population and its page.

    Parameters
    ----------
    title : str
    table : DataFrame
        As :func:`pipeline.fleet.table.fleet_table` makes it.
    pooled : callable
    output : Path
    reports : bool
        Whether each session has a report to link to.
    seconds : mapping of str to float, optional
    limits : Limits, optional
        What its sensors are to keep; then the table has a column of them.
    more : mapping of str to object, optional
        Further keys of population.json by triad.
    notes : sequence of str

    Raises
    ------
    UnwritableOutput
        A file cannot be written, or is none that a fleet wrote.
    ConfigError
        A limit is of a column that the table does not have.
    """
    if limits is not None:
        table = with_limits(table, limits)
    populations = populations_of(table, pooled)
    over_time = {one.triad: [*sensors_over_time(one, output)] for one in populations}
    whole = {each.triad: population_json(each) | (more or {}).get(each.triad, {}) | {
        "over_time": {one.sensor: one.as_json for one in over_time[each.triad]}}
        for each in populations}
    text = json.dumps(whole, indent=1, ensure_ascii=False, allow_nan=False)
    page = fleet_html(title, table, populations, over_time, reports, datetime.now().astimezone())
    write_table(table, output)
    write_output(output, output / POPULATION_NAME, text + "\n")
    write_output(output, output / PAGE_NAME, page)
    return FleetSummary(output, table, populations, seconds or {}, notes)


def _typical_seconds(records: Sequence[SessionRecord]) -> dict[str, float]:
    ordered = sorted(records, key=lambda record: record.name)
    stages = dict.fromkeys(stage for record in ordered for stage in record.seconds)
    return {stage: float(np.median([record.seconds[stage] for record in records
                                    if stage in record.seconds])) for stage in stages}


def fleet_lines(summary: FleetSummary) -> Iterator[str]:
    """Number of calibrated sessions, reasons of the others, the verdicts, and the cost."""
    table, codes = summary.table, summary.exit_codes
    sessions, sensors = table["session"].nunique(), table["sensor"].nunique()
    yield (f"{count(sessions, 'session')} of {count(sensors, 'sensor')}: "
           f"{codes.get(DONE, 0)} calibrated")
    for code, number in codes.items():
        if code != DONE:
            why = table[table["exit_code"] == code].iloc[0]
            yield (f"  {number} with exit code {code}: {MEANING.get(code, 'see the table')}. "
                   f"{why['session']}: {why['reason']}")
    for triad, rows in table[table["exit_code"] == DONE].groupby("triad"):
        verdicts = Counter(rows["verdict"]).most_common()
        yield f"{triad:15s} " + ", ".join(f"{n} {code}" for code, n in verdicts)
    yield from limit_lines(table)
    for population in summary.populations:
        # The sensors of one table have one session each, and no pattern that could name another.
        repeat = repeat_text(population) if population.repeats or summary.seconds else ""
        texts = pool_text(population), repeat, copies_text(population)
        yield from (f"{population.triad}: {text}" for text in texts if text)
    yield from summary.notes
    if summary.seconds:
        costs = ", ".join(f"{stage} {s:.2f}" for stage, s in summary.seconds.items() if s >= 0.005)
        yield f"median processor seconds of a session: {costs}"
    yield str(summary.output / PAGE_NAME)
