"""Units at the end of keys: the message for a wrong unit shows the converted value."""

import math
from collections.abc import Iterable, Mapping

from calib.earth import STANDARD_GRAVITY_M_S2
from calib.numbers import RPM

FASTEST_RPM = 1e5  #: beyond any turntable; a larger number is a slip of the keyboard

#: Ending of a key -> quantity and the factor to its SI unit.
UNITS: Mapping[str, tuple[str, float]] = {
    "m_s2": ("acceleration", 1.0),
    "m_per_s2": ("acceleration", 1.0),
    "g": ("acceleration", STANDARD_GRAVITY_M_S2),
    "mg": ("acceleration", STANDARD_GRAVITY_M_S2 * 1e-3),
    "ug": ("acceleration", STANDARD_GRAVITY_M_S2 * 1e-6),
    "cm_s2": ("acceleration", 1e-2),
    "mm_s2": ("acceleration", 1e-3),
    "mgal": ("acceleration", 1e-5),
    "rad_s": ("angular rate", 1.0),
    "deg_s": ("angular rate", math.pi / 180),
    "dps": ("angular rate", math.pi / 180),
    "deg_per_s": ("angular rate", math.pi / 180),
    "mrad_s": ("angular rate", 1e-3),
    "mdeg_s": ("angular rate", math.pi / 180e3),
    "ddeg_s": ("angular rate", math.pi / 1800),
    "cdeg_s": ("angular rate", math.pi / 18_000),
    "deg_h": ("angular rate", math.pi / 648_000),
    "rpm": ("angular rate", RPM),
    "ut": ("magnetic field", 1.0),
    "nt": ("magnetic field", 1e-3),
    "mt": ("magnetic field", 1e3),
    "gauss": ("magnetic field", 100.0),
    "mgauss": ("magnetic field", 0.1),
    "rad": ("angle", 1.0),
    "deg": ("angle", math.pi / 180),
    "m": ("length", 1.0),
    "km": ("length", 1000.0),
    "ft": ("length", 0.3048),
    "s": ("time", 1.0),
    "ms": ("time", 1e-3),
    "min": ("time", 60.0),
    "hz": ("frequency", 1.0),
    "khz": ("frequency", 1000.0),
    "ppm": ("fraction", 1e-6),
    "percent": ("fraction", 1e-2),
    "px": ("length in the frame", 1.0),
    "counts": ("reading", 1.0),
}
UNIT_WORDS = {"m_s2": "m/s²", "cm_s2": "cm/s²", "mm_s2": "mm/s²", "ug": "µg", "rad_s": "rad/s",
              "deg_s": "°/s", "mrad_s": "mrad/s", "mdeg_s": "m°/s", "ddeg_s": "0.1 °/s",
              "cdeg_s": "0.01 °/s", "deg_h": "°/h", "rpm": "rpm", "ut": "µT", "nt": "nT"}


def split_unit(key: str) -> tuple[str, str]:
    """``full_scale_m_s2`` -> ``("full_scale", "m_s2")``; the unit is empty where there is none."""
    for start in (i for i, sign in enumerate(key) if sign == "_"):
        if key[start + 1 :].lower() in UNITS:
            return key[:start], key[start + 1 :].lower()
    return key, ""


def same_quantity(wrong: str, right: Iterable[str]) -> list[str]:
    """The keys of ``right`` for the same quantity as ``wrong``, in another unit or with one."""
    stem, unit = split_unit(wrong)
    return [
        key for key in right
        if split_unit(key)[0] == stem and key != stem
        and (not unit or UNITS[unit][0] == UNITS[split_unit(key)[1]][0])
    ]


def converted(value: float, wrong: str, right: str) -> float:
    """``value`` of the key ``wrong`` in the unit of the key ``right``."""
    return value * UNITS[split_unit(wrong)[1]][1] / UNITS[split_unit(right)[1]][1]
