"""What a fleet run prints."""

from collections import Counter
from collections.abc import Iterator

from pipeline.errors import BUG, FIT_FAILED, UNDETERMINED, UNREADABLE, USAGE
from pipeline.fleet.finish import FleetSummary
from pipeline.fleet.page import PAGE_NAME
from pipeline.fleet.words import copies_text, pool_text, repeat_text
from pipeline.text.formatting import count

MEANING = {
    BUG: "ended by a bug or a lost worker",
    USAGE: "wrong configuration",
    UNREADABLE: "unreadable input",
    UNDETERMINED: "the data do not determine the result",
    FIT_FAILED: "the fit failed its own check",
}


def fleet_lines(summary: FleetSummary) -> Iterator[str]:
    """How many sessions were calibrated, why others were not, the verdicts, and what it cost."""
    calibrated = sum(record.exit_code == 0 for record in summary.records)
    sensors = len({record.sensor for record in summary.records})
    yield (f"{count(len(summary.records), 'session')} of {count(sensors, 'sensor')}: "
           f"{calibrated} calibrated")
    for code, number in summary.failures.items():
        yield f"  {number} with exit code {code}: {MEANING.get(code, 'see the table')}"
    for triad in dict.fromkeys(row["triad"] for row in summary.rows if row["exit_code"] == 0):
        verdicts = Counter(row["verdict"] for row in summary.rows
                           if row["triad"] == triad and row["exit_code"] == 0)
        yield f"{triad:15s} " + ", ".join(f"{n} {code}" for code, n in verdicts.most_common())
    for population in summary.populations:
        yield f"{population.triad}: {pool_text(population)}"
        yield f"{population.triad}: {repeat_text(population)}"
        if population.copies:
            yield f"{population.triad}: {copies_text(population)}"
    if summary.seconds:
        costs = ", ".join(f"{stage} {s:.2f}" for stage, s in summary.seconds.items() if s >= 0.005)
        yield f"median processor seconds of a session: {costs}"
    yield str(summary.output / PAGE_NAME)
