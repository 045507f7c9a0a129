"""When all sessions are done: the table, and what it shows."""

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from pipeline.fleet.record import SessionRecord
from pipeline.fleet.rows import Row
from pipeline.fleet.table import table_of, write_table


@dataclass(frozen=True, eq=False)
class FleetSummary:
    """What a fleet run has made.

    ``rows`` of the table, the ``records`` by session, and the median ``seconds`` of each stage.
    """

    output: Path
    rows: Sequence[Row]
    records: Sequence[SessionRecord]
    seconds: Mapping[str, float]

    @property
    def failures(self) -> Mapping[int, int]:
        """How many sessions ended with each exit code that is not 0."""
        codes = Counter(record.exit_code for record in self.records)
        return {code: count for code, count in sorted(codes.items()) if code}


def finish_fleet(records: Sequence[SessionRecord], output: Path) -> FleetSummary:
    """Write the table of ``records``."""
    rows = table_of(records)
    write_table(rows, output)
    ordered = sorted(records, key=lambda record: record.name)
    return FleetSummary(output, rows, ordered, _typical_seconds(ordered))


def _typical_seconds(records: Sequence[SessionRecord]) -> dict[str, float]:
    stages = dict.fromkeys(stage for record in records for stage in record.seconds)
    return {stage: float(np.median([record.seconds[stage] for record in records
                                    if stage in record.seconds])) for stage in stages}
