"""The grammar of formulas: what errs, times a function of what was logged.

    error_k = c · F_k · φ(x),    F in 1, s, |s|, s², f_j, p,    x a logged column or the time

Each is an expression of :mod:`calib.effects.expression` with its unit by construction, ready to be
an effect of a configuration. Numbers in it are rounded ends and quarters of the column's range.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal

import numpy as np

from calib.effects.effect import Effect
from calib.effects.expression import read_expression
from calib.effects.expression_units import coefficient_unit
from calib.effects.user_defined import user_effect
from calib.poses.imu_log import FloatArray
from calib.poses.pose_set import PoseSet

Factor = Literal["bias", "gain", "size", "square", "force", "memory"]

FACTORS: dict[Factor, tuple[str, str, int]] = {
    "bias": ("", "the bias", 0),
    "gain": ("s", "the gain", 1),
    "size": ("abs(s)", "an error in proportion to the size of the reading", 2),
    "square": ("s**2", "an error in proportion to the square of the reading", 2),
    "force": ("f", "the sensitivity to gravity", 2),
    "memory": ("p", "the memory of the pose before", 2),
}
"""What errs -> as a factor of an expression, in words, and its length in terms. Definition."""

SHARES = (0.125, 0.25, 0.375, 0.5, 0.625, 0.75, 0.875)
"""Shares of the poses below a step, a bend or a saturation that is tried. Numerical: any other
place is within a sixteenth of the poses of one."""

WIDTHS = (0.1, 0.3)
"""Widths of a saturation and of a decay over the column's range. Numerical, as above."""

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
        The logged column or ``time_s`` that it follows; empty where it follows none.
    """

    expression: str
    per: Literal["axis", "common", "matrix"]
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
    every = []
    for factor, (text, words, length) in FACTORS.items():
        if not _is_known(poses, text):
            continue
        kinds: tuple[Literal["axis", "common", "matrix"], ...] = ("axis",)
        if factor == "force":
            kinds = ("matrix",)
        elif factor in ("gain", "bias"):
            kinds = ("axis", "common")
        plain = _Function("1", "", "", 0)
        for column, values in {"": np.zeros(0), **drivers}.items():
            if column and not (np.isfinite(values).all() and np.ptp(values) > 0):
                continue
            for f in _functions(column, values) if column else (plain,):
                if not column and factor in ("bias", "gain"):
                    continue  # that is the base
                for per in kinds:
                    every.append(_formula(poses, factor, text, words, length, f, column, per))
    return every


def _is_known(poses: PoseSet, text: str) -> bool:
    """Whether these poses have what a factor is made of; gravity is no news to an accelerometer."""
    at = poses.conditions(poses.reading)
    if text == "f":
        return poses.triad != "accelerometer" and bool(np.isfinite(poses.force).all())
    return not text or bool(np.isfinite(read_expression(text)(at)).all())


def _formula(
    poses: PoseSet, factor: Factor, text: str, words: str, length: int, f: _Function, column: str,
    per: Literal["axis", "common", "matrix"],
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


