"""The unit of what multiplies an expression: that of the triad over the expression's own.

A unit is a product of powers of its parts, by their symbols. Numbers take the unit of what they are
added to or subtracted from; functions other than ``abs`` and ``sqrt`` have none.
"""

import ast
import re
from collections.abc import Mapping
from fractions import Fraction

from calib.effects.expression import OTHERS, VECTORS, Expression
from calib.poses.conditions import OTHER_TRIAD
from calib.poses.imu_log import SI_UNIT, Triad

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
"""Last word of a column's name -> the symbol, and of a single letter the words one of which must
stand before it: a letter alone may be an axis. Definition."""

EXPONENTS = {1: "", 2: "²", 3: "³"}  #: powers as a person writes them; others have a caret

Dimension = Mapping[str, Fraction]
"""Symbol of a unit -> its power; empty for a plain number."""


def column_unit(name: str) -> str:
    """The unit of a logged column by the end of its name.

    Parameters
    ----------
    name : str

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
    """A power of a unit; a quotient or several words stand in brackets."""
    exponent = EXPONENTS.get(power, f"^{float(power):g}")  # type: ignore[call-overload]
    return f"({symbol}){exponent}" if re.search(r"[/ ]", symbol) and (
        exponent or "/" in symbol) else symbol + exponent


def _product(one: Dimension, other: Dimension, sign: int) -> Dimension:
    powers = {**one}
    for symbol, power in other.items():
        powers[symbol] = powers.get(symbol, Fraction(0)) + sign * power
    return {symbol: power for symbol, power in powers.items() if power}


def _dimension(node: ast.expr, triad: Triad) -> Dimension | None:
    """The unit of a node; None of a number, which takes that of what it is added to.

    A sum of unlike units has that of its first part: such a parameter has no better one.
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
        case ast.Call(func=ast.Name(id="lag"), args=[column, _]):
            return _dimension(column, triad)
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
