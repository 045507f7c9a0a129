"""When all sessions are done: the table, and what it shows."""

import json
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path

import numpy as np

from pipeline.config.file_patterns import natural_key
from pipeline.fleet.page import PAGE_NAME, fleet_html
from pipeline.fleet.population import (
    POPULATION_NAME,
    TriadPopulation,
    population_json,
    populations_of,
)
from pipeline.fleet.record import SessionRecord
from pipeline.fleet.rows import Row
from pipeline.fleet.table import CSV_NAME, PARQUET_NAME, fleet_rows, write_table
from pipeline.results.written import require_written, write_output


@dataclass(frozen=True, eq=False)
class FleetSummary:
    """What a fleet run has made.

    ``rows`` of the table, the ``records`` by session, what the lot shows of each triad, and the
    median ``seconds`` of each stage.
    """

    output: Path
    rows: Sequence[Row]
    records: Sequence[SessionRecord]
    populations: Sequence[TriadPopulation]
    seconds: Mapping[str, float]

    @property
    def failures(self) -> Mapping[int, int]:
        """How many sessions ended with each exit code that is not 0."""
        codes = Counter(record.exit_code for record in self.records)
        return {code: count for code, count in sorted(codes.items()) if code}


def require_own_lot(output: Path) -> None:
    """Refuse a folder whose files a fleet run would replace and did not write.

    Raises
    ------
    UnwritableOutput
        Naming the file.
    """
    require_written(output, (CSV_NAME, PARQUET_NAME, POPULATION_NAME, PAGE_NAME))


def finish_fleet(
    records: Sequence[SessionRecord], output: Path, reports: bool
) -> FleetSummary:
    """Write table, population and page of ``records``; with links to ``reports`` if there are.

    Raises
    ------
    UnwritableOutput
        A file cannot be written, or is none that a fleet wrote.
    """
    rows = fleet_rows(records)
    ordered = sorted(records, key=lambda record: natural_key(record.name))
    populations = populations_of(rows, output)
    text = json.dumps(population_json(populations), indent=1, ensure_ascii=False, allow_nan=False)
    title = f"Fleet {output.absolute().name}"
    page = fleet_html(title, ordered, populations, reports, datetime.now().astimezone())
    write_table(rows, output)
    write_output(output, output / POPULATION_NAME, text + "\n")
    write_output(output, output / PAGE_NAME, page)
    return FleetSummary(output, rows, ordered, populations, _typical_seconds(ordered))


def _typical_seconds(records: Sequence[SessionRecord]) -> dict[str, float]:
    stages = dict.fromkeys(stage for record in records for stage in record.seconds)
    return {stage: float(np.median([record.seconds[stage] for record in records
                                    if stage in record.seconds])) for stage in stages}
