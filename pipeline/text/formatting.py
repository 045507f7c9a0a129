"""Numbers and units for people; everything else is in SI units."""

import math
from collections.abc import Mapping, Sequence

from calib.poses.triad_kind import PerKind
from calib.rounding import two_digits as two_digits
from calib.rounding import with_sd as with_sd

#: Unit in which a triad's errors are shown, and how many of it one SI unit is.
DISPLAY: Mapping[str, tuple[str, float]] = PerKind(
    lambda kind: (kind.error_unit, kind.errors_per_unit))
NAME_WIDTH = 15  #: width of a stage's name at the beginning of its line


def relative(value: float) -> str:
    """A relative size in its usual unit: ppm, or per cent from 0.1 % on.

    >>> relative(1e-4), relative(2.34e-6), relative(0.0123)
    ('100 ppm', '2.3 ppm', '1.2 %')
    """
    if value >= 1e-3:
        return f"{value * 100:.2g} %"
    return f"{value * 1e6:.0f} ppm" if value >= 1e-5 else f"{value * 1e6:.2g} ppm"


def count(n: int, noun: str) -> str:
    """``1 pose``, ``18 poses``."""
    return f"{n} {noun}{'' if n == 1 else 's'}"


def with_minus_signs(text: str) -> str:
    """``text`` with typographic minus signs in numbers.

    >>> with_minus_signs("-0.12 ± 0.03")
    '−0.12 ± 0.03'
    """
    return text.replace("-", "−")


def not_measured(
    triad: str, by_poses: float, by_unseen: Mapping[str, float], by_untold: Mapping[str, float]
) -> str:
    """Share of a predicted error that no pose determines, as the end of a clause; may be empty.

    Parameters
    ----------
    triad : str
    by_poses : float
        What the poses determine, SI.
    by_unseen : mapping of str to float
        What each effect adds that they cannot see, SI.
    by_untold : mapping of str to float
        What each effect of the model adds that another log does not tell, SI.
    """
    unit, factor = DISPLAY[triad]
    parts = [f"{two_digits(by_poses * factor)} {unit} by the poses"]
    for by_effect, why in ((by_unseen, "which they cannot see, if your sensor is typical"),
                           (by_untold, "which no other log tells")):
        if by_effect:
            largest_first = sorted(by_effect, key=lambda name: -by_effect[name])
            together = math.hypot(*by_effect.values())
            parts.append(f"{two_digits(together * factor)} {unit} by "
                         f"{' and '.join(largest_first)}, {why}")
    return f": {', '.join(parts)}" if len(parts) > 1 else ""


def short_model(names: Sequence[str]) -> str:
    """A model's name: the paper's nine parameters, and the added effects."""
    from calib.effects.catalogue import BASE  # all effects, of which a clip's rate needs none

    added = [f"+ {name}" for name in names if name not in BASE]
    base = [name for name in names if name in BASE]
    stem = "base" if set(base) == set(BASE) else " ".join(base)
    return " ".join([stem, *added]).strip()


FEWEST_LETTERS = 3  #: letters of a name that is shortened; layout


def shortened(name: str, most: int) -> str:
    """``name`` in at most so many letters, three at least, with a sign of omission."""
    most = max(most, FEWEST_LETTERS)
    return name if len(name) <= most else f"{name[: most - 1]}…"
