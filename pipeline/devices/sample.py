"""One reading as a device sent it, and the time of samples.

A host receives samples in bursts: a reading is never received before it was made, and often much
later. The device makes them evenly, so sample k was made at ``t0 + k step``, and the arrivals lie
on or above that line. The line is found from the earliest arrival of each of many stretches, by the
median of all their slopes (Theil and Sen): a third of the stretches may be late altogether.
"""

import math
from abc import ABC, abstractmethod
from collections.abc import Container, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pipeline.logs.columns import ACCELEROMETER, COUNTER, GYROSCOPE, TIME

Triple = tuple[float, float, float]
NOT_SENT: Triple = (math.nan, math.nan, math.nan)
CLOCK_MODULUS = 1 << 32  #: fact: the clocks of Arduinos and the fine time of an Xsens have 32 bits

COUNTS = "counts"  #: unit of readings straight from the converter
AS_LABELLED = "unit not stated"  #: unit of readings in lines without one


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
    """Time stamps of a device.

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
#: Column of times, or of a counter -> its clock, and the ticks in one unit of the number; of
#: several columns the first counts.
CLOCKS: Mapping[str, tuple[DeviceClock, float]] = {
    "time_us": (MICROS, 1.0),
    "time_ms": (DeviceClock("board milliseconds", 1e-3, CLOCK_MODULUS), 1.0),
    TIME: (DeviceClock("board seconds, in microseconds", 1e-6, None), 1e6),
    COUNTER: (DeviceClock("row counter", None, None), 1.0),
}


def clock_among(names: Container[str]) -> str | None:
    """The column of :data:`CLOCKS` among these columns; None without one."""
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


class Parser(ABC):
    """Converts bytes to samples: a reader finds the lines or messages, of which each may be one.

    Attributes
    ----------
    clock : DeviceClock or None
        The device's clock; None where it sends no time, or before the first sample.
    unit : str
        Unit of the readings: ``counts``, or a pair such as ``m/s², rad/s``.
    advice : str
        Advice where the stream is understood but unusable; empty otherwise.
    """

    def __init__(self, reader: Any, unit: str, clock: DeviceClock | None = None) -> None:
        self.clock = clock
        self.unit = unit
        self.advice = ""
        self._reader = reader
        self._damaged = 0

    @property
    def bad(self) -> int:
        """Damaged messages or lines so far."""
        return int(self._reader.bad) + self._damaged

    def feed(self, data: bytes) -> list[Sample]:
        """The samples that ``data`` completes."""
        samples = map(self._sample, self._reader.feed(data))
        return [sample for sample in samples if sample is not None]

    @abstractmethod
    def _sample(self, message: Any) -> Sample | None:
        """The sample that a message or line completes, None where it completes none."""


FloatArray = NDArray[np.float64]

STRETCHES = 120
"""Number of stretches of a stream, one arrival from each. For ten minutes of simulated bursts,
those of the test of this module, the step errs 1.4 times as much with half as many and 1.1 times
with twice as many."""

EARLIEST_SHARE = 0.1  #: share of the stretches' earliest arrivals that lie below the line


class Unwrap:
    """Device ticks without the jumps back to 0; the first is 0.

    A step back by more than half the modulus is a wrap; any other is a restart of the device, after
    which the count continues from the last value. A clock coarser than the samples gives one value
    twice: the second is one tick later, and the next step is shorter by one.
    """

    def __init__(self, clock: DeviceClock) -> None:
        self._modulus = clock.modulus
        self._last: int | None = None
        self._total = 0
        self._ahead = 0
        self.restarts = 0

    def __call__(self, ticks: int) -> int:
        """The ticks since the first, never less than those before."""
        if self._last is not None:
            step = ticks - self._last
            if self._modulus and step < 0:
                step %= self._modulus
                if step > self._modulus // 2:
                    step = -1
            self.restarts += step < 0
            self._ahead += step == 0
            back = min(self._ahead, max(step - 1, 0))
            self._ahead -= back
            self._total += max(step - back, 1)
        self._last = ticks
        return self._total


def straight_line(arrival_s: FloatArray, index: FloatArray | None = None) -> tuple[float, float]:
    """``(t0, step)`` of the times ``t0 + index * step`` at which evenly made samples were made.

    Parameters
    ----------
    arrival_s : array, shape (t,)
        Times of arrival at the host; bursts, delays and steps back are expected.
    index : array, shape (t,), optional
        Number of each sample; by default 0 ... t - 1.

    Returns
    -------
    (float, float)
        In seconds. The step is 0 where there are fewer than two samples.
    """
    k = np.arange(len(arrival_s), dtype=float) if index is None else index
    if len(k) < 2 or k[-1] == k[0]:
        return (float(arrival_s[0]) if len(k) else 0.0), 0.0
    rough = (arrival_s[-1] - arrival_s[0]) / (k[-1] - k[0])
    early = np.array([
        int(start + np.argmin(arrival_s[start:stop] - rough * k[start:stop]))
        for start, stop in pairwise(
            np.linspace(0, len(k), min(STRETCHES, len(k) // 2 or 1) + 1).astype(int))
        if stop > start
    ])
    x, y = k[early], arrival_s[early]
    i, j = np.triu_indices(len(x), 1)
    apart = x[j] > x[i]
    step = (float(np.median((y[j] - y[i])[apart] / (x[j] - x[i])[apart]))
            if apart.any() else float(rough))
    return float(np.quantile(y - step * x, EARLIEST_SHARE)), step


def rate_of(times_s: Sequence[float]) -> float:
    """Samples per second of increasing times; NaN where there are fewer than two."""
    if len(times_s) < 2 or times_s[-1] <= times_s[0]:
        return math.nan
    return (len(times_s) - 1) / (times_s[-1] - times_s[0])
