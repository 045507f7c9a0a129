"""A value and its standard deviation, or a span of time, rounded to significant digits."""

import math

SD_DIGITS = 2  #: significant ones of an sd and its value; it chooses digits only
FINEST = 1e-4  #: smaller numbers are shown with a power of ten; it chooses digits only

SPANS = ((100.0, 1.0, "s"), (6e3, 60.0, "min"), (2 * 86_400.0, 3600.0, "hours"),
         (99 * 86_400.0, 86_400.0, "days"), (math.inf, 365.25 * 86_400.0, "years"))
"""Up to how many seconds a unit is used, its length in seconds, and its name: layout."""


def with_sd(value: float, sd: float | None) -> str:
    """``33123.83 ± 0.25``: the sd to two digits, the value to the same decimal.

    Parameters
    ----------
    value : float
    sd : float or None
        In the unit of ``value``; without one that is finite the value stands alone.

    Examples
    --------
    >>> with_sd(33123.8274, 0.2512)
    '33123.83 ± 0.25'
    >>> with_sd(-0.0000123456, 0.0000012)
    '(-1.23 ± 0.12)e-05'
    """
    if sd is None or not math.isfinite(sd):
        return f"{value:.6g}"
    if sd <= 0:
        return f"{value:.6g} ± 0"
    if max(abs(value), sd) < FINEST:
        power = math.floor(math.log10(max(abs(value), sd)))
        return f"({with_sd(value / 10.0**power, sd / 10.0**power)})e{power:03d}"
    decimals = max(0, SD_DIGITS - 1 - math.floor(math.log10(sd)))
    return f"{value:.{decimals}f} ± {sd:.{decimals}f}"


def in_digits(value: float, count: int) -> str:
    """A size with ``count`` significant digits, without a power of ten below a million.

    >>> in_digits(0.01234, 2), in_digits(128.0, 2), in_digits(3765.0, 3)
    ('0.012', '130', '3760')
    """
    return f"{float(f'{value:.{count}g}'):g}"


def two_digits(value: float) -> str:
    """The same with two digits, as of an error."""
    return in_digits(value, 2)


def duration(seconds: float) -> str:
    """A span of time in the largest unit that leaves two digits.

    >>> duration(40.0), duration(600.0), duration(4e4), duration(3.5e6), duration(8e7)
    ('40 s', '10 min', '11 hours', '41 days', '2.5 years')
    >>> duration(math.inf)
    'ever'
    """
    for end, unit, name in SPANS:
        if seconds < end:
            return f"{two_digits(seconds / unit)} {name}"
    return "ever"
