"""A JSON file of ours read back, whatever became of it since."""

import json
from pathlib import Path
from typing import Any

from pipeline.errors import UnreadableInput

LARGEST_BYTES = 100_000_000  #: a session of a thousand poses has 2 MB


def read_json(path: Path, name: str, command: str) -> Any:
    """The contents of ``path``; ``name`` is how ``command`` calls the files that it writes.

    Raises
    ------
    UnreadableInput
        It is missing, larger than any that we write, or not JSON.
    """
    try:
        size = path.stat().st_size
        text = path.read_text(encoding="utf-8") if size <= LARGEST_BYTES else None
    except OSError as error:
        raise UnreadableInput(
            f"{path}: cannot be read ({error.strerror}). Name the {name} that `{command}` has "
            f"written, or its folder."
        ) from error
    except ValueError as error:  # not UTF-8
        raise _not_json(path, str(error), name, command) from error
    if text is None:
        problem = f"{size} bytes, at most {LARGEST_BYTES} are expected"
        raise _not_json(path, problem, name, command)
    try:
        return json.loads(text)
    except (ValueError, RecursionError) as error:
        raise _not_json(path, str(error), name, command) from error


def _not_json(path: Path, problem: str, name: str, command: str) -> UnreadableInput:
    return UnreadableInput(
        f"{path}: is not JSON ({problem}). Name the {name} that `{command}` has written, or write "
        f"it anew with `{command}`."
    )
