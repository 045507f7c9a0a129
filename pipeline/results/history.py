"""The history of a session: one line for each run, for comparing the errors of models."""

import json
from collections.abc import Sequence
from datetime import datetime
from itertools import groupby
from operator import itemgetter
from pathlib import Path

from calib.poses.imu_log import TRIADS
from calib.poses.triad_kind import TRIAD_KINDS
from pipeline.errors import UnreadableInput
from pipeline.results.schema.file import ResultsFile
from pipeline.results.schema.noise import HistoryLine, HistoryTriad
from pipeline.text.formatting import DISPLAY, short_model
from pipeline.text.tables import table_lines

HISTORY_NAME = "history.jsonl"


def read_history(folder: Path) -> tuple[HistoryLine, ...]:
    """All runs into ``folder``, oldest first; none where nothing was run.

    Raises
    ------
    UnreadableInput
        A line is not one that a run has written.
    """
    path = folder / HISTORY_NAME
    if not path.exists():
        return ()
    try:
        lines = path.read_text(encoding="utf-8").splitlines()
    except (OSError, UnicodeDecodeError) as error:
        raise UnreadableInput(
            f"{path}: cannot be read ({error}). Delete it to begin a new history."
        ) from error
    return tuple(_read_line(path, i, line) for i, line in enumerate(lines, 1))


def _read_line(path: Path, number: int, line: str) -> HistoryLine:
    try:
        return HistoryLine.parsed(json.loads(line))
    except (ValueError, RecursionError) as error:
        raise UnreadableInput(
            f"{path}:{number}: is not a line that `pipeline run` writes ({error}). Delete the "
            f"line, or the file to begin a new history."
        ) from error


def with_step(
    earlier: Sequence[HistoryLine], results: ResultsFile, when: datetime
) -> tuple[HistoryLine, ...]:
    """The history ``earlier`` with one more run, that of ``results``."""
    steps = {str(triad): HistoryTriad.of(section, verdict=section.diagnosis.verdict)
             for triad, section in results.triads.items()}
    triads = {triad: steps.pop(triad, None) for triad in TRIADS}
    return (*earlier, HistoryLine.of(
        when=when.isoformat(timespec="seconds"), config_sha256=results.config_sha256,
        **triads, **{"further": steps} if steps else {}))


def history_text(lines: Sequence[HistoryLine]) -> str:
    """The text of the history, a line for each run."""
    return "".join(json.dumps(line.as_json(), ensure_ascii=False) + "\n" for line in lines)


def history_rows(steps: Sequence[HistoryLine]) -> dict[str, list[tuple[str, ...]]]:
    """A table for each triad, titles first; of neighbouring runs with one result, the last."""
    tables: dict[str, list[tuple[str, ...]]] = {}
    for triad in TRIAD_KINDS:
        steps_of = [(step, step.triads[triad]) for step in steps if triad in step.triads]
        if not steps_of:
            continue
        last = [[*equal][-1] for _, equal in groupby(steps_of, key=itemgetter(1))]
        unit, factor = DISPLAY[triad]
        tables[triad] = [("when", "model", f"RMS [{unit}]", "leave-one-out", "chi²/dof", "dof",
                          "verdict")]
        tables[triad] += [
            (
                step.when[:16].replace("T", " "),
                short_model(result.model),
                f"{result.residual_rms * factor:.4g}",
                f"{result.loo_rms * factor:.4g}",
                f"{result.chi2 / result.dof:.2f}",
                str(result.dof),
                result.verdict,
            )
            for step, result in last
        ]
    return tables


def run_history_lines(steps: Sequence[HistoryLine]) -> list[str]:
    """The same table, aligned for a terminal."""
    tables = history_rows(steps)
    return [line for triad, rows in tables.items() for line in (triad, *table_lines(rows))]
