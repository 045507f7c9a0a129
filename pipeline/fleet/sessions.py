"""The sessions of a fleet: those that match a pattern, and the files that are kept of each.

These are its rows, their cost, and its evidence. A record is written last, with the digest of the
session's inputs. A later run with the same digest keeps it.
"""

import io
import json
import os
import re
import zipfile
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, field
from functools import cache
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np

from calib.diagnosis.population.evidence import Evidence, Trial
from calib.diagnosis.population.lot import AT_ONCE, LotEvidence
from pipeline.config.file_patterns import is_pattern, natural_key
from pipeline.errors import ConfigError
from pipeline.files import write_whole

SENSOR = "{sensor}"
USUAL_STEM = "config"  #: name of a configuration that is called by its folder


@dataclass(frozen=True)
class FleetSession:
    """One session of a fleet.

    Parameters
    ----------
    config : Path
    name : str
        Its path below the fixed part of the pattern; also that of its folder of results.
    sensor : str
        Which sensor it is of; the session's name where the pattern does not say.
    """

    config: Path
    name: str
    sensor: str


def find_sessions(pattern: str) -> tuple[FleetSession, ...]:
    """The sessions whose configurations match ``pattern``, naturally sorted.

    Parameters
    ----------
    pattern : str
        As a shell has it (``*``, ``?``, ``**``); ``{sensor}`` stands for any text within a name,
        and what it stands for names the sensor: ``'lot/{sensor}/*/config.yaml'``.

    Raises
    ------
    ConfigError
        No file matches, or two sessions would have the same name.
    """
    parts = Path(pattern).parts
    fixed = 0
    while fixed < len(parts) - 1 and not (is_pattern(parts[fixed]) or SENSOR in parts[fixed]):
        fixed += 1
    root = Path(*parts[:fixed])
    rest = str(Path(*parts[fixed:]))
    try:
        paths = [one for one in root.glob(rest.replace(SENSOR, "*")) if one.is_file()]
    except ValueError as error:
        raise ConfigError(f"'{pattern}': is no pattern of files ({error}).") from error
    if not paths:
        raise ConfigError(
            f"no file matches '{pattern}'. Expected a pattern of configurations, in quotes, as in "
            f"'sessions/*/config.yaml'; {root} {'exists' if root.is_dir() else 'does not exist'}."
        )
    return _sessions(paths, root, _expression(rest))


def named_sessions(configs: Sequence[str]) -> tuple[FleetSession, ...]:
    """The sessions of these configurations, listed by a shell for a pattern without quotes.

    Raises
    ------
    ConfigError
        One is no file, or two sessions would have the same name.
    """
    for config in configs:
        if not Path(config).is_file():
            raise ConfigError(f"{config}: there is no such file. Expected a pattern of "
                              f"configurations in quotes, as in 'sessions/*/config.yaml', or "
                              f"existing configurations.")
    root = Path(os.path.commonpath([Path(config).absolute().parent for config in configs]))
    return _sessions([Path(config).absolute() for config in configs], root, "")


def _session(path: Path, below: str, expression: str) -> FleetSession:
    name = below.removesuffix(Path(below).suffix)
    folder, _, stem = name.rpartition("/")
    if stem == USUAL_STEM and folder:
        name = folder
    match = re.fullmatch(expression, below)
    sensor = match.groupdict().get("sensor") if match else None
    return FleetSession(path, name, sensor or name)


def _sessions(paths: Sequence[Path], root: Path, expression: str) -> tuple[FleetSession, ...]:
    """The sessions of files below ``root``, in the order of their names, each with one of its own.
    """
    sessions = [_session(path.absolute(), path.relative_to(root).as_posix(), expression)
                for path in paths]
    sessions.sort(key=lambda session: natural_key(session.name))
    names: dict[str, FleetSession] = {}
    for session in sessions:
        if session.name in names:
            raise ConfigError(
                f"{session.config} and {names[session.name].config}: both would be called "
                f"'{session.name}'. Narrow the pattern so that one of them is left."
            )
        names[session.name] = session
    return tuple(sessions)


def _expression(pattern: str) -> str:
    """The regular expression of a shell's pattern, ``{sensor}`` as a group."""
    signs = {"**/": "(?:.*/)?", "*": "[^/]*", "?": "[^/]", SENSOR: "(?P<sensor>[^/]+)"}
    pieces = re.split(r"(\*\*/|\*|\?|\{sensor\}|\[[^\]]+\])", pattern)
    expression, groups = "", 0
    for piece in pieces:
        if piece == SENSOR:
            groups += 1
            expression += signs[SENSOR] if groups == 1 else "(?P=sensor)"
        elif piece in signs:
            expression += signs[piece]
        elif piece.startswith("["):
            expression += piece.replace("[!", "[^")
        else:
            expression += re.escape(piece)
    return expression


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
