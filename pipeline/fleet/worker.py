"""A session of a fleet run by a worker, unless its results are of the same input."""

import hashlib
import os
import time
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from calib.diagnosis.population.evidence import evidence_of
from calib.errors import CalibrationError
from calib.mounting.mounting import Mounting
from pipeline.config.load import Config, load_config
from pipeline.config.session import named_files
from pipeline.errors import (
    PipelineError,
    UnreadableInput,
    exit_code_of,
    expected_failure,
    message_of,
)
from pipeline.fleet.sessions import (
    FleetSession,
    SessionRecord,
    evidence_path,
    folder_of,
    kept_record,
    write_evidence,
    write_record,
)
from pipeline.fleet.table import rows_of_failure, rows_of_results
from pipeline.report.page import outputs_of
from pipeline.results.names import RESULTS_NAME
from pipeline.results.write import results_of, results_text
from pipeline.session_folder import working_on, write_session
from pipeline.stages.context import RunContext
from pipeline.stages.rate import SettingRate
from pipeline.stages.recordings import Recordings
from pipeline.stages.run import StageResult, run_stages
from pipeline.stages.triads import TriadResult
from pipeline.text.names import program_version
from vision.errors import VisionError

RECORD_FORMAT = 3
"""Raise it whenever the contents of a record change."""


def input_digest(config: Config, allow_python: bool, reports: bool) -> str:
    """The SHA-256 of everything that decides the results of ``config``.

    Parameters
    ----------
    config : Config
    allow_python, reports : bool
        Whether Python effects may run, and whether a report is written.

    Raises
    ------
    UnreadableInput
        A file that it names cannot be read.
    """
    options = (program_version(), RECORD_FORMAT, allow_python, reports)
    digest = hashlib.sha256(repr(options).encode())
    digest.update(config.source.text.encode())
    folder = config.source.path.parent
    for path in sorted({*named_files(config)}):
        digest.update(os.fsencode(os.path.relpath(path, folder)))
        digest.update(_digest(path))
    return digest.hexdigest()


def _digest(path: Path) -> bytes:
    try:
        with path.open("rb") as file:
            return hashlib.file_digest(file, "sha256").digest()
    except OSError as error:
        raise UnreadableInput(f"{path}: cannot be read ({error.strerror}). Check the name, and "
                              "that you may read the file.") from error


STAGES: Mapping[type, str] = {
    SettingRate: "rates", Recordings: "logs", Mounting: "installation"}


@dataclass(frozen=True)
class FleetTask:
    """Task of a worker: one session, the fleet's folder of results, and options.

    ``allow_python`` lets Python effects run; ``reports`` writes report.html of each session.
    """

    session: FleetSession
    output: Path
    allow_python: bool
    reports: bool


class StageClock:
    """Processor time of each stage of a run, s, all threads of this process together."""

    def __init__(self) -> None:
        self.seconds: dict[str, float] = {}
        self._since = time.process_time()

    def lap(self, stage: str) -> None:
        """End the stage; the next begins."""
        now = time.process_time()
        self.seconds[stage] = self.seconds.get(stage, 0.0) + now - self._since
        self._since = now

    def on_result(self, result: StageResult) -> None:
        """Note that a stage has its result."""
        self.lap(result.triad if isinstance(result, TriadResult) else STAGES[type(result)])


def work_on(task: FleetTask) -> SessionRecord:
    """The record of a session; made now, unless one of the same inputs is kept.

    A session that is refused or cannot be read has a record with the reason. An unexpected
    exception is a bug and is raised.
    """
    session = task.session
    config, key = None, ""
    try:
        config = load_config(session.config)
        key = input_digest(config, task.allow_python, task.reports)
        kept = kept_record(task.output, session.name)
        if kept is not None and kept.input_digest == key and kept.sensor == session.sensor:
            return kept
        record = _run(task, key)
    except (PipelineError, CalibrationError, VisionError) as error:
        record = _failure(session, config, key, error)
    except (OSError, MemoryError) as error:
        # Without a digest, so that the next run tries it again.
        record = _failure(session, config, "", expected_failure(error))
    write_record(task.output, record)
    return record


def _failure(
    session: FleetSession, config: Config | None, key: str,
    error: PipelineError | CalibrationError | VisionError,
) -> SessionRecord:
    code, reason = exit_code_of(error), message_of(error)
    rows = rows_of_failure(session, config, code, reason)
    return SessionRecord(session.name, session.sensor, key, code, reason, rows)


def _run(task: FleetTask, key: str) -> SessionRecord:
    """Every stage; results, report and evidence in the session's folder of the fleet."""
    session, clock = task.session, StageClock()
    place = folder_of(task.output, session.name)
    with working_on(session.config, place, replaces=None) as (config, folder):
        context = RunContext(folder / "cache", allow_python=task.allow_python)
        outcome = run_stages(config, context, clock.on_result)
        clock.lap("end")
        results = results_of(outcome)
        if task.reports:
            write_session(folder, outputs_of(outcome, folder))
        else:
            write_session(folder, {RESULTS_NAME: results_text(results)})
        clock.lap("files")
        for result in outcome.triads:
            evidence = evidence_of(result.calibration.fit,
                                   tuple(result.made_from.defined.values()), config.covariates)
            write_evidence(evidence_path(task.output, session.name, result.triad), evidence)
        clock.lap("evidence")
    return SessionRecord(
        session.name, session.sensor, key, 0, "", rows_of_results(session, results), clock.seconds
    )
