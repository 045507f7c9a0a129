"""Everything a run leaves in its folder, as texts that are written together."""

from datetime import datetime
from pathlib import Path

from pipeline.report.page import report_html
from pipeline.results.history import HISTORY_NAME, history_text, read_history, with_step
from pipeline.results.names import REPORT_NAME, RESULTS_NAME
from pipeline.results.write import results_of, results_text
from pipeline.stages.run import Outcome


def outputs_of(outcome: Outcome, folder: Path) -> dict[str, str]:
    """Results, history and report by their names in ``folder``, where the history so far stands.

    Raises
    ------
    UnreadableInput
        The history there is damaged.
    ConfigError
        A user-defined effect cannot be read.
    """
    results = results_of(outcome)
    history, now = read_history(folder), datetime.now().astimezone()
    if outcome.triads:
        history = with_step(history, results, now)
    texts = {RESULTS_NAME: results_text(results)}
    if outcome.triads:
        texts[HISTORY_NAME] = history_text(history)
    return texts | {REPORT_NAME: report_html(outcome, history, folder, now)}
