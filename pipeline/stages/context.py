"""The run context: folder of the phase tracks, receiver of the progress, permissions."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

CACHE_NAME = "cache"  #: folder of the phase tracks, in that of the results
#: Called with a clip's name, the frames done and the frames stated (None where unknown).
OnProgress = Callable[[str, int, int | None], None]


def ignore_progress(_clip: str, _done: int, _stated: int | None) -> None:
    """Ignore the progress, for runs without an observer."""


@dataclass(frozen=True)
class RunContext:
    """Context that stages share besides their inputs.

    Parameters
    ----------
    cache : Path or None
        Folder for phase tracks; with None every clip is tracked anew and nothing is kept.
    on_progress : callable
        Receives the progress of the clips; it may be called from several threads.
    allow_python : bool
        Whether Python files that the configuration names for user-defined effects may run.
    """

    cache: Path | None = None
    on_progress: OnProgress = ignore_progress
    allow_python: bool = False
