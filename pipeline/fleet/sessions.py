"""The sessions that match a pattern, their names, and their sensors."""

import os
import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from pipeline.config.file_patterns import is_pattern, natural_key
from pipeline.errors import ConfigError

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
    while fixed < len(parts) - 1 and not _is_open(parts[fixed]):
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
    expression = re.compile(_expression(rest))
    sessions = [_session(path.absolute(), path.relative_to(root).as_posix(), expression)
                for path in paths]
    return _with_own_names(sorted(sessions, key=lambda session: natural_key(session.name)))


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
    expression = re.compile("")
    sessions = [_session(path, path.relative_to(root).as_posix(), expression)
                for path in (Path(config).absolute() for config in configs)]
    return _with_own_names(sorted(sessions, key=lambda session: natural_key(session.name)))


def _is_open(part: str) -> bool:
    return is_pattern(part) or SENSOR in part


def _session(path: Path, below: str, expression: re.Pattern[str]) -> FleetSession:
    name = below.removesuffix(Path(below).suffix)
    folder, _, stem = name.rpartition("/")
    if stem == USUAL_STEM and folder:
        name = folder
    match = expression.fullmatch(below)
    sensor = match.groupdict().get("sensor") if match else None
    return FleetSession(path, name, sensor or name)


def _with_own_names(sessions: list[FleetSession]) -> tuple[FleetSession, ...]:
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
