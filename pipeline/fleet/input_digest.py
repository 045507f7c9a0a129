"""What the results of a session are of: a digest of its configuration and of all its inputs."""

import hashlib
import os
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from pipeline.config.load import Config
from pipeline.errors import UnreadableInput
from pipeline.text.names import program_version

RECORD_FORMAT = 2
"""Raise it whenever a record holds other things than before."""


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
    for path in sorted({*_paths(config), *_python_files(config, folder)}):
        digest.update(os.fsencode(os.path.relpath(path, folder)))
        digest.update(_digest(path))
    return digest.hexdigest()


def _paths(value: Any) -> Iterator[Path]:
    """Every path in a section of the configuration."""
    if isinstance(value, Path):
        yield from _files(value)
    elif isinstance(value, dict):
        for one in value.values():
            yield from _paths(one)
    elif isinstance(value, list | tuple):
        for one in value:
            yield from _paths(one)
    elif hasattr(type(value), "model_fields"):
        for name in type(value).model_fields:
            yield from _paths(getattr(value, name))


def _files(path: Path) -> Iterator[Path]:
    """The files of a path: itself, all in a folder, or the archive that it is a name in."""
    if path.is_dir():
        yield from (one for one in path.rglob("*") if one.is_file())
        return
    yield next((one for one in (path, *path.parents) if one.is_file()), path)


def _python_files(config: Config, folder: Path) -> Iterator[Path]:
    for effect in config.effects.values():
        if effect.python is not None:
            yield folder / effect.python.partition(":")[0]


def _digest(path: Path) -> bytes:
    try:
        with path.open("rb") as file:
            return hashlib.file_digest(file, "sha256").digest()
    except OSError as error:
        raise UnreadableInput(f"{path}: cannot be read ({error.strerror}). Check the name, and "
                              "that you may read the file.") from error
