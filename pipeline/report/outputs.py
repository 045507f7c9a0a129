"""Everything a run leaves in its folder, each file written whole."""

from datetime import datetime
from pathlib import Path

from pipeline.files import write_whole
from pipeline.report.page import REPORT_NAME, report_html
from pipeline.results.history import read_history, with_step, write_history
from pipeline.results.write import results_of, write_results
from pipeline.stages.run import Outcome


def write_outputs(outcome: Outcome, folder: Path) -> Path:
    """Write results, history and report into ``folder``; returns the report's path.

    All three are made before the first is written.

    Raises
    ------
    UnwritableOutput
        A file cannot be written; it then is as it was before.
    UnreadableInput
        The history there is damaged; nothing is written.
    """
    found = results_of(outcome)
    history = read_history(folder)
    if outcome.triads:
        history = with_step(history, found, datetime.now().astimezone())
    report, page = folder / REPORT_NAME, report_html(outcome, history, folder)
    write_results(folder, found)
    if outcome.triads:
        write_history(folder, history)
    write_whole(report, page)
    return report
