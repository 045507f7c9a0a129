"""Units of effects: for display (mm/s², °/s), and those of an expression.

One rule for both triads: an accelerometer's error is in mm/s² and a gyroscope's in °/s, alone and
in front of every "per"; only a gyroscope's bias under 0.01 °/s is in °/h. The quantity that an
error is relative to is in g, °/s or its own unit, a fraction of the reading in % or ppm.

A unit is a product of powers of its parts, by their symbols. Numbers take the unit of what they are
added to or subtracted from; functions other than ``abs`` and ``sqrt`` have none.
"""

import ast
import math
import re
from collections.abc import Iterable, Mapping
from fractions import Fraction

from calib.earth import STANDARD_GRAVITY_M_S2
from calib.effects.expression import OTHERS, VECTORS, Expression
from calib.numbers import SECONDS_PER_HOUR
from calib.poses.conditions import OTHER_TRIAD
from calib.poses.imu_log import SI_UNIT, Triad
from calib.poses.triad_kind import TRIAD_KINDS

NUMERATORS: Mapping[str, tuple[str, float]] = {
    "rad": ("°", math.degrees(1.0)), "m": ("mm", 1e3), "1": ("%", 100.0),
}
"""SI numerator -> unit, and how many of it one SI unit is; those of readings are the triads'."""

FINER: Mapping[str, tuple[str, float]] = {"°/s": ("°/h", SECONDS_PER_HOUR), "%": ("ppm", 1e4)}
"""The unit of small sizes, and its number in the coarser unit."""

FINER_BELOW = 0.01
"""Size in the coarser unit below which the finer one is used. It chooses words only."""

DENOMINATORS: Mapping[str, tuple[str, float]] = {
    "(m/s²)": ("g", STANDARD_GRAVITY_M_S2),
    "(m/s²)²": ("g²", STANDARD_GRAVITY_M_S2**2),
    "(rad/s)": ("°/s", math.radians(1.0)),
    "(rad/s)²": ("(°/s)²", math.radians(1.0) ** 2),
}
"""SI denominator -> unit, and how many SI units one of it is."""

BELOW = re.compile(r"/((?:\([^()]*\)|[^/()])+)")
"""One denominator after the numerator; a quotient is in brackets."""


