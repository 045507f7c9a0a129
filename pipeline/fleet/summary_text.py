"""What a fleet run prints."""

from collections import Counter
from collections.abc import Iterator

from pipeline.errors import BUG, DONE, FIT_FAILED, UNDETERMINED, UNREADABLE, USAGE
from pipeline.fleet.finish import FleetSummary
from pipeline.fleet.limits import limit_lines
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
    table, codes = summary.table, summary.exit_codes
    sessions, sensors = table["session"].nunique(), table["sensor"].nunique()
    yield (f"{count(sessions, 'session')} of {count(sensors, 'sensor')}: "
           f"{codes.get(DONE, 0)} calibrated")
    for code, number in codes.items():
        if code != DONE:
            yield f"  {number} with exit code {code}: {MEANING.get(code, 'see the table')}"
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
