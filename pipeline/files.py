"""Results are written whole or not at all."""

import os
import tempfile
from pathlib import Path

from pipeline.errors import UnwritableOutput


def write_whole(path: Path, content: str | bytes) -> None:
    """Write ``content`` to ``path`` so that a reader sees the old file or the new one, never half.

    The bytes go to a temporary file in the same folder, are forced to the disk and take the
    name of ``path`` in one step; a failure or an interrupt leaves what was there before.

    Parameters
    ----------
    path : Path
        The file to write; its folder is made where it is missing.
    content : str or bytes
        Text is written as UTF-8 with the line ends it has.

    Raises
    ------
    UnwritableOutput
        The folder or the file cannot be written, or the disk is full.
    """
    data = content.encode() if isinstance(content, str) else content
    temporary: str | None = None
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        handle, temporary = tempfile.mkstemp(dir=path.parent, prefix=f".{path.name}.")
        with os.fdopen(handle, "wb") as file:
            file.write(data)
            file.flush()
            os.fsync(file.fileno())
        os.chmod(temporary, _mode_of(path))
        os.replace(temporary, path)
        temporary = None
    except OSError as error:
        raise UnwritableOutput(
            f"{path}: cannot be written ({error.strerror}); what was there before is unchanged. "
            f"Free the space, allow writing to the folder, or choose another with --output."
        ) from error
    finally:
        if temporary is not None:
            os.unlink(temporary)


def _mode_of(path: Path) -> int:
    """The permission bits of the file to be replaced, else those any new file would have."""
    if path.exists():
        return path.stat().st_mode & 0o777
    mask = os.umask(0)
    os.umask(mask)
    return 0o666 & ~mask
