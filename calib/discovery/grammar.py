"""The grammar of formulas: what errs, times a function of what was logged.

    error_k = c · F_k · φ(x),    F in 1, s, s_j, |s|, s², s_i s_j, f_j, Ω, p

with x a logged column or the time, what follows a column with a time constant, or the product of
two columns, and φ a power, a bend, a step, a saturation or a decay. Each is an expression of
:mod:`calib.effects.expression` with its unit by construction, ready to be an effect of a
configuration. Numbers in it are rounded quarters of the column's range and beyond its ends.
"""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import permutations
from typing import Literal

import numpy as np

from calib.effects.effect import Effect
from calib.effects.expression import read_expression
from calib.effects.units import coefficient_unit
from calib.effects.user_defined import user_effect
from calib.poses.imu_log import FloatArray
from calib.poses.lagged import Lag
from calib.poses.pose_set import PoseSet

Factor = Literal[
    "bias", "gain", "cross", "size", "square", "others", "force", "rate", "memory"]
Per = Literal["axis", "common", "matrix"]

FACTORS: dict[Factor, tuple[str, str, int]] = {
    "bias": ("", "the bias", 0),
    "gain": ("s", "the gain", 1),
    "cross": ("s", "the gain across the axes", 2),
    "size": ("abs(s)", "an error in proportion to the size of the reading", 2),
    "square": ("s**2", "an error in proportion to the square of the reading", 2),
    "others": ("others", "an error in proportion to the product of the other two axes", 2),
    "force": ("f", "the sensitivity to gravity", 2),
    "rate": ("spin_rad_s", "an error in proportion to the rate of the plate", 2),
    "memory": ("p", "the memory of the pose before", 2),
}
"""What errs -> as a factor of an expression, in words, and its length in terms. Definition."""

SHARES = (0.125, 0.25, 0.375, 0.5, 0.625, 0.75, 0.875)
"""Shares of the poses below a step, a bend or a saturation that is tried. Numerical: any other
place is within a sixteenth of the poses of one."""

WIDTHS = (0.1, 0.3)
"""Widths of a saturation and of a decay over the column's range. Numerical, as above."""

LAG_RATIO = 2.0
"""Ratio of one time constant to the next that is tried, from the time between poses to a quarter of
the session. Numerical: any other is 0.97 correlated with one of them."""

PERS: dict[Factor, tuple[Per, ...]] = {
    "bias": ("axis", "common"), "gain": ("axis", "common"), "cross": ("matrix",),
    "force": ("matrix",),
}
"""What errs -> how its parameters belong to the axes; one for each where it is not listed."""

SIMPLE: tuple[Factor, ...] = ("bias", "gain")
"""What may follow two columns, or a column and its own past, in a way of three terms and more."""

DIGITS = 4  #: significant digits of the numbers in an expression; it chooses words only
FEWEST_VALUES = 4
"""Number of values of a column from which a curve in it can be told from a line. Derived: of three
every curve is a square."""


@dataclass(frozen=True, eq=False)
class Formula:
    """One formula of the grammar.

    Attributes
    ----------
    expression, per : str
        As an effect of a configuration has them.
    words : str
        A sentence without its end: "the bias follows the square of tx_power_w".
    name : str
        Of the effect.
    length : int
        Number of terms that it is made of.
    effect : Effect
    column : str
        The logged column or ``time_s`` that it follows, the first of two; empty where it follows
        none.
    """

    expression: str
    per: Per
    words: str
    name: str
    length: int
    effect: Effect
    column: str


@dataclass(frozen=True)
class _Function:
    text: str
    words: str
    name: str
    length: int
    every_factor: bool = True


def _functions(column: str, values: FloatArray) -> Iterator[_Function]:
    """Functions of a column about numbers of its range."""
    low, span = float(values.min()), float(np.ptp(values))
    x = f"({column} - {_number(float(np.median(values)))})"
    yield _Function(x, column, f"with_{column}", 1)
    if len(np.unique(values)) < FEWEST_VALUES:
        return
    if low >= 0:
        yield _Function(f"{column}**2", f"the square of {column}", f"with_{column}_squared", 2)
        yield _Function(f"{column}**3", f"the cube of {column}", f"with_{column}_cubed", 2)
    for place in (low - span, low - span / 2, *np.quantile(values, SHARES),
                  low + 3 * span / 2, low + 2 * span):
        at = _number(float(place))
        yield _Function(f"({column} - {at})**2", f"the square of {column} from {at}",
                        f"with_{column}_bent_{_word(at)}", 3)
    for place in np.quantile(values, SHARES):
        at = _number(float(place))
        y = f"({column} - {at})"
        yield _Function(f"abs{y}", f"the distance of {column} from {at}",
                        f"with_{column}_from_{_word(at)}", 3)
        yield _Function(f"(1 + sign{y}) / 2", f"a step where {column} passes {at}",
                        f"where_{column}_over_{_word(at)}", 3)
        for width in WIDTHS:
            wide = _number(width * span)
            yield _Function(f"tanh({y} / {wide})",
                            f"{column}, and saturates {wide} from {at}",
                            f"with_{column}_saturating_{_word(at)}_{_word(wide)}", 4)
    for width in WIDTHS:
        wide = _number(width * span)
        yield _Function(f"exp(-({column} - {_number(low)}) / {wide})",
                        f"{column}, and decays within {wide}",
                        f"with_{column}_decaying_{_word(wide)}", 3)


def _number(value: float) -> str:
    text = f"{value:.{DIGITS}g}"
    return f"{float(text):g}" if value >= 0 else f"({float(text):g})"


