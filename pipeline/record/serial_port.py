"""The serial line: the only module that uses pyserial."""

import errno
import os
import queue
import sys
import threading
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

import serial
from serial.tools import list_ports

from pipeline.errors import DeviceError

READ_S = 0.05  #: longest wait for a byte; available bytes are taken at once
MOST_AT_ONCE = 65536  #: bytes, 0.7 s at 921 600 baud; chosen


class PortLost(DeviceError):
    """The device has vanished from its port: unplugged, or switched off."""


class Port(Protocol):
    """A device's line, for the recording."""

    def read(self) -> tuple[bytes, float]:
        """Received bytes and their time, ``time.monotonic``; empty after a short while without any.

        Raises
        ------
        PortLost
            The device is gone.
        """
        ...

    def write(self, data: bytes) -> None:
        """Send ``data``."""
        ...

    def set_baud(self, baud: int) -> None:
        """Change the speed and drop what came at the old one."""
        ...

    def close(self) -> None:
        """Release the port."""
        ...


class SerialPort:
    """A serial port; see :class:`Port`.

    Opening it resets most Arduinos, which then greet and start anew; data buffered by the driver
    before that are dropped.

    Raises
    ------
    DeviceError
        There is no such port, it may not be opened, or another program has it.
    """

    def __init__(self, port: str, baud: int) -> None:
        self.port = port
        try:
            # Exclusive use, where the system can grant it: Windows grants it anyway.
            self._serial = serial.Serial(port, baud, timeout=READ_S,
                                         exclusive=True if os.name == "posix" else None)
            self._serial.reset_input_buffer()
            # A thread of its own takes the bytes off the system, whose buffer holds a tenth of a
            # second at full speed, also while a pose is written to the disk.
            self._heard: queue.SimpleQueue[tuple[bytes, float] | PortLost] = queue.SimpleQueue()
            self._open = threading.Event()
            self._open.set()
            self._thread = threading.Thread(target=self._listen, daemon=True)
            self._thread.start()
        except serial.SerialException as error:
            raise DeviceError(_why_not(port, error)) from error
        except (OSError, ValueError) as error:
            raise DeviceError(f"{port}: cannot be opened at {baud} baud ({error}). Check port and "
                              "baud under record; `pipeline record --ports` lists the "
                              "ports.") from error

    def _listen(self) -> None:
        """Take bytes as they come, stamped with their time of arrival."""
        while self._open.is_set():
            try:
                first: bytes = self._serial.read(1)
                if first:
                    rest: bytes = self._serial.read(min(self._serial.in_waiting, MOST_AT_ONCE))
                    self._heard.put((first + rest, time.monotonic()))
            except (OSError, TypeError) as error:  # TypeError: pyserial, closed while it reads
                self._heard.put(self._lost(error))
                return

    def read(self) -> tuple[bytes, float]:
        """Received bytes, and their time; empty after ``READ_S`` without any."""
        try:
            heard = self._heard.get(timeout=READ_S)
        except queue.Empty:
            return b"", time.monotonic()
        if isinstance(heard, PortLost):
            raise heard
        return heard

    def write(self, data: bytes) -> None:
        """Send ``data``."""
        try:
            self._serial.write(data)
        except OSError as error:
            raise self._lost(error) from error

    def _lost(self, error: Exception) -> PortLost:
        return PortLost(f"{self.port}: the device is gone ({error}). Plug it in again.")

    def set_baud(self, baud: int) -> None:
        """Change the speed and drop what came at the old one."""
        try:
            self._serial.baudrate = baud
            self._serial.reset_input_buffer()
            while not self._heard.empty():
                self._heard.get()
        except (OSError, ValueError) as error:
            raise PortLost(f"{self.port}: does not take {baud} baud ({error}).") from error

    def close(self) -> None:
        """Release the port."""
        self._open.clear()
        self._thread.join()
        self._serial.close()


def _why_not(port: str, error: serial.SerialException) -> str:
    """Reason why a port does not open, and what to do, in one paragraph."""
    text = str(error)
    number = getattr(error, "errno", None)
    if number == errno.ENOENT or "FileNotFound" in text or "No such file" in text:
        there = ", ".join(port_info.name for port_info in find_ports()) or "none"
        return (f"{port}: there is no such port; the ports here are: {there}. Plug the device in, "
                "look with `pipeline record --ports`, and set record.port.")
    if number in (errno.EACCES, errno.EPERM) or "PermissionError" in text:
        return f"{port}: may not be opened. {permission_advice(port)}"
    if number in (errno.EBUSY, errno.EWOULDBLOCK) or "exclusively lock" in text:
        return (f"{port}: another program uses it. Close the Arduino Serial Monitor, MT Manager or "
                "another `pipeline record`, then try again.")
    return f"{port}: cannot be opened ({error}). Look with `pipeline record --ports`."


def permission_advice(port: str) -> str:
    """Advice where a port exists and may not be opened."""
    if sys.platform.startswith("linux"):
        group = _group_of(port) or "dialout"
        return (f"Ports belong to the group '{group}': type `sudo usermod -aG {group} $USER`, log "
                "out and in again, and try once more.")
    if sys.platform == "darwin":
        return "Use the /dev/cu.* name of the port, and close other programs that have it open."
    return "Close other programs that have it open, such as the Arduino Serial Monitor."


def _group_of(port: str) -> str | None:
    try:
        return Path(port).group()
    except (OSError, KeyError, NotImplementedError):  # the last where files have no groups: Windows
        return None


@dataclass(frozen=True)
class SerialPortInfo:
    """One serial port: its name, its own description, the probable device behind it, access."""

    name: str
    description: str
    probably: str
    may_open: bool


#: USB vendor ids of the serial chips on these boards.
VENDORS = {
    0x2639: "Xsens", 0x2341: "Arduino", 0x2A03: "Arduino", 0x1A86: "Arduino clone (CH340)",
    0x10C4: "board with a CP210x", 0x0403: "board or Xsens cable with an FTDI chip",
    0x239A: "Adafruit", 0x303A: "ESP32", 0x2E8A: "Raspberry Pi Pico",
}


def find_ports() -> list[SerialPortInfo]:
    """The available serial ports, those on USB first."""
    ports = sorted(list_ports.comports(), key=lambda port: (port.vid is None, port.device))
    return [
        SerialPortInfo(
            port.device,
            port.description if port.description not in (None, "n/a") else "",
            VENDORS.get(port.vid, "USB device") if port.vid is not None else "",
            os.name != "posix" or os.access(port.device, os.R_OK | os.W_OK),
        )
        for port in ports
    ]


def only_port() -> str:
    """The default port if the configuration names none.

    Raises
    ------
    DeviceError
        There is no USB port, or more than one.
    """
    ports = [port for port in find_ports() if port.probably]
    if len(ports) == 1:
        return ports[0].name
    if not ports:
        raise DeviceError("record.port is not given, and no USB serial port is there. Plug the "
                          "sensor in, or name its port; `pipeline record --ports` lists what "
                          "there is.")
    listed = ", ".join(f"{port.name} ({port.probably})" for port in ports)
    raise DeviceError(f"record.port is not given, and there are {len(ports)} USB serial ports: "
                      f"{listed}. Name one of them.")
