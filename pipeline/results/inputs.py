"""What results were made from: the configuration by name, and a hash of all that it states."""

import hashlib
import json
import os
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

from pipeline.config.file_patterns import takes
from pipeline.config.load import Config, load_config
from pipeline.config.session import files_in, named_files
from pipeline.errors import ConfigError, PipelineError, UnwritableOutput
from pipeline.results.names import RESULTS_NAME
from pipeline.results.read import Stored
from pipeline.text.names import command, word

NO_INPUT = ("title", "output", "record")  #: sections that no number depends on


def config_name(config: Config) -> str:
    """The name of the configuration's file; undecodable bytes are escaped."""
    return os.fsencode(config.source.path.name).decode(errors="backslashreplace")


def inputs_sha256(config: Config) -> str:
    """The SHA-256 of all that a configuration states, and of the logs that it names.

    Comments do not count, and a clip counts by its size: hashing one takes as long as reading it.
    """
    stated = {key: value for key, value in config.source.values.items() if key not in NO_INPUT}
    digest = hashlib.sha256(json.dumps(stated, default=str).encode())
    clips = {*files_in(config.rate)}
    for path in sorted({*named_files(config)}):
        digest.update(path.name.encode(errors="replace"))
        if path in clips:
            digest.update(str(path.stat().st_size).encode())
            continue
        with path.open("rb") as file:
            digest.update(hashlib.file_digest(file, "sha256").digest())
    return digest.hexdigest()


def files_of_session(stored: Stored) -> Iterator[Path]:
    """results.json, the configuration that stands beside its folder, and all files that it names:
    no output replaces them."""
    yield stored.path
    beside = _config_of(stored)
    if beside.is_file():
        yield beside
        with suppress(PipelineError):
            yield from named_files(load_config(beside, files_may_be_missing=True))


def _config_of(stored: Stored) -> Path:
    return stored.folder.absolute().parent / (stored.contents.config or RESULTS_NAME)


def require_no_pose(stored: Stored, path: Path) -> None:
    """Refuse a new file that the configuration beside the results would take for a pose.

    Raises
    ------
    UnwritableOutput
        With a name that would do.
    """
    beside, config = _config_of(stored), None
    with suppress(PipelineError):
        config = load_config(beside, files_may_be_missing=True) if beside.is_file() else None
    if config is None or path.exists():
        return
    patterns = [*_stated_files(config)]
    for pattern in (one for one in patterns if takes(one, path, beside.parent)):
        able = (path.parent / "calibrated" / path.name, path.with_suffix(".txt"))
        free = next((name for name in able if not any(
            takes(one, name, beside.parent) for one in patterns)), able[0])
        raise UnwritableOutput(
            f"{path}: '{pattern}' in {beside.name} would take it for a pose of the session. Choose "
            f"another name, as in --output {word(free)}")


def _stated_files(config: Config) -> Iterator[str]:
    """The names and patterns of poses, as the file of the configuration states them."""
    for keys, _ in config.placed_runs():
        poses = config.source.value((*keys, "poses"))
        for stated in (map(poses.get, ("files", "log", "means")) if isinstance(poses, dict)
                       else [poses]):
            yield from [stated] if isinstance(stated, str) else stated or ()


def require_results_of(stored: Stored, config: Config) -> None:
    """Refuse results of another configuration, or of this one and its logs as they once were.

    Raises
    ------
    ConfigError
        With the command that makes them anew.
    """
    name, path = stored.contents.config, config.source.path
    if stored.contents.inputs_sha256 in (None, inputs_sha256(config)):
        return
    again = f"Type: {command('run', path)}"
    if name != config_name(config):
        raise ConfigError(
            f"{stored.folder}: has the results of {name}, not of {path}. Give each of the two an "
            f"`output` of its own. {again}")
    raise ConfigError(
        f"{path}: it, or a log that it names, was changed after the run whose results are in "
        f"{stored.folder}. {again}; or name that folder for its results as they are.")


def require_own_results(folder: Path, config: Config) -> None:
    """Refuse to replace the results of another configuration beside this one.

    Raises
    ------
    ConfigError
        Naming it.
    """
    try:
        name = json.loads((folder / RESULTS_NAME).read_text(encoding="utf-8")).get("config")
    except (OSError, ValueError, AttributeError, RecursionError):
        return
    other = isinstance(name, str) and name != config_name(config)
    if other and (config.source.path.parent / name).exists():
        raise ConfigError(
            f"{folder}: has the results of {name}, which would be replaced. Give each of the two "
            f"configurations an `output` of its own, or replace them: "
            f"{command('run', config.source.path, '--force')}")
