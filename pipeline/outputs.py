"""Everything a run leaves in its folder, each file written whole."""

from datetime import datetime
from pathlib import Path

from pipeline.files import write_whole
from pipeline.history import add_step, read_history
from pipeline.report import REPORT_NAME, report_html
from pipeline.results import results_of, write_results
from pipeline.runner import Outcome


def write_outputs(outcome: Outcome, folder: Path) -> Path:
    """Write results, history and report into ``folder``; returns the report's path.

    Raises
    ------
    UnwritableOutput
        A file cannot be written; it then is as it was before.
    UnreadableInput
        The history there is damaged.
    """
    found = results_of(outcome)
    write_results(folder, found)
    if outcome.triads:
        add_step(folder, found, datetime.now().astimezone())
    report = folder / REPORT_NAME
    write_whole(report, report_html(outcome, read_history(folder)))
    return report
