"""Sizes of effects in the units of data sheets: °/s per g, mg/K, ppm.

A unit is a numerator and what follows it, ``(rad/s)/(m/s²)`` or ``1/K``. Both parts are replaced by
those of :data:`NUMERATORS` and :data:`DENOMINATORS`; what is not in them stays as it is.
"""

import math
from collections.abc import Mapping

import numpy as np

from calib.earth import STANDARD_GRAVITY_M_S2
from calib.poses.imu_log import FloatArray

#: SI numerator -> units, the finest first, with how many of each one SI unit is.
NUMERATORS: Mapping[str, tuple[tuple[str, float], ...]] = {
    "rad/s": (("°/h", math.degrees(3600.0)), ("°/s", math.degrees(1.0))),
    "m/s²": (("µg", 1e6 / STANDARD_GRAVITY_M_S2), ("mg", 1e3 / STANDARD_GRAVITY_M_S2)),
    "rad": (("°", math.degrees(1.0)),),
    "m": (("mm", 1e3),),
    "1": (("ppm", 1e6), ("%", 100.0)),
}
#: SI denominator -> unit, and how many SI units one of it is.
DENOMINATORS: Mapping[str, tuple[str, float]] = {
    "(m/s²)": ("g", STANDARD_GRAVITY_M_S2),
    "(m/s²)²": ("g²", STANDARD_GRAVITY_M_S2**2),
    "(rad/s)": ("°/s", math.radians(1.0)),
    "(rad/s)²": ("(°/s)²", math.radians(1.0) ** 2),
}
FINER_BELOW = 0.01  #: of the coarser unit: then the finer one is used


def display_unit(unit: str, sizes: FloatArray) -> tuple[str, float]:
    """The unit in which ``sizes``, in ``unit``, are best read, and its number per ``unit``.

    Examples
    --------
    >>> display_unit("(rad/s)/(m/s²)", np.array([2e-4]))[0]
    '°/s per g'
    >>> display_unit("1/K", np.array([2e-4]))[0]
    'ppm per K'
    """
    numerator, rest = _split(unit)
    if numerator is None:
        return unit, 1.0
    finest, *coarser = NUMERATORS[numerator]
    below = rest.removeprefix("/").removeprefix(" per ")
    known, per = DENOMINATORS.get(below, (below, 1.0))
    reach = float(np.nanmax(np.abs(sizes), initial=0.0)) * per
    name, factor = next(
        ((each, many) for each, many in coarser if reach * many >= FINER_BELOW), finest)
    return (f"{name} per {known}" if known else name), factor * per


def _split(unit: str) -> tuple[str | None, str]:
    """The SI numerator of a unit, None if it is none of ours, and what follows it."""
    for numerator in NUMERATORS:
        for form in (f"({numerator})", numerator):
            rest = unit.removeprefix(form)
            if rest != unit and (not rest or rest.startswith(("/", " per "))):
                return numerator, rest
    return None, ""
