"""Display of a guided recording: a live panel on a terminal, plain lines everywhere else."""

import sys
from collections import deque
from typing import TYPE_CHECKING

import click
import numpy as np

from calib.numbers import RPM
from calib.poses.imu_log import FloatArray
from pipeline.console.terminal import visible

if TYPE_CHECKING:
    from rich.live import Live
    from rich.table import Table

    from pipeline.plan.so_far import Outlook
    from pipeline.record.session import RecordingView

MARK = {"taking": "green", "taken": "green", "moving": "yellow", "unsteady": "yellow",
        "repeats": "cyan", "between": "cyan", "wrong": "red"}
TRACE, BARS = 18, "▁▂▃▄▅▆▇█"  #: readings of a trace, and its signs
BAR = 30  #: characters of the bar that fills while a pose is taken
NAMES = 3  #: poses in a row; layout


def watcher(quiet: bool, outlook: "Outlook") -> "LivePanel | PlainLines":
    """The display that suits standard error; no panel where it is to be ``quiet``."""
    return LivePanel(outlook) if sys.stderr.isatty() and not quiet else PlainLines(outlook)


class PlainLines:
    """A line for each change; see :class:`pipeline.record.session.RecordingDisplay`."""

    def __init__(self, outlook: "Outlook") -> None:
        self._last, self._outlook = "", outlook

    def say(self, text: str) -> None:
        """Show a line that stays."""
        click.echo(text, err=True)

    def show(self, view: "RecordingView") -> None:
        """Print a line if the state of the sensor has changed."""
        phase = view.status.phase
        if phase != self._last and phase != "taken":
            where = f" ({view.status.direction})" if view.status.direction else ""
            click.echo(f"{phase}{where}: {view.status.message}", err=True)
        self._last = phase

    def recorded(self, text: str) -> None:
        """Report a recorded pose, and the results of all poses so far."""
        for line in self._outlook.lines_after(text):
            click.echo(line, err=True)

    def close(self) -> None:
        """Nothing to remove."""


class LivePanel:
    """The next attitude, traces, stillness and directions, updated in place on the terminal."""

    def __init__(self, outlook: "Outlook") -> None:
        self._live: Live | None = None
        self._outlook = outlook
        self._traces: deque[FloatArray] = deque(maxlen=TRACE)

    def say(self, text: str) -> None:
        """Print a line above the panel."""
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
        self._traces.append(view.status.reading)
        self._live.update(panel(view, np.array(self._traces)))

    def recorded(self, text: str) -> None:
        """Print lines above the panel, and ring the terminal's bell."""
        if self._live is not None:
            self._live.console.bell()
        for line in self._outlook.lines_after(text):
            self.say(line)

    def close(self) -> None:
        """Remove the panel."""
        if self._live is not None:
            self._live.stop()
            self._live = None


def trace_text(values: "FloatArray") -> str:
    """Values (t,) as bars between their smallest and largest."""
    low, span = float(values.min()), float(np.ptp(values))
    if not np.isfinite(span) or span == 0:
        return BARS[0] * len(values)
    return "".join(BARS[int(share)] for share in (values - low) / span * (len(BARS) - 1))


def panel(view: "RecordingView", traces: "FloatArray") -> "Table":
    """The panel of one moment; ``traces`` (t, 6) are the last readings."""
    from rich.table import Table
    from rich.text import Text

    from calib.poses.attitudes import direction_name
    from pipeline.drawings.sheet import box_text

    status, reading, wanted = view.status, view.status.reading, view.next_wanted
    table = Table.grid(padding=(0, 2))
    colour = MARK[status.phase]
    bar = "█" * round(status.progress * BAR)
    table.add_row("now", Text(f"{status.phase}  {bar}", style=colour))
    table.add_row("", Text(visible(status.message), style=colour))
    table.add_row("up", status.direction or "?")
    table.add_row("acc", "  ".join(f"{x:8.3f}" for x in reading[:3]) + "  m/s², by data sheet")
    table.add_row("", "  ".join(trace_text(values) for values in traces[:, :3].T))
    rpm = float(np.linalg.norm(reading[3:])) / RPM
    table.add_row("gyr", "  ".join(f"{x:8.4f}" for x in reading[3:])
                  + f"  rad/s, by data sheet: {rpm:.1f} rpm")
    table.add_row("", "  ".join(trace_text(values) for values in traces[:, 3:].T))
    names = Table.grid(padding=(0, 3))
    poses = [Text(f"{'✓' if i in view.covered else '·'} {direction_name(direction)}",
                     style="green" if i in view.covered else "dim")
                for i, direction in enumerate(view.wanted)]
    for first in range(0, len(poses), NAMES):
        names.add_row(*poses[first : first + NAMES])
    table.add_row(f"{len(view.covered)}/{len(view.wanted)}", names)
    table.add_row("line", f"{view.rate_hz:.1f} samples/s, {view.bad} damaged")
    if wanted is None:
        return table
    box = Text("\n".join(box_text(wanted)), style="bold")
    box.append(f"\nlay: {direction_name(wanted)}", style="cyan")
    beside = Table.grid(padding=(0, 2))
    beside.add_row(box, table)
    return beside
