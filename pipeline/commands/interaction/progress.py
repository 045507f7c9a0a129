"""Progress of clips and sessions on standard error, where that is a terminal."""

import sys
import threading
from typing import TYPE_CHECKING

from pipeline.console.terminal import visible

if TYPE_CHECKING:
    from rich.progress import Progress, TaskID


class ClipProgress:
    """A bar for each clip that is being tracked, from the first frame until :meth:`close`.

    Clips are tracked in several threads. Nothing is shown, and rich is not imported, if the bars
    should not be ``visible``, standard error is no terminal, or every track is in the cache.
    """

    def __init__(self, visible: bool = True) -> None:
        self._visible = visible
        self._bars: Progress | None = None
        self._tasks: dict[str, TaskID] = {}
        self._lock = threading.Lock()

    def __enter__(self) -> "ClipProgress":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def __call__(self, clip: str, done: int, stated: int | None) -> None:
        """Show that ``done`` frames of ``clip`` are done, of the ``stated`` number."""
        if not (self._visible and sys.stderr.isatty()):
            return
        with self._lock:
            if self._bars is None:
                self._bars = _bars("frames")
                self._bars.start()
            if clip not in self._tasks:
                self._tasks[clip] = self._bars.add_task(visible(clip), total=stated)
            self._bars.update(self._tasks[clip], completed=done)

    def close(self) -> None:
        """Remove the bars before anything else is written to the terminal."""
        if self._bars is not None:
            self._bars.stop()
            self._bars = None


class SessionProgress:
    """A bar for the sessions of a fleet, where standard error is a terminal."""

    def __init__(self, total: int, shown: bool = True) -> None:
        self._total, self._failed, self._shown = total, 0, shown
        self._bars: Progress | None = None
        self._task: TaskID | None = None

    def __enter__(self) -> "SessionProgress":
        if self._shown and sys.stderr.isatty():
            self._bars = _bars("sessions")
            self._bars.start()
            self._task = self._bars.add_task("fleet", total=self._total)
        return self

    def __exit__(self, *_: object) -> None:
        if self._bars is not None:
            self._bars.stop()

    def advance(self, failed: bool) -> None:
        """Count one more session as done."""
        self._failed += failed
        if self._bars is not None and self._task is not None:
            text = f"fleet, {self._failed} not calibrated" if self._failed else "fleet"
            self._bars.update(self._task, advance=1, description=text)


def _bars(unit: str) -> "Progress":
    from rich.console import Console  # 70 ms
    from rich.progress import (
        BarColumn,
        MofNCompleteColumn,
        Progress,
        TextColumn,
        TimeRemainingColumn,
    )

    return Progress(
        TextColumn("{task.description}", markup=False),
        BarColumn(),
        MofNCompleteColumn(),
        TextColumn(unit),
        TimeRemainingColumn(),
        console=Console(file=getattr(sys.stderr, "raw", sys.stderr)),
        transient=True,
    )
