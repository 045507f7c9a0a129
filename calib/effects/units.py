"""Errors and sizes of effects in the units that people read: mm/s², °/s, °/s per g, ppm per K.

One rule for both triads: an accelerometer's error is in mm/s² and a gyroscope's in °/s, alone and
in front of every "per"; only a gyroscope's bias under 0.01 °/s is in °/h. What an error is
relative to is in g, °/s or its own unit, a part of the reading in % or ppm.
"""

import math
import re
from collections.abc import Iterable, Mapping

from calib.earth import STANDARD_GRAVITY_M_S2
from calib.numbers import SECONDS_PER_HOUR
from calib.poses.triad_kind import TRIAD_KINDS

NUMERATORS: Mapping[str, tuple[str, float]] = {
    "rad": ("°", math.degrees(1.0)), "m": ("mm", 1e3), "1": ("%", 100.0),
}
"""SI numerator -> unit, and how many of it one SI unit is; those of readings are the triads'."""

FINER: Mapping[str, tuple[str, float]] = {"°/s": ("°/h", SECONDS_PER_HOUR), "%": ("ppm", 1e4)}
"""The unit of small sizes, and how many of it the coarser unit is."""

FINER_BELOW = 0.01
"""Size in the coarser unit below which the finer one has fewer zeros. It chooses words only."""

DENOMINATORS: Mapping[str, tuple[str, float]] = {
    "(m/s²)": ("g", STANDARD_GRAVITY_M_S2),
    "(m/s²)²": ("g²", STANDARD_GRAVITY_M_S2**2),
    "(rad/s)": ("°/s", math.radians(1.0)),
    "(rad/s)²": ("(°/s)²", math.radians(1.0) ** 2),
}
"""SI denominator -> unit, and how many SI units one of it is."""

BELOW = re.compile(r"/((?:\([^()]*\)|[^/()])+)")
"""One denominator behind the numerator, a quotient in brackets."""


def display_unit(unit: str, sizes: Iterable[float]) -> tuple[str, float]:
    """The unit in which sizes are read.

    Parameters
    ----------
    unit : str
        SI unit of the sizes.
    sizes : iterable of float
        The largest decides between a unit and its finer one.

    Returns
    -------
    tuple of (str, float)
        The unit, and how many of it one ``unit`` is.

    Examples
    --------
    >>> display_unit("(rad/s)/(m/s²)", [2e-5])[0]
    '°/s per g'
    >>> display_unit("m/s²/K", [2e-5])[0]
    'mm/s² per K'
    >>> display_unit("1/K", [2e-5])[0]
    'ppm per K'
    >>> display_unit("(rad/s)/(m/s²)/W²", [2e-5])[0]
    '°/s per g per W²'
    """
    numerator, rest = _split(unit)
    if numerator is None:
        return unit, 1.0
    name, factor = _numerators()[numerator]
    below = [rest.removeprefix(" per ")] if rest.startswith(" per ") else BELOW.findall(rest)
    read = [DENOMINATORS.get(part, (part, 1.0)) for part in below]
    known = " per ".join(name for name, _ in read)
    factor *= math.prod(per for _, per in read)
    if name in FINER and not (known and name == "°/s"):
        finer, many = FINER[name]
        if max(map(abs, sizes), default=0.0) * factor < FINER_BELOW:
            name, factor = finer, factor * many
    return (f"{name} per {known}" if known else name), factor


def _split(unit: str) -> tuple[str | None, str]:
    """The SI numerator of a unit, None where it has no known one, and what follows it."""
    for numerator in _numerators():
        for form in (f"({numerator})", numerator):
            rest = unit.removeprefix(form)
            if rest != unit and (not rest or rest.startswith(("/", " per "))):
                return numerator, rest
    return None, ""


def _numerators() -> Mapping[str, tuple[str, float]]:
    return {kind.unit: (kind.error_unit, kind.errors_per_unit)
            for kind in TRIAD_KINDS.values()} | {**NUMERATORS}
