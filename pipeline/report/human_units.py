"""Units of data sheets: degrees per second and g instead of radians per second and m/s²."""

import math
import re

from calib.earth import STANDARD_GRAVITY_M_S2

#: Of an SI unit: what people say instead, and how many of it one SI unit is.
SAID = {
    "(rad/s)/(m/s²)²": ("°/s per g²", math.degrees(1.0) * STANDARD_GRAVITY_M_S2**2),
    "(rad/s)/(m/s²)": ("°/s per g", math.degrees(1.0) * STANDARD_GRAVITY_M_S2),
    "rad/s": ("°/s", math.degrees(1.0)),
    "m/s²": ("mm/s²", 1000.0),
    "1/K": ("ppm/K", 1e6),
    "1/h": ("ppm/h", 1e6),
    "1": ("ppm", 1e6),
    "1/(m/s²)": ("ppm per g", 1e6 * STANDARD_GRAVITY_M_S2),
    "1/(rad/s)": ("ppm per °/s", 1e6 * math.radians(1.0)),
    "1/(m/s²)²": ("ppm per g²", 1e6 * STANDARD_GRAVITY_M_S2**2),
    "1/(rad/s)²": ("ppm per (°/s)²", 1e6 * math.radians(1.0) ** 2),
    "rad": ("°", math.degrees(1.0)),
    "m": ("mm", 1000.0),
}
_ERROR = re.compile(r"^(rad/s|m/s²)(/[^(]+| per .+)$")


def human(unit: str) -> tuple[float, str]:
    """How many of the unit that people say one of ``unit`` is, and that unit.

    >>> human("rad/s/K")
    (57.29577951308232, '°/s/K')
    """
    if unit in SAID:
        said, factor = SAID[unit]
        return factor, said
    match = _ERROR.match(unit)
    if match is None:
        return 1.0, unit
    said, factor = SAID[match[1]]
    return factor, f"{said}{match[2]}"
