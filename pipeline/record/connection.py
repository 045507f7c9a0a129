"""From a port to a stream of rows: opening, setting up, finding the speed, keeping every byte."""

import time
from collections.abc import Callable
from contextlib import ExitStack

from pipeline.config.load import Config
from pipeline.config.record_section import RecordSection
from pipeline.config.sensor import AccelerometerSheet, GyroscopeSheet
from pipeline.devices.mpu6050_text import G_AND_DEG, SI, Mpu6050TextParser
from pipeline.devices.sample import AS_LABELLED, COUNTS, Parser
from pipeline.devices.table import DEVICES
from pipeline.errors import ConfigError, DeviceError
from pipeline.record.serial_port import Port, PortLost
from pipeline.record.store import RawFile, Store
from pipeline.record.stream import Stream, TimedSample
from pipeline.record.xsens_setup import XsensError, XsensStream, start_mtdata, start_mtdata2

LISTEN_S = 4.0  #: wait for first readings at one speed; an Arduino takes two seconds to start
FIRST_SAMPLES = 3  #: samples by which a stream is recognised
DEFAULT_RATE_HZ = 100.0  #: every sensor of the table can send it; `record.sample_rate_hz` overrules
SILENT_S = 3.0  #: without a reading, after which the user is notified
DEAD_S = 20.0  #: after which the line counts as lost
SHOWN_BYTES = 48  #: bytes of an unrecognised stream, in a message

#: parser's unit -> the units that sensor.accelerometer and sensor.gyroscope then need.
SHEET_UNITS = {COUNTS: (None, None), SI: ("m_s2", "rad_s"), G_AND_DEG: ("g", "deg_s")}

OpenPort = Callable[[int], Port]


Tell = Callable[[str], None]
"""Shows a line to the user."""


