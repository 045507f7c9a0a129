"""The driver of foreign logs: a file's name, what stands above, and a line for each sample."""

import gzip
import json
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path

import numpy as np

from tests.pipeline.guess.hand_log import HandLog

G = 9.80665
DEG = np.pi / 180
EPOCH_S = 1_700_000_000
AXES = "ax,ay,az,gx,gy,gz"
FORMAT = re.compile(r"\d*(\.\d+)?[a-zA-Z]?$")


@dataclass(frozen=True)
class Foreign:
    """Files, and the units per SI unit in which they hold the accelerometer and the gyroscope."""

    files: list[Path]
    per_m_s2: float = 1.0
    per_rad_s: float | None = 1.0
    rate_hz: float | None = None


Writer = Callable[[Path, HandLog], Foreign]
Change = Callable[[list[str]], object]


class Values(tuple[float, ...]):
    """Numbers that a format joins: ``f"{values:;.2f}"`` has two decimals each, and semicolons."""

    def __format__(self, spec: str) -> str:
        match = FORMAT.search(spec)
        assert match is not None
        return spec[: match.start()].join(f"{value:{match[0]}}" for value in self)


@dataclass(frozen=True)
class Sample:
    """A sample: its number, its time in s, and readings in the units of the file.

    ``c`` are the six readings as whole numbers, ``c16`` those within 16 bits.
    """

    i: int
    t: float
    a: Values
    w: Values

    @property
    def c(self) -> Values:
        return Values(round(value) for value in (*self.a, *self.w))

    @property
    def c16(self) -> Values:
        return Values(int(value) for value in np.clip(self.c, -32768, 32767))

    @property
    def s(self) -> str:
        """The row of a plain table: time to ms, readings to six decimals, commas."""
        return f"{self.t:.3f},{self.a:,.6f},{self.w:,.6f}"

    @property
    def cells(self) -> list[str]:
        """The seven cells of that row."""
        return self.s.split(",")


def samples(log: HandLog, acc: float = 1.0, gyr: float = 1.0) -> list[Sample]:
    """The samples of a recording in units per SI unit."""
    return [Sample(i, t, Values(a), Values(w)) for i, (t, a, w) in enumerate(zip(
        log.time_s.tolist(), (log.acc * acc).tolist(), (log.gyr * gyr).tolist(), strict=True))]


def write_lines(path: Path, lines: Sequence[str], encoding: str = "utf-8", end: str = "\n") -> Path:
    data = (end.join(lines) + end).encode(encoding)
    path.write_bytes(gzip.compress(data) if path.suffix == ".gz" else data)
    return path


def rows(
    name: str, head: str, line: Callable[[Sample], str], acc: float = 1.0,
    gyr: float | None = 1.0, *, timed: bool = True, change: Change | None = None,
    encoding: str = "utf-8", end: str = "\n",
) -> Writer:
    """A text with a line for each sample.

    Parameters
    ----------
    name, head : str
        Of the file, and the lines above the samples.
    line : callable
        Text of a sample; it may hold several lines.
    acc, gyr : float
        Units per m/s² and rad/s; None where no gyroscope is to be read.
    timed : bool
        Whether the file tells the rate.
    change : callable, optional
        Changes the lines of the samples in place.
    encoding, end : str
        Of the file, and of each line.
    """
    def write(folder: Path, log: HandLog) -> Foreign:
        lines = [line(each) for each in samples(log, acc, gyr or 1.0)]
        if change is not None:
            change(lines)
        lines = [*head.splitlines(), *lines] if head else lines
        path = write_lines(folder / name, lines, encoding, end)
        return Foreign([path], acc, gyr, None if timed else log.rate_hz)

    return write


def pose_rows(
    name: str, head: str, line: Callable[[Sample], str], acc: float, gyr: float | None,
) -> Writer:
    """A file for each rest, whose name holds ``{}``."""
    def write(folder: Path, log: HandLog) -> Foreign:
        every = samples(log, acc, gyr or 1.0)
        return Foreign([write_lines(folder / name.format(f"{k:02d}"), [*head.splitlines(), *(
            line(each) for each, rest in zip(every, log.rest, strict=True) if rest == k)])
            for k in range(int(log.rest.max()) + 1)], acc, gyr)

    return write


def per_triad(
    names: dict[str, str], head: str, line: Callable[[float, Values], str],
    acc: float = 1.0, gyr: float = 1.0,
) -> Writer:
    """A file for each sensor: ``names`` are those of the files and what ``{}`` is in the head."""
    def write(folder: Path, log: HandLog) -> Foreign:
        files = []
        for (name, words), values in zip(names.items(), (log.acc * acc, log.gyr * gyr),
                                         strict=True):
            (folder / name).parent.mkdir(exist_ok=True)
            files.append(write_lines(folder / name, [*head.replace("{}", words).splitlines(), *(
                line(t, Values(row)) for t, row in zip(log.time_s, values, strict=True))]))
        return Foreign(files, acc, gyr)

    return write


def json_of(
    name: str, content: Callable[[HandLog], object], acc: float = 1.0, gyr: float = 1.0,
    indent: int | None = None,
) -> Writer:
    """One document of JSON."""
    def write(folder: Path, log: HandLog) -> Foreign:
        (folder / name).write_text(json.dumps(content(log), indent=indent), encoding="utf-8")
        return Foreign([folder / name], acc, gyr)

    return write


def when(t: float, form: str) -> str:
    """A date and time; ``%f`` in milliseconds at the end."""
    text = datetime.fromtimestamp(EPOCH_S + t, UTC).strftime(form)
    return text[:-3] if form.endswith("%f") else text


def comma(text: str) -> str:
    """Decimal commas."""
    return text.replace(".", ",")


def counts_of(log: HandLog, per_g: float = 16384.0, per_dps: float = 131.072) -> np.ndarray:
    """Whole numbers (t, 6)."""
    return np.rint(np.hstack([log.acc / G * per_g, log.gyr / DEG * per_dps])).astype(int)


def means_of(log: HandLog) -> list[np.ndarray]:
    """Means (3,) of the accelerometer in each rest."""
    return [log.acc[log.rest == k].mean(axis=0) for k in range(int(log.rest.max()) + 1)]
