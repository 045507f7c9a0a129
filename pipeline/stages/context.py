"""Where a run keeps what is slow to make, and whom it tells how far it has got."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

#: Called with a clip's name, the pictures done and the pictures stated (None where unknown).
OnProgress = Callable[[str, int, int | None], None]


def say_nothing(_clip: str, _done: int, _stated: int | None) -> None:
    """For runs that nobody watches."""


@dataclass(frozen=True)
class Workplace:
    """What stages share besides their inputs.

    Parameters
    ----------
    cache : Path or None
        Folder for phase tracks; None follows every clip anew and keeps nothing.
    on_progress : callable
        Told about the clips that are being followed; may be called from several threads.
    allow_python : bool
        Whether Python files that the configuration names for its own effects may run.
    """

    cache: Path | None = None
    on_progress: OnProgress = say_nothing
    allow_python: bool = False
