"""One reading as a device sent it, and the clock that the device stamped it with."""

import math
from collections.abc import Container, Mapping
from dataclasses import dataclass
from typing import Protocol

from pipeline.logs.columns import ACCELEROMETER, COUNTER, GYROSCOPE, TIME

Triple = tuple[float, float, float]
NOT_SENT: Triple = (math.nan, math.nan, math.nan)
CLOCK_MODULUS = 1 << 32  #: fact: the clocks of Arduinos and the fine time of an Xsens have 32 bits

COUNTS = "counts"  #: unit of readings straight from the converter
AS_LABELLED = "unit not stated"  #: unit of readings whose line states none


@dataclass(frozen=True, slots=True)
class Sample:
    """One reading.

    Parameters
    ----------
    accelerometer, gyroscope : (float, float, float)
        In the parser's ``unit``; NaN where the device does not send the triad.
    ticks : int or None
        The device's own clock or sample counter, wrapped as the device wraps it.
    columns : tuple of (str, float)
        What else it sent, by the name of the log's column, for example ``temperature_c``.
    """

    accelerometer: Triple
    gyroscope: Triple
    ticks: int | None = None
    columns: tuple[tuple[str, float], ...] = ()


@dataclass(frozen=True)
class DeviceClock:
    """How a device stamps its samples.

    Parameters
    ----------
    name : str
        In words, for the log's head.
    tick_s : float or None
        Length of a tick in seconds; None for a counter that steps once per sample.
    modulus : int or None
        The value at which it starts again from 0; None where it never does.
    """

    name: str
    tick_s: float | None
    modulus: int | None


MICROS = DeviceClock("board microseconds", 1e-6, CLOCK_MODULUS)
#: Column of times, or of a counter -> the clock it is, and how many of its ticks the number 1 is;
#: of several columns the first counts.
CLOCKS: Mapping[str, tuple[DeviceClock, float]] = {
    "time_us": (MICROS, 1.0),
    "time_ms": (DeviceClock("board milliseconds", 1e-3, CLOCK_MODULUS), 1.0),
    TIME: (DeviceClock("board seconds, in microseconds", 1e-6, None), 1e6),
    COUNTER: (DeviceClock("row counter", None, None), 1.0),
}


def clock_among(names: Container[str]) -> str | None:
    """The column of :data:`CLOCKS` that stamps samples with these columns; None without one."""
    return next((clock for clock in CLOCKS if clock in names), None)


def sample_of(values: Mapping[str, float]) -> Sample:
    """The sample of one reading from its numbers by the names of a log's columns."""
    stamp = clock_among(values)
    ticks = None if stamp is None else round(values[stamp] * CLOCKS[stamp][1])
    (ax, ay, az), (gx, gy, gz) = (
        [values[name] for name in triad] if triad[0] in values else NOT_SENT
        for triad in (ACCELEROMETER, GYROSCOPE))
    return Sample((ax, ay, az), (gx, gy, gz), ticks, tuple(
        (name, value) for name, value in values.items()
        if name not in (*CLOCKS, *ACCELEROMETER, *GYROSCOPE)))


class Parser(Protocol):
    """Bytes in, samples out."""

    @property
    def clock(self) -> DeviceClock | None:
        """The device's clock; None where it sends no time, or before the first sample."""
        ...

    @property
    def unit(self) -> str:
        """Unit of the readings: ``counts``, or a pair such as ``m/s², rad/s``."""
        ...

    @property
    def bad(self) -> int:
        """Damaged frames or lines so far."""
        ...

    @property
    def advice(self) -> str:
        """What to do where the stream is understood but of no use; empty otherwise."""
        ...

    def feed(self, data: bytes) -> list[Sample]:
        """The samples that ``data`` completes."""
        ...

    def finish(self) -> list[Sample]:
        """The samples that the end of the stream completes."""
        ...