class Connection:
    """A device that sends readings.

    Parameters
    ----------
    config : Config
        With a ``record`` section.
    open_port : callable
        Opens the port at a speed.
    store : Store
        Where every byte goes.
    tell : callable
        Says a line to the user.

    Raises
    ------
    DeviceError
        Silence, or bytes that are no readings of this device; what was found and what to do.
    ConfigError
        The device sends other units, or is set to another range, than the configuration says.
    """

    def __init__(self, config: Config, open_port: OpenPort, store: Store, tell: Tell) -> None:
        assert config.record is not None
        self._record: RecordSection = config.record
        self._store = store
        self._device = DEVICES[self._record.device]
        bauds = (self._record.baud,) if self._record.baud else self._device.bauds
        self._port = open_port(bauds[0])
        self._raw: RawFile = store.new_connection()
        with ExitStack() as undo:
            undo.callback(self.close)
            self.stream = self._begin(bauds, tell)
            check_units(config, self.stream.parser)
            undo.pop_all()
        self._last_row_s = store.now_s()

    def _begin(self, bauds: tuple[int, ...], tell: Tell) -> Stream:
        heard = b""
        for i, baud in enumerate(bauds):
            if i:
                tell(f"nothing to understand at {bauds[i - 1]} baud, trying {baud}")
                self._port.set_baud(baud)
            begun = self._set_up(last=baud == bauds[-1])
            if self._device.begin and begun is None:
                continue
            parser = self._device.make(self._record.pattern or "")
            stream = Stream(parser, begun.rate_hz if begun else self._record.sample_rate_hz)
            if begun:
                stream.feed(begun.first_bytes, self._store.now_s())
            until = time.monotonic() + LISTEN_S
            while time.monotonic() < until:
                data, heard_s = self._take()
                heard = (heard + data)[-SHOWN_BYTES:]
                stream.feed(data, heard_s)
                if stream.samples >= FIRST_SAMPLES:
                    return stream
            if stream.parser.advice:
                raise DeviceError(f"The device answers, but: {stream.parser.advice}.")
        raise DeviceError(self._why_nothing(heard, bauds))

    def _set_up(self, last: bool) -> XsensStream | None:
        """Set an Xsens up; None for a device that streams by itself.

        An Xsens that does not answer gives None as well, while there are speeds left to try.
        """
        begin = {"mtdata": start_mtdata, "mtdata2": start_mtdata2, None: None}[self._device.begin]
        if begin is None:
            return None
        wanted = self._record.sample_rate_hz or DEFAULT_RATE_HZ
        try:
            return begin(self._port, wanted, self._keep)
        except (XsensError, PortLost):
            raise
        except DeviceError:
            if last:
                raise
            return None

    def _why_nothing(self, heard: bytes, bauds: tuple[int, ...]) -> str:
        tried = ", ".join(map(str, bauds))
        if not heard:
            return (f"The port is open, but nothing comes within {LISTEN_S:g} s (tried {tried} "
                    f"baud). Is it the right port (`pipeline record --ports`), is the device "
                    f"powered, does its sketch run?")
        return (f"Bytes come, but no readings of device '{self._record.device}' (tried {tried} "
                f"baud); the last are {heard!r}. Set record.baud to the speed of the sketch, or "
                f"record.device to what the device is; any other line can be described with "
                f"`device: lines` and `pattern`. A sketch that sends bytes without lines has to "
                f"print text: in i2cdevlib's MPU6050_raw define OUTPUT_READABLE_ACCELGYRO.")

    def _keep(self, data: bytes, heard_monotonic_s: float) -> None:
        self._raw.keep(data, self._store.session_s(heard_monotonic_s))

    def _take(self) -> tuple[bytes, float]:
        """The bytes that have come, stored, and their time on the session's clock."""
        data, heard_monotonic_s = self._port.read()
        self._keep(data, heard_monotonic_s)
        return data, self._store.session_s(heard_monotonic_s)

    def rows(self) -> list[TimedSample]:
        """Rows that have come; empty after a short while without any.

        Raises
        ------
        PortLost
            The device is gone, or has been silent for ``DEAD_S``.
        """
        data, heard_s = self._take()
        rows = self.stream.feed(data, heard_s)
        if rows:
            self._last_row_s = heard_s
        elif self.silent_s > DEAD_S:
            raise PortLost(f"no reading for {DEAD_S:.0f} s. {self.stream.parser.advice}".strip())
        return rows

    @property
    def silent_s(self) -> float:
        """Time since the last reading."""
        return self._store.now_s() - self._last_row_s

    def close(self) -> None:
        """Release the port and close the files."""
        self._port.close()
        self._raw.close()


def check_units(config: Config, parser: Parser) -> None:
    """Refuse a device whose readings contradict the data sheet of the configuration.

    Raises
    ------
    ConfigError
        With the section to write instead.
    """
    sheets: tuple[tuple[str, AccelerometerSheet | GyroscopeSheet | None], ...] = (
        ("accelerometer", config.sensor.accelerometer), ("gyroscope", config.sensor.gyroscope))
    if parser.unit != AS_LABELLED:
        for (triad, sheet), unit in zip(sheets, SHEET_UNITS[parser.unit], strict=True):
            if sheet is not None and sheet.unit != unit:
                wanted = (f"`{triad}: {{unit: {unit}}}`" if unit else
                          f"`{triad}: {{full_scale_..., bits: ..., encoding: ...}}`")
                raise ConfigError(config.source.problem(("sensor",), (
                    f"the device sends readings in {parser.unit}, which the data sheet given here "
                    f"does not describe. Write {wanted} under sensor.")))
    settings = parser.settings if isinstance(parser, Mpu6050TextParser) else {}
    for (triad, sheet), key in zip(sheets, ("fs_a", "fs_g"), strict=True):
        stated = getattr(sheet, "full_scale_g" if key == "fs_a" else "full_scale_deg_s", None)
        if key in settings and stated is not None and settings[key] != stated:
            unit = "g" if key == "fs_a" else "°/s"
            raise ConfigError(config.source.problem(("sensor",), (
                f"the sketch has set the {triad} to ±{settings[key]:g} {unit}, the data sheet "
                f"given here says ±{stated:g} {unit}. Change one of the two.")))
