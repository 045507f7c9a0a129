"""Writing of files, whole or not at all, and of several that belong together, all or none.

A file is staged beside its target under ``.NAME.XXXX.part``, forced to the disk and renamed, which
a file system does in one step. Files that belong together are staged first; a journal then lists
them, and from there on the change only goes forward: the next command that finds a journal finishes
it.
"""

import errno
import json
import os
import stat
import tempfile
from collections.abc import Collection, Mapping
from contextlib import ExitStack
from pathlib import Path

from pipeline.errors import UnwritableOutput

PART = ".part"  #: end of the name of a staged file
LONGEST_NAME = 255  #: bytes of a file's name, in every file system in common use


def may_never_end(path: Path) -> bool:
    """Whether reading ``path`` may wait for ever, or not end: a pipe, a socket, a device.

    A kernel file of zero length (``/proc/kmsg``) counts as a device.

    Raises
    ------
    OSError
        It is missing, or cannot be looked at.
    """
    status = path.stat()
    if stat.S_ISDIR(status.st_mode):
        return False
    of_kernel = status.st_size == 0 and path.resolve().is_relative_to("/proc")
    return of_kernel or not stat.S_ISREG(status.st_mode)


def encoded_text(content: str | bytes) -> bytes:
    """Text in UTF-8; undecodable bytes of a file's name are escaped as in Python."""
    return content.encode(errors="backslashreplace") if isinstance(content, str) else content


def write_whole(path: Path, content: str | bytes) -> None:
    """Write ``content`` to ``path`` so that a reader sees the old file or the new one, never half.

    Parameters
    ----------
    path : Path
        The file to write; its folder is made where it is missing. A symbolic link is replaced,
        and the file it leads to stays as it is.
    content : str or bytes
        Text is written as UTF-8 with the line ends it has.

    Raises
    ------
    UnwritableOutput
        The folder or the file cannot be written, or the disk is full.
    """
    staged = _stage(path, content)
    try:
        _rename(staged, path)
    finally:
        staged.unlink(missing_ok=True)


def require_no_link(path: Path) -> None:
    """Refuse to write to a symbolic link: its target belongs to somebody else.

    Raises
    ------
    UnwritableOutput
        Naming the link and where it leads.
    """
    if path.is_symlink():
        raise UnwritableOutput(
            f"{path}: is a link to {os.readlink(path)}, and the file there would be replaced. "
            f"Remove the link, or choose another name with --output."
        )


def require_writable(folder: Path) -> None:
    """Refuse a folder that is not there and cannot be made, or in which nothing can be written.

    Raises
    ------
    UnwritableOutput
    """
    place = next(each for each in (folder, *folder.parents) if each.exists())
    if not place.is_dir():
        raise _unwritable(folder, NotADirectoryError())
    if not os.access(place, os.W_OK):
        raise _unwritable(folder, PermissionError(errno.EACCES, os.strerror(errno.EACCES)))


def write_together(contents: Mapping[Path, str | bytes], journal: Path) -> None:
    """Write several files so that all of them are new, or all of them as they were.

    Parameters
    ----------
    contents : mapping of path to text or bytes
        A symbolic link stays a link, the file it leads to is written: a configuration may be one.
    journal : Path
        Where the change is noted while it is under way; see :func:`finish_interrupted`.

    Raises
    ------
    UnwritableOutput
        As :func:`write_whole`.
    """
    staged: dict[Path, Path] = {}
    with ExitStack() as undo:
        for path, content in contents.items():
            target = _target(path)
            staged[target] = _stage(target, content)
            undo.callback(staged[target].unlink, missing_ok=True)
        undo.callback(journal.unlink, missing_ok=True)  # removed first: parts alone mean nothing
        names = {_relative(target, journal): part.name for target, part in staged.items()}
        write_whole(journal, json.dumps(names, ensure_ascii=False))
        undo.pop_all()
    try:
        finish_interrupted(journal, contents)
    except KeyboardInterrupt:
        finish_interrupted(journal, contents)
        raise
    except UnwritableOutput as error:
        raise UnwritableOutput(
            f"{error} The change is noted in {journal}: the next command there finishes it."
        ) from error


def finish_interrupted(journal: Path, expected: Collection[Path]) -> bool:
    """Finish a change that a kill or a full disk interrupted; returns whether there was one.

    Only files in ``expected`` are written, from parts beside them: a journal that somebody else
    put there moves nothing.
    """
    try:
        noted = json.loads(journal.read_text(encoding="utf-8"))
    except (FileNotFoundError, NotADirectoryError):
        return False
    except (ValueError, RecursionError):
        noted = {}
    except OSError as error:
        raise _unwritable(journal, error) from error
    if not isinstance(noted, dict):
        noted = {}
    targets = {_relative(_target(path), journal): _target(path) for path in expected}
    for name, part_name in noted.items():
        target = targets.get(name)
        if target is None or not _is_part_of(part_name, target):
            continue
        part = target.parent / part_name
        if part.exists():
            _rename(part, target)
    journal.unlink(missing_ok=True)
    return True


def remove_parts(paths: Collection[Path]) -> None:
    """Remove what killed commands left beside ``paths``; call it only where no other one runs."""
    for path in paths:
        target = _target(path)
        for part in target.parent.glob(f".*{PART}"):
            if _is_part_of(part.name, target):
                part.unlink(missing_ok=True)


def _target(path: Path) -> Path:
    """The target of ``path`` if it is a symbolic link, else ``path``."""
    return Path(os.path.realpath(path))


def _is_part_of(name: object, target: Path) -> bool:
    return (isinstance(name, str) and os.sep not in name
            and name.startswith(f".{target.name}.") and name.endswith(PART))


def _relative(path: Path, journal: Path) -> str:
    return os.path.relpath(path, _target(journal).parent)


def _stage(target: Path, content: str | bytes) -> Path:
    """``content`` on the disk beside ``target``, with its permissions, not yet under its name."""
    data = encoded_text(content)
    with ExitStack() as undo:
        try:
            target.parent.mkdir(parents=True, exist_ok=True)
            handle, name = tempfile.mkstemp(
                dir=target.parent, prefix=f".{target.name}.", suffix=PART
            )
            undo.callback(Path(name).unlink, missing_ok=True)
            with os.fdopen(handle, "wb") as file:
                file.write(data)
                file.flush()
                os.fsync(file.fileno())
            os.chmod(name, _mode_of(target))
        except OSError as error:
            raise _unwritable(target, error) from error
        undo.pop_all()
    return Path(name)


def _rename(staged: Path, target: Path) -> None:
    try:
        os.replace(staged, target)
    except OSError as error:
        raise _unwritable(target, error) from error


def _unwritable(path: Path, error: OSError) -> UnwritableOutput:
    if isinstance(error, FileExistsError | NotADirectoryError):
        return UnwritableOutput(
            f"{path}: cannot be written: a folder on the way there is a file. Nothing was changed; "
            f"move that file away, or write to another folder."
        )
    return UnwritableOutput(
        f"{path}: cannot be written ({error.strerror}); what was there before is unchanged. "
        f"Free the space, allow writing to the folder, or write to another one."
    )


def _mode_of(path: Path) -> int:
    """The permission bits of the file to be replaced, else those any new file would have."""
    if path.exists():
        return path.stat().st_mode & 0o777
    mask = os.umask(0)
    os.umask(mask)
    return 0o666 & ~mask
