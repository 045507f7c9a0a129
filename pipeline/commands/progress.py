"""Progress of the clips on standard error, where that is a terminal."""

import sys
from collections.abc import Iterator
from contextlib import contextmanager

from pipeline.workplace import OnProgress, say_nothing


@contextmanager
def clip_progress() -> Iterator[OnProgress]:
    """Bars for the clips that are being followed; nothing where nobody watches."""
    if not sys.stderr.isatty():
        yield say_nothing
        return
    from rich.console import Console  # 70 ms that scripts need not wait for
    from rich.progress import (
        BarColumn,
        MofNCompleteColumn,
        Progress,
        TaskID,
        TextColumn,
        TimeRemainingColumn,
    )

    columns = (
        TextColumn("{task.description}"),
        BarColumn(),
        MofNCompleteColumn(),
        TextColumn("pictures"),
        TimeRemainingColumn(),
    )
    with Progress(*columns, console=Console(stderr=True), transient=True) as bars:
        tasks: dict[str, TaskID] = {}

        def on_progress(clip: str, done: int, stated: int | None) -> None:
            if clip not in tasks:
                tasks[clip] = bars.add_task(clip, total=stated)
            bars.update(tasks[clip], completed=done)

        yield on_progress
