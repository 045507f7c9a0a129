"""The history of a session: one line for every run, so that the error is compared by model."""

import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, fields
from datetime import datetime
from pathlib import Path
from typing import Any

from calib.poses.imu_log import TRIADS
from pipeline.errors import UnreadableInput
from pipeline.results.schema.history import HistoryLine
from pipeline.results.schema.types import problems_of
from pipeline.text.formatting import DISPLAY
from pipeline.text.model_name import short_model
from pipeline.text.tables import table_lines

HISTORY_NAME = "history.jsonl"


@dataclass(frozen=True)
class TriadStep:
    """One triad in one run; the errors are in SI units."""

    model: tuple[str, ...]
    residual_rms: float
    loo_rms: float
    chi2: float
    dof: int
    verdict: str


@dataclass(frozen=True)
class Step:
    """One run: local time to the second, hash of its configuration, and its triads by name."""

    when: str
    config_sha256: str
    triads: Mapping[str, TriadStep]


def read_history(folder: Path) -> tuple[Step, ...]:
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
    return tuple(_step(path, i, line) for i, line in enumerate(lines, 1))


def _step(path: Path, number: int, line: str) -> Step:
    try:
        entry = json.loads(line)
        problems = problems_of(HistoryLine, entry)
    except (ValueError, RecursionError) as error:
        problems = str(error)
    if problems:
        raise UnreadableInput(
            f"{path}:{number}: is not a line that `pipeline run` writes ({problems}). Delete the "
            f"line, or the file to begin a new history."
        )
    kept = [field.name for field in fields(TriadStep)]
    triads: dict[str, TriadStep] = {
        triad: TriadStep(**{name: entry[triad][name] for name in kept}
                         | {"model": tuple(entry[triad]["model"])})
        for triad in TRIADS
        if entry[triad] is not None
    }
    return Step(entry["when"], entry["config_sha256"], triads)


def with_step(
    earlier: Sequence[Step], results: Mapping[str, Any], when: datetime
) -> tuple[Step, ...]:
    """The history ``earlier`` with one step more, for the results of a run."""
    triads: dict[str, TriadStep] = {
        triad: _triad_step(results[triad]) for triad in TRIADS if results[triad] is not None
    }
    return (*earlier, Step(when.isoformat(timespec="seconds"), results["config_sha256"], triads))


def history_text(steps: Sequence[Step]) -> str:
    """The text of the history, a line for each run."""
    return "".join(_line(step) + "\n" for step in steps)


def _triad_step(section: Mapping[str, Any]) -> TriadStep:
    kept = {key: section[key] for key in ("residual_rms", "loo_rms", "chi2", "dof")}
    return TriadStep(
        model=tuple(section["model"]), verdict=section["diagnosis"]["verdict"], **kept
    )


def _line(step: Step) -> str:
    line: dict[str, Any] = {"when": step.when, "config_sha256": step.config_sha256}
    for triad in TRIADS:
        line[triad] = asdict(step.triads[triad]) if triad in step.triads else None
    return json.dumps(line, ensure_ascii=False)


def history_rows(steps: Sequence[Step]) -> dict[str, list[tuple[str, ...]]]:
    """A table for each triad, titles first; of neighbouring runs with one result, the last."""
    tables: dict[str, list[tuple[str, ...]]] = {}
    for triad in TRIADS:
        steps_of = [(step, step.triads[triad]) for step in steps if triad in step.triads]
        if not steps_of:
            continue
        unit, factor = DISPLAY[triad]
        tables[triad] = [("when", "model", f"RMS [{unit}]", "leave-one-out", "chi²/dof", "verdict")]
        tables[triad] += [
            (
                step.when[:16].replace("T", " "),
                short_model(result.model),
                f"{result.residual_rms * factor:.4g}",
                f"{result.loo_rms * factor:.4g}",
                f"{result.chi2 / result.dof:.2f}",
                result.verdict,
            )
            for step, result in _merged(steps_of)
        ]
    return tables


def run_history_lines(steps: Sequence[Step]) -> list[str]:
    """The same, aligned for a terminal."""
    tables = history_rows(steps)
    return [line for triad, rows in tables.items() for line in (triad, *table_lines(rows))]


def _merged(steps_of: list[tuple[Step, TriadStep]]) -> list[tuple[Step, TriadStep]]:
    """The last of neighbouring runs with the same result."""
    following = [result for _, result in steps_of[1:]] + [None]
    return [pair for pair, after in zip(steps_of, following, strict=True) if pair[1] != after]
