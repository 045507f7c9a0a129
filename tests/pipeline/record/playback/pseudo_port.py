"""Puts a played device on a pseudo-terminal, which programs open like a serial port."""

import os
import time
from collections.abc import Callable
from pathlib import Path

from pipeline.errors import DeviceError, UnwritableOutput
from tests.pipeline.record.playback.device import PlaybackDevice

TICK_S = 0.005  #: how often samples are sent
MOST_AT_ONCE = 4096  #: samples; after a pause of this process the rest is left out


class PseudoPort:
    """A pseudo-terminal with a device behind it.

    Parameters
    ----------
    link : Path or None
        A name that always leads to the terminal, as its own changes with every unplugging.

    Raises
    ------
    DeviceError
        This system has no pseudo-terminals.
    UnwritableOutput
        ``link`` is a file of the user's, or cannot be made.
    """

    def __init__(self, link: Path | None = None) -> None:
        self._link = link
        self._master = -1
        self.name = ""
        self.plug_in()

    def plug_in(self) -> None:
        """Open a terminal.

        Raises
        ------
        DeviceError
            The system has no pseudo-terminals.
        """
        if not hasattr(os, "openpty"):
            raise DeviceError("this system has no pseudo-terminals; a played device needs Linux or "
                              "macOS (on Windows, WSL has them).")
        import tty

        self._master, slave = os.openpty()
        tty.setraw(slave)
        self.name = os.ttyname(slave)
        self._slave = slave  # kept open: without any reader the terminal would hang up
        os.set_blocking(self._master, False)
        if self._link is not None:
            self._lead(self._link)

    def _lead(self, link: Path) -> None:
        """Let ``link`` lead to the terminal; only a link to a terminal is replaced."""
        is_port = link.is_symlink() and os.readlink(link).startswith("/dev/")
        if os.path.lexists(link) and not is_port:
            raise UnwritableOutput(
                f"{link}: exists and is no link to a port; it is left as it is. Choose another "
                f"name with --link."
            )
        try:
            link.unlink(missing_ok=True)
            link.symlink_to(self.name)
        except OSError as error:
            raise UnwritableOutput(
                f"{link}: the link cannot be made ({error.strerror}). Choose another name with "
                f"--link."
            ) from error

    def unplug(self) -> None:
        """Close the terminal; whoever has it open finds the device gone."""
        os.close(self._slave)
        os.close(self._master)

    def send(self, data: bytes) -> int:
        """Send what the terminal has room for, and lose the rest, as a serial line does."""
        try:
            return os.write(self._master, data)
        except BlockingIOError:
            return 0

    def receive(self) -> bytes:
        """What was written to the port."""
        try:
            return os.read(self._master, 4096)
        except OSError:  # nothing there, or nobody has it open
            return b""

    def play(
        self,
        device: PlaybackDevice,
        rate_hz: float,
        unplug_every_s: float | None = None,
        unplugged_s: float = 2.0,
        on: Callable[[], bool] = lambda: True,
    ) -> None:
        """Play ``device`` at ``rate_hz`` samples a second for as long as ``on()``."""
        self.send(device.greeting())
        begun = pulled = time.monotonic()
        sent = 0
        while on():
            time.sleep(TICK_S)
            now = time.monotonic()
            if unplug_every_s is not None and now - pulled > unplug_every_s:
                self.unplug()
                time.sleep(unplugged_s)
                self.plug_in()
                pulled = begun = time.monotonic()
                sent = 0
                continue
            if answer := device.answer(self.receive()):
                self.send(answer)
            due = int((now - begun) * rate_hz)
            if device.measuring and due > sent:
                count = min(due - sent, MOST_AT_ONCE)
                self.send(b"".join(device.next_sample() for _ in range(count)))
            sent = due