def display_unit(unit: str, sizes: Iterable[float]) -> tuple[str, float]:
    """Unit in which sizes are displayed.

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
    """SI numerator of a unit, None where it has no known one, and the rest of the unit."""
    for numerator in _numerators():
        for form in (f"({numerator})", numerator):
            rest = unit.removeprefix(form)
            if rest != unit and (not rest or rest.startswith(("/", " per "))):
                return numerator, rest
    return None, ""


def _numerators() -> Mapping[str, tuple[str, float]]:
    return {kind.unit: (kind.error_unit, kind.errors_per_unit)
            for kind in TRIAD_KINDS.values()} | {**NUMERATORS}


COLUMN_UNITS: Mapping[str, tuple[str, frozenset[str]]] = {
    "c": ("K", frozenset({"temperature", "temp", "tmp", "die", "board", "ambient"})),
    "k": ("K", frozenset({"temperature", "temp", "tmp", "die", "board", "ambient"})),
    "w": ("W", frozenset({"power"})),
    "v": ("V", frozenset({"supply", "voltage", "battery", "vdd", "vcc", "vbat", "bus"})),
    "a": ("A", frozenset({"current"})),
    "s": ("s", frozenset({"time", "age", "uptime", "delay"})),
    **{word: (symbol, frozenset()) for word, symbol in (
        ("degc", "K"), ("celsius", "K"), ("kelvin", "K"), ("mw", "mW"), ("mv", "mV"),
        ("volts", "V"), ("ma", "mA"), ("pct", "%"), ("percent", "%"), ("pa", "Pa"),
        ("hpa", "hPa"), ("kpa", "kPa"), ("mbar", "mbar"), ("rpm", "rpm"), ("hz", "Hz"),
        ("khz", "kHz"), ("ms", "ms"), ("lux", "lx"))},
}
"""Last word of a column's name -> the symbol, and for a single letter the words one of which must
precede it: a letter alone may be an axis. Definition."""

EXPONENTS = {1: "", 2: "²", 3: "³"}  #: powers as they are usually written; others have a caret

Dimension = Mapping[str, Fraction]
"""Symbol of a unit -> its power; empty for a plain number."""


def column_unit(name: str) -> str:
    """The unit of a logged column by the end of its name.

    Returns
    -------
    str
        Of a temperature that of its differences; of a name that tells none ``unit of NAME``.

    Examples
    --------
    >>> column_unit("tx_power_w"), column_unit("temperature_c"), column_unit("fan")
    ('W', 'K', 'unit of fan')
    """
    *before, last = name.lower().split("_")
    symbol, words = COLUMN_UNITS.get(last, ("", frozenset()))
    known = symbol and before and (not words or words & {*before})
    return symbol if known else f"unit of {name}"


def coefficient_unit(expression: Expression, triad: Triad) -> str:
    """The unit of the parameters of an effect whose error is a parameter times an expression.

    Parameters
    ----------
    expression : Expression
        Without shape parameters.
    triad : str

    Returns
    -------
    str
        SI where the triad or the bench is meant, else the column's own.

    Examples
    --------
    >>> from calib.effects.expression import read_expression
    >>> [coefficient_unit(read_expression(text), "gyroscope")
    ...  for text in ("f", "s", "tx_power_w**2", "s * (temperature_c - 30)", "exp(-time_s / 60)")]
    ['(rad/s)/(m/s²)', '1', '(rad/s)/W²', '1/K', 'rad/s']
    """
    below = _dimension(expression.tree, triad)
    powers = _product({SI_UNIT[triad]: Fraction(1)}, below or {}, -1)
    above = [_symbol(symbol, power) for symbol, power in powers.items() if power > 0]
    under = [_symbol(symbol, -power) for symbol, power in powers.items() if power < 0]
    if len(above) == 1 and not under:
        return above[0].removeprefix("(").removesuffix(")")
    return "/".join(["·".join(above) or "1", *under])


def _symbol(symbol: str, power: Fraction) -> str:
    """A power of a unit; a quotient or several words are in brackets."""
    exponent = EXPONENTS.get(power, f"^{float(power):g}")  # type: ignore[call-overload]
    return f"({symbol}){exponent}" if re.search(r"[/ ]", symbol) and (
        exponent or "/" in symbol) else symbol + exponent


def _product(one: Dimension, other: Dimension, sign: int) -> Dimension:
    powers = {**one}
    for symbol, power in other.items():
        powers[symbol] = powers.get(symbol, Fraction(0)) + sign * power
    return {symbol: power for symbol, power in powers.items() if power}


def _dimension(node: ast.expr, triad: Triad) -> Dimension | None:
    """Unit of a node; None for a number, which takes the unit of the other term.

    A sum of different units has that of its first part: such a parameter has no better one.
    """
    match node:
        case ast.Constant() | ast.Name(id="pi"):
            return None
        case ast.Name(id=name):
            return _unit_of_name(name, triad)
        case ast.UnaryOp(operand=operand):
            return _dimension(operand, triad)
        case ast.BinOp(left=left, op=ast.Pow(), right=right):
            inside, power = _dimension(left, triad), Fraction(str(ast.literal_eval(right)))
            return None if inside is None else {s: p * power for s, p in inside.items() if power}
        case ast.BinOp(left=left, op=operator, right=right):
            one, other = _dimension(left, triad), _dimension(right, triad)
            if isinstance(operator, ast.Add | ast.Sub):
                return one if one is not None else other
            if one is None and other is None:
                return None
            return _product(one or {}, other or {}, -1 if isinstance(operator, ast.Div) else 1)
        case ast.Call(func=ast.Name(id="abs"), args=[argument]):
            return _dimension(argument, triad)
        case ast.Call(func=ast.Name(id="lag" | "play"), args=[driver, _]):
            return _dimension(driver, triad)
        case ast.Call(func=ast.Name(id="total"), args=[driver]):
            return _product(_dimension(driver, triad) or {}, {"s": Fraction(1)}, 1)
        case ast.Call(func=ast.Name(id="sqrt"), args=[argument]):
            inside = _dimension(argument, triad)
            return None if inside is None else {s: p / 2 for s, p in inside.items()}
    return {}


def _unit_of_name(name: str, triad: Triad) -> Dimension:
    here, force = SI_UNIT[triad], SI_UNIT["accelerometer"]
    if name == OTHERS:
        return {here: Fraction(2)}
    if name == "vibration":
        return {force: Fraction(2)}
    if VECTORS.get(name, ("", None))[0] in ("vector", "previous") or name == "magnitude":
        symbol = here
    elif name in VECTORS:
        symbol = force
    elif name in OTHER_TRIAD:
        symbol = SI_UNIT["gyroscope"] if triad == "accelerometer" else force
    else:
        symbol = {"time_s": "s", "spin_rad_s": SI_UNIT["gyroscope"]}.get(name) or column_unit(name)
    return {symbol: Fraction(1)}
