"""Typical sizes of effects as numbers, in the units that data sheets quote them in."""

from collections.abc import Iterable
from dataclasses import dataclass
from math import inf, radians, sqrt

from calib.earth import STANDARD_GRAVITY_M_S2
from calib.numbers import SECONDS_PER_HOUR
from calib.poses.imu_log import Triad

DEGREE, G = radians(1.0), STANDARD_GRAVITY_M_S2  #: rad, m/s²; definitions

OVER_QUOTED = 300.0
"""Factor over the largest quoted size that no part exceeds. A judgement: quoted parts differ by a
factor of thirty; ten times that again is another sensor, another unit or bad poses."""

QUOTED: dict[str, tuple[float, Triad | None]] = {
    "°/s": (DEGREE, "gyroscope"),
    "°/h": (DEGREE / SECONDS_PER_HOUR, "gyroscope"),
    "°/s/K": (DEGREE, "gyroscope"),
    "°/s/V": (DEGREE, "gyroscope"),
    "°/s/h": (DEGREE, "gyroscope"),
    "°/s/g": (DEGREE / G, "gyroscope"),
    "°/s/g²": (DEGREE / G**2, "gyroscope"),
    "1/(°/s)": (1 / DEGREE, "gyroscope"),
    "1/(°/s)²": (1 / DEGREE**2, "gyroscope"),
    "ppm": (1e-6, "gyroscope"),
    "mg": (1e-3 * G, "accelerometer"),
    "mg/K": (1e-3 * G, "accelerometer"),
    "mg/h": (1e-3 * G, "accelerometer"),
    "mg/g²": (1e-3 / G, "accelerometer"),
    "mg/g³": (1e-3 / G**2, "accelerometer"),
    "%": (1e-2, None),
    "%/K": (1e-2, None),
    "%/h": (1e-2, None),
    "°": (DEGREE, None),
    "mm": (1e-3, None),
}
"""Factor to the SI unit of an effect's parameters, and the triad that the unit belongs to."""


@dataclass(frozen=True)
class Size:
    """One parameter of an effect, as quoted: ``low`` to ``high`` (the same for one number)."""

    low: float
    high: float
    unit: str

    def __str__(self) -> str:
        span = f"{self.low:g}" if self.low == self.high else f"{self.low:g} to {self.high:g}"
        return f"{span} {self.unit}"

    @property
    def triad(self) -> Triad | None:
        """The triad that it is a size for; None for both."""
        return QUOTED[self.unit][1]

    @property
    def si(self) -> float:
        """Geometric middle of the range in the SI unit of the effect's parameters."""
        return sqrt(self.low * self.high) * QUOTED[self.unit][0]

    def within(self, unit: str, factor: float) -> str:
        """The range in another unit; ``factor`` is how many of it one SI unit of the parameters is.

        >>> between(0.5, 1.0, "mg/K").within("mm/s² per K", 1e3)
        '4.9 to 9.81 mm/s² per K'
        """
        per = QUOTED[self.unit][0] * factor
        low, high = (f"{end * per:.3g}" for end in (self.low, self.high))
        return f"{low if low == high else f'{low} to {high}'} {unit}"


@dataclass(frozen=True)
class Typical:
    """Typical sizes of an effect for one class of parts; ``note`` adds what numbers cannot."""

    sizes: tuple[Size, ...]
    note: str = ""

    def __str__(self) -> str:
        sizes = ", ".join(map(str, self.sizes))
        return f"{sizes} ({self.note})" if sizes and self.note else sizes or self.note

    def si_for(self, triad: Triad) -> float | None:
        """The size of a parameter for ``triad``, SI; None where none is quoted."""
        return next((size.si for size in self.sizes if size.triad in (None, triad)), None)


def largest_for(triad: Triad, classes: Iterable[Typical]) -> float:
    """Bound of a parameter for ``triad`` by the sizes of ``classes``, SI; infinite without any."""
    sizes = [size.high * QUOTED[size.unit][0] for each in classes for size in each.sizes
             if size.triad in (None, triad)]
    return OVER_QUOTED * max(sizes, default=inf)


def typical(*sizes: Size, note: str = "") -> Typical:
    """Quoted sizes for one class of parts."""
    return Typical(sizes, note)


def quoted(value: float, unit: str) -> Size:
    """One number."""
    return Size(value, value, unit)


def between(low: float, high: float, unit: str) -> Size:
    """A range."""
    return Size(low, high, unit)
