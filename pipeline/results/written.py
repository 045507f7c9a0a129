"""Files that commands wrote, so that no other file is ever replaced.

A list beside results.json, or in the folder of a fleet, holds the hash of each. A file that is not
listed, or was edited since, belongs to the user.
"""

import hashlib
import json
import os
from collections.abc import Iterable, Sequence
from pathlib import Path

from pipeline.errors import UnwritableOutput
from pipeline.files import encoded_text, require_no_link, write_whole

LIST_NAME = ".written.json"


def write_output(
    folder: Path,
    path: Path,
    content: str | bytes,
    *,
    force: bool = False,
    inputs: Sequence[Path] = (),
) -> None:
    """Write ``path`` and note it in ``folder``, where the results stand.

    Parameters
    ----------
    folder : Path
        Folder of results.json.
    path : Path
        The file to write.
    content : str or bytes
    force : bool
        Replace a file that no command wrote.
    inputs : sequence of Path
        Files that the command has read: never replaced, not even with ``force``.

    Raises
    ------
    UnwritableOutput
        ``path`` is an input or a file of the user's, or cannot be written.
    """
    data = encoded_text(content)
    if path.exists() and any(one.exists() and path.samefile(one) for one in inputs):
        raise UnwritableOutput(
            f"{path}: is what this command reads, or a file of the session, and would be "
            f"replaced. Choose another name with --output."
        )
    require_no_link(path)
    if not force and not _is_written(folder, path, _hash(data)):
        raise UnwritableOutput(
            f"{path}: exists and was not written from these results, or was edited since. "
            f"Move it away, choose another name with --output, or add --force to replace it."
        )
    write_whole(path, data)
    try:
        listed = _read_list(folder) | {os.path.relpath(path, folder): _hash(data)}
        write_whole(folder / LIST_NAME, json.dumps(listed, indent=1, ensure_ascii=False) + "\n")
    except (UnwritableOutput, MemoryError):  # the file exists: the next command asks for --force
        return


def require_written(folder: Path, names: Iterable[str]) -> None:
    """Refuse a folder in which one of ``names`` is a file that no command wrote there.

    Raises
    ------
    UnwritableOutput
        Naming the file.
    """
    for name in names:
        require_no_link(folder / name)
        if not _is_written(folder, folder / name):
            raise UnwritableOutput(
                f"{folder / name}: exists and was not written by this command, or was edited "
                f"since. Move it away, or choose another folder with --output."
            )


def _is_written(folder: Path, path: Path, same: str | None = None) -> bool:
    """Whether ``path`` is free, as a command left it, or has the hash ``same``."""
    if not path.is_file():
        return not path.exists()
    return _hash(path.read_bytes()) in (_read_list(folder).get(os.path.relpath(path, folder)), same)


def _read_list(folder: Path) -> dict[str, str]:
    try:
        listed = json.loads((folder / LIST_NAME).read_text(encoding="utf-8"))
    except (OSError, ValueError, RecursionError):
        return {}
    return listed if isinstance(listed, dict) else {}


def _hash(data: bytes) -> str:
    return hashlib.sha256(data).hexdigest()
