"""Files of one session for the fleet: its rows, their cost, and its evidence.

A record is written last, with the digest of the session's inputs. A later run with the same digest
keeps it.
"""

import io
import json
import zipfile
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import asdict, dataclass, field
from functools import cache
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np

from calib.diagnosis.population.evidence import Evidence, Trial
from calib.diagnosis.population.lot import AT_ONCE, LotEvidence
from pipeline.files import write_whole

RECORD_NAME = "fleet.json"
SESSIONS_FOLDER = "sessions"


@dataclass(frozen=True, slots=True)
class SessionRecord:
    """Record of one session for the fleet.

    Parameters
    ----------
    name, sensor : str
    input_digest : str
        Of its inputs; empty where these could not be read.
    exit_code : int
        As that of ``pipeline run``.
    reason : str
        Why it failed or was refused.
    rows : tuple of dict
        A row of the table for each triad.
    seconds : dict
        Processor time of each stage.
    """

    name: str
    sensor: str
    input_digest: str
    exit_code: int
    reason: str = ""
    rows: tuple[Mapping[str, Any], ...] = ()
    seconds: Mapping[str, float] = field(default_factory=dict)


def folder_of(output: Path, name: str) -> Path:
    """Folder of the results of the session called ``name``."""
    return output / SESSIONS_FOLDER / name


def write_record(output: Path, record: SessionRecord) -> None:
    """Keep a record."""
    text = json.dumps(asdict(record), indent=1, ensure_ascii=False, allow_nan=False) + "\n"
    write_whole(folder_of(output, record.name) / RECORD_NAME, text)


def kept_record(output: Path, name: str) -> SessionRecord | None:
    """The record of the session called ``name``; None where there is none, or a damaged one."""
    try:
        text = (folder_of(output, name) / RECORD_NAME).read_text(encoding="utf-8")
        entries = json.loads(text)
        return SessionRecord(**{**entries, "rows": tuple(entries["rows"])})
    except (OSError, ValueError, TypeError, KeyError, RecursionError):
        return None


def evidence_path(output: Path, name: str, triad: str) -> Path:
    """Path of the evidence of one triad of a session."""
    return folder_of(output, name) / f"evidence_{triad}.npz"


def write_evidence(path: Path, evidence: Evidence) -> None:
    """Keep the evidence of one triad."""
    buffer = io.BytesIO()
    upper = np.triu_indices(len(evidence.score))
    np.savez(
        buffer, score=evidence.score, information=evidence.information[upper],
        scalars=[evidence.chi2, evidence.dof, evidence.noise_dof],
        trials=json.dumps([asdict(trial) for trial in evidence.trials]),
    )
    write_whole(path, buffer.getvalue())


def kept_evidence(path: Path) -> Evidence | None:
    """The evidence in ``path``; None where there is none, or a damaged one."""
    try:
        with np.load(path, allow_pickle=False) as stored:
            score, packed = stored["score"], stored["information"]
            chi2, dof, noise_dof = map(np.asarray, stored["scalars"])
            trials = _trials(str(stored["trials"]))
    except (OSError, ValueError, TypeError, KeyError, EOFError, zipfile.BadZipFile):
        return None
    information = np.zeros((len(score), len(score)))
    upper = np.triu_indices(len(score))
    information[upper] = packed
    information.T[upper] = packed
    return Evidence(trials, score, information, chi2, dof, noise_dof)


def evidence_blocks(
    sessions: Iterable[tuple[str, str]], triad: str, output: Path
) -> Iterator[LotEvidence]:
    """The stored evidence of sessions, in blocks that fit into memory.

    ``sessions`` are pairs of a session's name and its sensor's.
    """
    waiting = iter(sessions)
    while block := list(islice(waiting, AT_ONCE)):
        parts = ((sensor, kept_evidence(evidence_path(output, name, triad)))
                 for name, sensor in block)
        lot = LotEvidence.of((sensor, one) for sensor, one in parts if one is not None)
        if lot is not None:
            yield lot


@cache
def _trials(text: str) -> tuple[Trial, ...]:
    """The candidates of a session; nearly all sessions of a lot share one list."""
    return tuple(Trial(**{**trial, "parameters": tuple(trial["parameters"])})
                 for trial in json.loads(text))
