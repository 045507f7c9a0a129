"""A device's stream as rows with times by two clocks: the device's and the host's."""

import math
from dataclasses import dataclass

import numpy as np

from pipeline.devices.sample import FloatArray, Parser, Triple, Unwrap, rate_of, straight_line

MOST_ARRIVALS = 20_000  #: remembered for the straight line; older ones are thinned out
RATE_AFTER_S = 2.0  #: time of arrivals, where only these show the sample rate
RATE_AFTER_SAMPLES = 20  #: where the device's clock shows it


@dataclass(frozen=True, slots=True)
class TimedSample:
    """One sample and the times at which it was made and received.

    ``index`` counts samples of this connection, ``ticks`` the device's clock since its first
    sample (None without one), ``heard_s`` is the session's clock.
    """

    index: int
    ticks: int | None
    heard_s: float
    accelerometer: Triple
    gyroscope: Triple
    columns: tuple[tuple[str, float], ...]


class Stream:
    """Converts received bytes to rows; one for each connection.

    Parameters
    ----------
    parser : Parser
        New, for this connection.
    sample_rate_hz : float or None
        As the device was set to, or as the configuration states it; turns a sample counter into
        time. Where there is no counter, the arrivals show the rate.
    """

    def __init__(self, parser: Parser, sample_rate_hz: float | None) -> None:
        self.parser = parser
        self._stated_hz = sample_rate_hz
        self._unwrap: Unwrap | None = None
        self._index = 0
        self._arrivals: list[tuple[float, float]] = []  # (index or counter, heard_s)
        self._keep_every = 1
        self._first: TimedSample | None = None
        self._last: TimedSample | None = None

    @property
    def samples(self) -> int:
        """Samples so far."""
        return self._index

    @property
    def restarts(self) -> int:
        """Number of restarts of the device's clock."""
        return self._unwrap.restarts if self._unwrap else 0

    def feed(self, data: bytes, heard_s: float) -> list[TimedSample]:
        """The rows that ``data``, heard at ``heard_s``, completes."""
        rows = []
        for sample in self.parser.feed(data):
            ticks = None
            if sample.ticks is not None and self.parser.clock is not None:
                self._unwrap = self._unwrap or Unwrap(self.parser.clock)
                ticks = self._unwrap(sample.ticks)
            row = TimedSample(self._index, ticks, heard_s, sample.accelerometer, sample.gyroscope,
                      sample.columns)
            rows.append(row)
            self._index += 1
            self._first, self._last = self._first or row, row
            if row.index % self._keep_every == 0:
                self._arrivals.append((float(self._count(row)), heard_s))
        if len(self._arrivals) > MOST_ARRIVALS:
            self._keep_every *= 2
            del self._arrivals[1::2]
        return rows

    def _count(self, row: TimedSample) -> int:
        """Abscissa of the straight line: the counter where there is one, else the index."""
        return row.index if row.ticks is None else row.ticks

    @property
    def rate_hz(self) -> float | None:
        """Samples per second; None before it is known."""
        if self._first is None or self._last is None:
            return None
        made_s = self._device_span_s()
        if made_s is not None:
            known = self._last.index >= RATE_AFTER_SAMPLES and made_s > 0
            return self._last.index / made_s if known else None
        if self._stated_hz is not None:
            return self._stated_hz
        if self._last.heard_s - self._first.heard_s < RATE_AFTER_S:
            return None
        rate = rate_of([heard for _, heard in self._arrivals])
        return None if math.isnan(rate) else rate * self._keep_every

    def _device_span_s(self) -> float | None:
        clock = self.parser.clock
        if clock is None or clock.tick_s is None or self._last is None or self._last.ticks is None:
            return None
        return self._last.ticks * clock.tick_s

    def clock_name(self) -> str:
        """Source of the times, in words."""
        clock = self.parser.clock
        if clock is None or self._first is None or self._first.ticks is None:
            return "straight line through the host's arrival times"
        if clock.tick_s is None and self._stated_hz is None:
            return f"{clock.name}, straight line through the host's arrival times"
        rate = f" at {self._stated_hz:g} Hz" if clock.tick_s is None else ""
        return f"{clock.name}{rate}"

    def times(self, rows: list[TimedSample]) -> FloatArray:
        """Times of the rows, in seconds of the session's clock, strictly increasing, (t,).

        With a device clock the first sample was made when it was received, and the rest follow by
        the device; without, all lie on the straight line through the arrivals so far.
        """
        if not rows or self._first is None:
            return np.zeros(0)
        count = np.array([self._count(row) for row in rows], dtype=float)
        clock = self.parser.clock
        if rows[0].ticks is not None and clock is not None:
            step = clock.tick_s or (1 / self._stated_hz if self._stated_hz else None)
            if step is not None:
                return np.asarray(self._first.heard_s + count * step)
        arrivals = np.array(self._arrivals)
        start, step = straight_line(arrivals[:, 1], arrivals[:, 0])
        return np.asarray(start + count * step)
