"""Progress of clips and sessions on standard error, where that is a terminal."""

import sys
import threading
from typing import TYPE_CHECKING

from pipeline.console.terminal import visible

if TYPE_CHECKING:
    import rich.progress


class Progress:
    """A bar for each clip that is being tracked, from the first frame until :meth:`close`.

    Clips are tracked in several threads. Nothing is shown, and rich is not imported, if the bars
    should not be ``visible``, standard error is no terminal, or every track is in the cache. The
    sessions of a fleet have one bar; ``unit`` is what a bar counts.
    """

    def __init__(self, visible: bool = True, unit: str = "frames") -> None:
        self._visible, self._unit = visible, unit
        self._bars: rich.progress.Progress | None = None
        self._tasks: dict[str, rich.progress.TaskID] = {}
        self._lock = threading.Lock()

    def __enter__(self) -> "Progress":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def __call__(self, clip: str, done: int, stated: int | None, note: str = "") -> None:
        """Show that ``done`` frames of ``clip`` are done, of the ``stated`` number, and a note."""
        if not (self._visible and sys.stderr.isatty()):
            return
        with self._lock:
            if self._bars is None:
                self._bars = _bars(self._unit)
                self._bars.start()
            if clip not in self._tasks:
                self._tasks[clip] = self._bars.add_task(visible(clip), total=stated)
            self._bars.update(self._tasks[clip], completed=done,
                              description=f"{visible(clip)}{note}")

    def close(self) -> None:
        """Remove the bars before anything else is written to the terminal."""
        if self._bars is not None:
            self._bars.stop()
            self._bars = None


def _bars(unit: str) -> "rich.progress.Progress":
    import rich.progress as part  # 70 ms
    from rich.console import Console

    return part.Progress(
        part.TextColumn("{task.description}", markup=False), part.BarColumn(),
        part.MofNCompleteColumn(), part.TextColumn(unit), part.TimeRemainingColumn(),
        console=Console(file=getattr(sys.stderr, "raw", sys.stderr)), transient=True)
