"""What a guided recording shows: a live panel on a terminal, plain lines everywhere else."""

import sys
from typing import TYPE_CHECKING

import click

from pipeline.console.terminal import visible

if TYPE_CHECKING:
    from rich.live import Live
    from rich.table import Table

    from pipeline.record.session import RecordingView

MARK = {"taking": "green", "taken": "green", "moving": "yellow", "unsteady": "yellow",
        "repeats": "cyan", "between": "cyan", "wrong": "red"}
BAR = 30  #: characters of the bar that fills while a pose is taken


def watcher(quiet: bool) -> "LivePanel | PlainLines":
    """The display that suits standard error; no panel where it is to be ``quiet``."""
    return LivePanel() if sys.stderr.isatty() and not quiet else PlainLines()


class PlainLines:
    """A line for each change; see :class:`pipeline.record.session.RecordingDisplay`."""

    def __init__(self) -> None:
        self._last = ""

    def say(self, text: str) -> None:
        """A line that stays."""
        click.echo(text, err=True)

    def show(self, view: "RecordingView") -> None:
        """A line where what the sensor does has changed."""
        phase = view.status.phase
        if phase != self._last and phase != "taken":
            where = f" ({view.status.direction})" if view.status.direction else ""
            click.echo(f"{phase}{where}: {view.status.message}", err=True)
        self._last = phase

    def recorded(self, text: str) -> None:
        """A pose is recorded."""
        click.echo(text, err=True)

    def close(self) -> None:
        """Nothing to take away."""


class LivePanel:
    """Readings, stillness, the directions and the next step, in place on the terminal."""

    def __init__(self) -> None:
        self._live: Live | None = None

    def say(self, text: str) -> None:
        """A line above the panel."""
        if self._live is None:
            click.echo(text, err=True)
        else:
            self._live.console.print(visible(text), markup=False, highlight=False)

    def show(self, view: "RecordingView") -> None:
        """Draw the panel."""
        if self._live is None:
            from rich.console import Console
            from rich.live import Live

            console = Console(file=getattr(sys.stderr, "raw", sys.stderr))
            self._live = Live(console=console, refresh_per_second=8, transient=True)
            self._live.start()
        self._live.update(panel(view))

    def recorded(self, text: str) -> None:
        """A line above the panel, and the terminal's bell."""
        if self._live is not None:
            self._live.console.bell()
        self.say(text)

    def close(self) -> None:
        """Take the panel away."""
        if self._live is not None:
            self._live.stop()
            self._live = None


def panel(view: "RecordingView") -> "Table":
    """The panel of one moment."""
    from rich.table import Table
    from rich.text import Text

    from calib.poses.attitudes import direction_name

    status, reading = view.status, view.status.reading
    table = Table.grid(padding=(0, 2))
    colour = MARK[status.phase]
    bar = "█" * round(status.progress * BAR)
    table.add_row("now", Text(f"{status.phase}  {bar}", style=colour))
    table.add_row("", Text(visible(status.message), style=colour))
    table.add_row("up", status.direction or "?")
    table.add_row("acc", "  ".join(f"{x:8.3f}" for x in reading[:3]) + "  m/s², by data sheet")
    table.add_row("gyr", "  ".join(f"{x:8.4f}" for x in reading[3:]) + "  rad/s, by data sheet")
    names = Text()
    for i, direction in enumerate(view.wanted):
        recorded = i in view.covered
        names.append(f"{'✓' if recorded else '·'} {direction_name(direction)}   ",
                     style="green" if recorded else "dim")
    table.add_row(f"{len(view.covered)}/{len(view.wanted)}", names)
    table.add_row("line", f"{view.rate_hz:.1f} samples/s, {view.bad} damaged")
    return table
