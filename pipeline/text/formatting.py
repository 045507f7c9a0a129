"""Numbers, units and tables as people read them; everything else is in SI units."""

import math
from collections.abc import Iterable, Mapping, Sequence

from calib.earth import STANDARD_GRAVITY_M_S2
from calib.fit.rounding import with_sd as with_sd

#: Unit in which a triad's errors are shown, and how many of it one SI unit is.
DISPLAY: Mapping[str, tuple[str, float]] = {
    "accelerometer": ("mm/s²", 1000.0),
    "gyroscope": ("°/s", math.degrees(1.0)),
}
RPM = 2 * math.pi / 60  #: rad/s
NAME_WIDTH = 15  #: of a stage's name at the beginning of its line

Rows = Sequence[Sequence[str]]


def relative(value: float) -> str:
    """A relative size in the unit one would say: ppm, or per cent from 0.1 % on.

    >>> relative(1e-4), relative(2.34e-6), relative(0.0123)
    ('100 ppm', '2.3 ppm', '1.2 %')
    """
    if value >= 1e-3:
        return f"{value * 100:.2g} %"
    return f"{value * 1e6:.0f} ppm" if value >= 1e-5 else f"{value * 1e6:.2g} ppm"


def count(n: int, noun: str) -> str:
    """``1 pose``, ``18 poses``."""
    return f"{n} {noun}{'' if n == 1 else 's'}"


def short_model(names: Sequence[str]) -> str:
    """A model's name: the paper's nine parameters, and what was added to them."""
    from calib.effects.catalogue import BASE  # which `pipeline rate` never needs

    added = [f"+ {name}" for name in names if name not in BASE]
    base = [name for name in names if name in BASE]
    stem = "base" if set(base) == set(BASE) else " ".join(base)
    return " ".join([stem, *added]).strip()


def aligned(rows: Rows, indent: str = "  ") -> list[str]:
    """The rows with every column but the last padded to its width; the first column to the left."""
    widths = [max(len(row[j]) for row in rows if j < len(row)) for j in range(max(map(len, rows)))]
    return [
        (indent + "  ".join(cell.ljust(w) for cell, w in zip(row, widths, strict=False))).rstrip()
        for row in rows
    ]


# --- sizes of effects in the units of data sheets: °/s per g, mg per K, ppm ----------------------

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


def display_unit(unit: str, sizes: Iterable[float]) -> tuple[str, float]:
    """The unit in which ``sizes``, in ``unit``, are best read, and its number per ``unit``.

    Examples
    --------
    >>> display_unit("(rad/s)/(m/s²)", [2e-4])[0]
    '°/s per g'
    >>> display_unit("1/K", [2e-4])[0]
    'ppm per K'
    """
    numerator, rest = _split(unit)
    if numerator is None:
        return unit, 1.0
    finest, *coarser = NUMERATORS[numerator]
    below = rest.removeprefix("/").removeprefix(" per ")
    known, per = DENOMINATORS.get(below, (below, 1.0))
    reach = max(map(abs, sizes), default=0.0) * per
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
