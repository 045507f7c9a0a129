"""What a triad is: three axes that are calibrated against a known magnitude.

Fit, diagnosis, prediction and catalogue ask this registry for everything in which one triad
differs from another by name and unit alone; a further triad is one more record. The logs of
:mod:`calib.poses.imu_log` hold the first two.
"""

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import TypeVar

T = TypeVar("T")


@dataclass(frozen=True)
class TriadKind:
    """A kind of triad.

    Parameters
    ----------
    name : str
        Its key in configurations and results.
    word : str
        Its name in the sentences of the catalogue.
    unit : str
        SI unit of its readings.
    error_unit : str
        Unit in which its errors are shown.
    errors_per_unit : float
        Number of ``error_unit`` in one SI unit.
    reference : str
        What its magnitude is compared with, in words.
    """

    name: str
    word: str
    unit: str
    error_unit: str
    errors_per_unit: float
    reference: str


TRIAD_KINDS: dict[str, TriadKind] = {kind.name: kind for kind in (
    TriadKind("accelerometer", "accelerometer", "m/s²", "mm/s²", 1e3, "gravity"),
    TriadKind("gyroscope", "gyro", "rad/s", "°/s", math.degrees(1.0), "the rate of the plate"),
)}
"""Every kind of triad by name."""


class PerKind(Mapping[str, T]):
    """One value of every kind of triad, by its name; kinds may be added at any time."""

    def __init__(self, value: Callable[[TriadKind], T]) -> None:
        self._value = value

    def __getitem__(self, name: str) -> T:
        return self._value(TRIAD_KINDS[name])

    def __iter__(self) -> Iterator[str]:
        return iter(TRIAD_KINDS)

    def __len__(self) -> int:
        return len(TRIAD_KINDS)
