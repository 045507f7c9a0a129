"""The folder of a session's results while a command works on it.

One command at a time: another one waits. Work that a killed command left half done is finished or
removed first, and the user's changes in the meantime are never overwritten.
"""

import hashlib
import json
import os
import tempfile
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path

from filelock import FileLock, Timeout

from pipeline.config.load import Config, load_config
from pipeline.errors import ConfigError, UnwritableOutput
from pipeline.files import (
    finish_interrupted,
    remove_parts,
    require_no_link,
    require_writable,
    write_together,
)
from pipeline.results.history import HISTORY_NAME
from pipeline.results.inputs import require_own_results
from pipeline.results.names import REPORT_MARK, REPORT_NAME, RESULTS_NAME

BYTE_ORDER_MARK = "\ufeff"  #: some editors begin a file with it; it is not text
JOURNAL_NAME = ".unfinished.json"
OUTPUTS = (RESULTS_NAME, HISTORY_NAME, REPORT_NAME)


def _nobody(_folder: Path) -> None:
    """Ignore the wait, for callers without an observer."""


@contextmanager
def working_on(
    path: Path, output: Path | None = None, on_wait: Callable[[Path], None] = _nobody, *,
    replaces: bool | None = False,
) -> Iterator[tuple[Config, Path]]:
    """The configuration ``path`` and the folder of its results, for one command alone.

    Parameters
    ----------
    path : Path
        The configuration.
    output : Path, optional
        Folder of the results, instead of the configuration's.
    on_wait : callable
        Told the folder when another command is working on it.
    replaces : bool or None
        Whether files in the folder that are not of this session may be replaced; None where the
        command writes none.

    Raises
    ------
    ConfigError
        As :func:`pipeline.config.load.load_config` and :func:`require_place`.
    UnwritableOutput
        As :func:`require_place`.
    """
    config = load_config(path)
    folder = output or config.output_folder
    lock = _lock(folder)
    try:
        lock.acquire(timeout=0)
    except Timeout:
        on_wait(folder)
        lock.acquire()
    try:
        files = [config.source.path, *(folder / name for name in OUTPUTS)]
        finish_interrupted(folder / JOURNAL_NAME, files)
        remove_parts([*files, folder / JOURNAL_NAME])
        config = load_config(path)  # again: the command before may have changed it
        if replaces is not None:
            require_place(config, folder, replaces)
        yield config, folder
    finally:
        lock.release()


def _lock(folder: Path) -> FileLock:
    """The lock of ``folder``, outside it: a command that is refused leaves no folder behind.

    The system releases it when its process ends, in whatever way.
    """
    locks = Path(tempfile.gettempdir()) / f"pipeline-locks-{getattr(os, 'getuid', str)()}"
    name = hashlib.sha256(os.fsencode(os.path.realpath(folder))).hexdigest()
    try:
        locks.mkdir(mode=0o700, exist_ok=True)
        (locks / name).touch()
    except OSError as error:
        raise UnwritableOutput(
            f"{locks}: cannot be written ({error.strerror}). Free the space, or name another "
            f"folder for temporary files by the variable TMPDIR."
        ) from error
    return FileLock(locks / name)


def require_place(config: Config, folder: Path, replaces: bool = False) -> None:
    """Refuse a folder that cannot be written or holds other files, before work and not after it.

    Raises
    ------
    ConfigError
        Unless it ``replaces`` them, the folder has the results of another configuration.
    UnwritableOutput
        The folder cannot be written, or, unless it ``replaces`` them, has files that `pipeline run`
        did not write.
    """
    require_writable(folder)
    for name in OUTPUTS:
        require_no_link(folder / name)
    if replaces:
        return
    for name, is_ours in ((RESULTS_NAME, _is_results), (REPORT_NAME, _is_report)):
        path = folder / name
        if path.exists() and not is_ours(path):
            raise UnwritableOutput(
                f"{path}: was not written by `pipeline run` and would be replaced. Move it away, "
                f"choose another folder with --output, or add --force to replace it."
            )
    require_own_results(folder, config)


def _is_results(path: Path) -> bool:
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError, RecursionError):
        return False
    return isinstance(content, dict) and "format" in content


def _is_report(path: Path) -> bool:
    try:
        return REPORT_MARK in path.read_text(encoding="utf-8", errors="replace")[:4096]
    except OSError:
        return False


def write_session(
    folder: Path, outputs: Mapping[str, str], config: Config | None = None, text: str = ""
) -> None:
    """Write a run's files, and ``text`` into the file of ``config`` where one is given, or none.

    Raises
    ------
    ConfigError
        The configuration was changed by somebody else since it was read; nothing is written.
    UnwritableOutput
        A file cannot be written; all are as they were.
    """
    contents: dict[Path, str | bytes] = {
        folder / name: content for name, content in outputs.items()}
    if config is not None:
        path = config.source.path
        there = path.read_text(encoding="utf-8")
        mark = BYTE_ORDER_MARK if there.startswith(BYTE_ORDER_MARK) else ""
        if there.removeprefix(mark) != config.source.text:
            raise ConfigError(
                f"{path}: was changed by somebody else while this command ran. Nothing is "
                f"written; look at the change and type the command again."
            )
        contents[path] = mark + text
    write_together(contents, folder / JOURNAL_NAME)