def _word(number: str) -> str:
    text = number.replace("-", "minus")
    return "".join(c if c.isalnum() else "_" for c in text).strip("_")


def formulas(poses: PoseSet, columns: tuple[str, ...]) -> list[Formula]:
    """Every formula that these poses can evaluate.

    Parameters
    ----------
    poses : PoseSet
    columns : tuple of str
        The logged columns that may cause an error.

    Returns
    -------
    list of Formula
    """
    drivers = {name: poses.columns[name] for name in columns if name.isidentifier()}
    if np.isfinite(poses.time_s).all():
        drivers["time_s"] = poses.time_s
    drivers = {name: values for name, values in drivers.items()
               if np.isfinite(values).all() and np.ptp(values) > 0}
    functions = [(name, f) for name, values in drivers.items() for f in _functions(name, values)]
    taus = time_constants(poses)
    functions += [(name, f) for name in drivers if name != "time_s" for f in _lagged(name, taus)]
    functions += [(one, f) for one, other in permutations(drivers, 2)
                  for f in _products(one, drivers[one], other, drivers[other])]
    every = []
    for factor, (text, words, length) in FACTORS.items():
        if not _is_known(poses, text):
            continue
        plain = [] if factor in ("bias", "gain", "cross") else [("", _Function("1", "", "", 0))]
        for column, f in (*plain, *functions):
            if not f.every_factor and factor not in SIMPLE:
                continue
            for per in PERS.get(factor, ("axis",)):
                every.append(_formula(poses, factor, text, words, length, f, column, per))
    return every


def lags(poses: PoseSet, columns: Iterable[str]) -> list[Lag]:
    """The columns with a time constant that :func:`formulas` needs ``poses`` to have."""
    return [(name, tau) for name in columns for tau in time_constants(poses)]


def time_constants(poses: PoseSet) -> list[float]:
    """The time constants that are tried in these poses, s; none where their times are not known."""
    steps = np.diff(np.unique(poses.time_s))
    if not len(steps) or not np.isfinite(steps).all():
        return []
    least, most = float(np.median(steps)), float(np.ptp(poses.time_s)) / 4
    count = int(np.log(max(most / least, 1.0)) / np.log(LAG_RATIO)) + 1
    return [float(_number(least * LAG_RATIO**k)) for k in range(count)]


def _lagged(column: str, taus: Sequence[float]) -> Iterator[_Function]:
    """Functions of what follows a column with a time constant."""
    for tau in taus:
        lag, late = f"lag({column}, {tau:g})", f"{column} with a time constant of {tau:g} s"
        name = f"with_{column}_behind_{_word(f'{tau:g}')}"
        yield _Function(lag, late, name, 2)
        yield _Function(f"{lag}**2", f"the square of {late}", f"{name}_squared", 3, False)
        yield _Function(f"({column} - {lag})", f"what {column} is ahead of itself by within "
                        f"{tau:g} s", f"with_{column}_ahead_{_word(f'{tau:g}')}", 3, False)


def _products(
    one: str, values: FloatArray, other: str, others: FloatArray
) -> Iterator[_Function]:
    """Functions of two columns: their product, and the one where the other is high or low."""
    for at in _zeros(values):
        x = _less(one, at)
        ending = f"_{_word(at)}" if at else ""
        if one < other:
            for beside in _zeros(others):
                yield _Function(
                    f"{x} * {_less(other, beside)}", f"the product of {one} and {other}",
                    f"with_{one}_times_{other}{ending}" + (f"_{_word(beside)}" if beside else ""),
                    3)
        if len(np.unique(others)) < FEWEST_VALUES:
            continue
        for place in np.quantile(others, SHARES):
            bound = _number(float(place))
            for sign, word in (("+", "over"), ("-", "under")):
                yield _Function(
                    f"{x} * (1 {sign} sign({other} - {bound})) / 2",
                    f"{one} where {other} is {word} {bound}",
                    f"with_{one}{ending}_where_{other}_{word}_{_word(bound)}", 5, False)


def _zeros(values: FloatArray) -> tuple[str, ...]:
    """From where a column counts in a product: its middle, and its own zero if that is near."""
    middle = _number(float(np.median(values)))
    return ("", middle) if 0 <= values.min() <= np.ptp(values) else (middle,)


def _less(column: str, at: str) -> str:
    return f"({column} - {at})" if at else column


def _is_known(poses: PoseSet, text: str) -> bool:
    """Whether these poses have what a factor is made of; gravity is no news to an accelerometer."""
    at = poses.conditions(poses.reading)
    if text == "f":
        return poses.triad != "accelerometer" and bool(np.isfinite(poses.force).all())
    if text == "spin_rad_s" and not np.ptp(poses.spin_rad_s) > 0:
        return False
    return not text or bool(np.isfinite(read_expression(text)(at)).all())


def _formula(
    poses: PoseSet, factor: Factor, text: str, words: str, length: int, f: _Function, column: str,
    per: Per,
) -> Formula:
    parts = [part for part in (text, f.text if column else "") if part]
    expression = " * ".join(parts)
    name = "_".join(part for part in (factor, "common" if per == "common" else "", f.name) if part)
    of = {"axis": " of each axis", "common": ", the same on all axes,", "matrix": ""}[per]
    sentence = f"{words}{of} follows {f.words}" if column else f"{words}{of} is not zero"
    read = read_expression(expression)
    effect = user_effect(name, read, per, coefficient_unit(read, poses.triad), poses.triad)
    return Formula(expression, per, sentence, name, length + f.length + (per == "matrix"),
                   effect, column)


