"""Kinds of triads: three axes that are calibrated against a known magnitude.

From the log to the report, everything in which one triad differs from another by name, columns and
unit alone is read from this registry; a further triad is one more record. The first two belong
together: accelerometer and gyroscope show each other's attitude, motion and frame.
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
    columns : tuple of str
        Its three columns in logs.
    sheet_units : tuple of str
        Units in which data sheets and logs state it, as keys end in them; the first is ``unit``.
    magnitude_key : str
        Key that states the magnitude in its section of a configuration; empty where gravity or the
        plate is the reference.
    """

    name: str
    word: str
    unit: str
    error_unit: str
    errors_per_unit: float
    reference: str
    columns: tuple[str, str, str]
    sheet_units: tuple[str, ...]
    magnitude_key: str = ""

    @property
    def along(self) -> str:
        """Direction of its vector, in words."""
        return "along the field" if self.magnitude_key else "up"

    @property
    def prefix(self) -> str:
        """Prefix of its columns: ``acc``, ``gyr``."""
        return self.columns[0].rpartition("_")[0]

    @property
    def sd_key(self) -> str:
        """Key of the sd of that magnitude."""
        return f"sd_{self.sheet_units[0]}"


TRIAD_KINDS: dict[str, TriadKind] = {kind.name: kind for kind in (
    TriadKind("accelerometer", "accelerometer", "m/s²", "mm/s²", 1e3, "gravity",
              ("acc_x", "acc_y", "acc_z"),
              ("m_s2", "g", "mg")),
    TriadKind("gyroscope", "gyro", "rad/s", "°/s", math.degrees(1.0), "the rate of the plate",
              ("gyr_x", "gyr_y", "gyr_z"),
              ("rad_s", "deg_s", "mrad_s", "mdeg_s", "rpm")),
    TriadKind("magnetometer", "magnetometer", "µT", "nT", 1e3, "the field of the Earth",
              ("mag_x", "mag_y", "mag_z"), ("ut", "nt", "gauss", "mgauss"), "field_ut"),
)}
"""Every kind of triad by name."""


class PerKind(Mapping[str, T]):
    """One value per kind of triad, by its name; kinds may be added at any time."""

    def __init__(self, value: Callable[[TriadKind], T]) -> None:
        self._value = value

    def __getitem__(self, name: str) -> T:
        return self._value(TRIAD_KINDS[name])

    def __iter__(self) -> Iterator[str]:
        return iter(TRIAD_KINDS)

    def __len__(self) -> int:
        return len(TRIAD_KINDS)
