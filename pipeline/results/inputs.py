"""What results were made from: the configuration by name, and a hash of all that it states."""

import hashlib
import json
import os
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

from pipeline.config.load import Config, load_config
from pipeline.config.session import files_in, named_files
from pipeline.errors import ConfigError, PipelineError
from pipeline.results.names import RESULTS_NAME
from pipeline.results.read import Stored
from pipeline.text.names import command

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
    beside = stored.folder.absolute().parent / (stored.contents.config or RESULTS_NAME)
    if beside.is_file():
        yield beside
        with suppress(PipelineError):
            yield from named_files(load_config(beside, files_may_be_missing=True))


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
