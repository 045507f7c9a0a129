"""Functions φ of logged columns, by families: a bend, a step, a bump, a wave, a lag, a play.

    φ(x) with x a logged column, the time, a product or quotient of two, or a function of one's past

A family is an expression with numbers in it. Those tried first are a coarse grid over the range of
the column; :meth:`Function.finer` gives the neighbours at a part of its steps.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import permutations
from typing import Literal

import numpy as np

from calib.diagnosis.hypotheses.columns import words_of
from calib.poses.imu_log import FloatArray

Breadth = Literal["every", "simple", "bias", "others"]
"""Factors that a function may multiply: any, a bias or a gain, a bias alone, or all but these two.
"""

SHARES = (0.125, 0.25, 0.375, 0.5, 0.625, 0.75, 0.875)
"""Shares of the poses below a step, a bend, a bump or a saturation that is tried. Numerical: any
other place is within a sixteenth of the poses of one."""

WIDTHS = (0.1, 0.3)
"""Widths of a saturation, a bump or a decay, and distances of a pole, over the column's range.
Numerical: any other between 0.06 and 0.5 is within a factor of 1.7 of one."""

PLAYS = (0.01, 0.1, 0.25)
"""Half widths of a play over the column's range; the least shows the direction in which the column
last moved. Numerical, as above."""

LAG_RATIO = 2.0
"""Ratio of one time constant to the next that is tried, from the time between poses to a quarter of
the session. Numerical: any other is 0.97 correlated with one of them."""

MOST_WAVES = 24  #: half waves over a column's range; a limit of time
POSES_PER_WAVE = 6
"""Poses for each half wave that is tried. Derived: a wave has a period, a phase and a size on each
axis; with that many parameters in one half wave it would fit any poses."""

PHASES = (0.0, 0.7854, 1.571, 2.356)
"""Phases of a wave, rad. Numerical: with either sign any other is within 22.5°."""

HARMONICS = (1, 2, 3)  #: times per turn of an angle; a judgement
TURNS = {"deg": "pi / 180 * ", "degrees": "pi / 180 * ", "rad": "", "radians": ""}
"""Last word of the name of a column that is an angle -> its factor to radians. Definition."""

DIGITS = 4  #: significant digits of the numbers in an expression; it chooses words only
FEWEST_VALUES = 4
"""Number of values of a column from which a curve in it can be told from a line. Derived: with
three, every curve is a square."""


@dataclass(frozen=True)
class Function:
    """One function of logged columns.

    Attributes
    ----------
    text, words, name : str
        Templates of expression, argument in words, and name, with ``{0}`` for a number.
    length : int
        Number of terms that it is made of.
    column : str
        The logged column, ``time_s`` or the reading that it follows, the first of two.
    breadth : str
    numbers : tuple of float
    steps : tuple of float
        From each number to the next of the grid: above zero a ratio, below zero minus a distance,
        zero where it is not varied.
    """

    text: str
    words: str
    name: str
    length: int
    column: str
    breadth: Breadth = "every"
    numbers: tuple[float, ...] = ()
    steps: tuple[float, ...] = ()

    @property
    def expression(self) -> str:
        """The expression with its numbers."""
        return self.text.format(*map(_number, self.numbers))

    @property
    def said(self) -> str:
        """The argument of the function, in words."""
        return self.words.format(*(_number(value).strip("()") for value in self.numbers))

    @property
    def called(self) -> str:
        """A part of a name of an effect."""
        return self.name.format(*(_word(_number(value)) for value in self.numbers))

    @property
    def varied(self) -> int:
        """Number of its numbers that are varied."""
        return sum(step != 0 for step in self.steps)

    def finer(self, share: float) -> Iterator["Function"]:
        """The functions with one number changed by ``share`` of its step, either way."""
        for k, step in enumerate(self.steps):
            for sign in (-1, 1):
                if step == 0:
                    continue
                value = self.numbers[k]
                value = value * step ** (sign * share) if step > 0 else value - sign * share * step
                yield replace(
                    self, numbers=(*self.numbers[:k], float(value), *self.numbers[k + 1 :]))


def functions(
    drivers: Mapping[str, FloatArray], time_constants: Sequence[float], count: int
) -> list[Function]:
    """Every function of the initial grid.

    Parameters
    ----------
    drivers : mapping of str to array, shape (n,)
        The logged columns that vary, and ``time_s``.
    time_constants : sequence of float
        Tried values, s; none where the order of the poses is not known.
    count : int
        Number of poses.
    """
    every: list[Function] = []
    for column, values in drivers.items():
        every += _of_column(column, values, count)
        if column != "time_s" and time_constants:
            every += _of_past(column, values, time_constants)
    for one, other in permutations(drivers, 2):
        every += _of_two(one, drivers[one], other, drivers[other])
    return every


def _of_column(column: str, values: FloatArray, count: int) -> Iterator[Function]:
    """Functions of a column, with numbers from its range."""
    low, span = float(values.min()), float(np.ptp(values))
    x, far = f"({column} - {{0}})", -span / 8
    yield Function(x, column, f"with_{column}", 1, column,
                   numbers=(float(np.median(values)),), steps=(0.0,))
    if "" in _zeros(values):  # bias and gain contain its value at the middle of the range
        yield Function(column, f"{column} from its zero", f"with_{column}_from_zero", 1, column,
                       "others")
    angle = TURNS.get((words_of(column) or ("",))[-1])
    if angle is not None:
        for turns in HARMONICS:
            for phase in PHASES:
                yield Function(
                    f"sin({{0}} * {angle}{column} + {{1}})",
                    f"a wave in {column}, {{0}} per turn", f"with_wave_{{0}}_of_{column}_{{1}}", 2,
                    column, "simple", (turns, phase), (0.0, -np.pi / 4))
    if len(np.unique(values)) < FEWEST_VALUES:
        return
    if low >= 0:
        yield Function(f"{column}**2", f"the square of {column}", f"with_{column}_squared", 2,
                       column)
        yield Function(f"{column}**3", f"the cube of {column}", f"with_{column}_cubed", 2, column)
        yield Function(f"sqrt({column})", f"the root of {column}", f"with_root_of_{column}", 2,
                       column)
    places = [float(place) for place in np.quantile(values, SHARES)]
    beyond = (low - span, low - span / 2, low + 3 * span / 2, low + 2 * span)
    for place in (*places, *beyond):
        yield Function(f"{x}**2", f"the square of {column} from {{0}}", f"with_{column}_bent_{{0}}",
                       3, column, numbers=(place,), steps=(far,))
    for place in places:
        yield Function(f"abs{x}", f"the distance of {column} from {{0}}",
                       f"with_{column}_from_{{0}}", 3, column, "every", (place,), (far,))
        yield Function(f"(1 + sign{x}) / 2", f"a step where {column} passes {{0}}",
                       f"where_{column}_over_{{0}}", 3, column, "every", (place,), (far,))
        for sign, word in (("+", "over"), ("-", "under")):
            yield Function(f"(abs{x} {sign} {x}) / 2", f"what {column} is {word} {{0}}",
                           f"with_{column}_{word}_{{0}}", 3, column, "simple", (place,), (far,))
        for width in WIDTHS:
            wide = (place, width * span)
            yield Function(f"tanh({x} / {{1}})", f"{column}, and saturates {{1}} from {{0}}",
                           f"with_{column}_saturating_{{0}}_{{1}}", 4, column, "every", wide,
                           (far, 2.0))
            yield Function(f"1 / (1 + ({x} / {{1}})**2)",
                           f"a resonance where {column} is {{0}}, {{1}} wide on either side",
                           f"with_{column}_near_{{0}}_{{1}}", 4, column, "simple", wide,
                           (far, 2.0))
    for place in places[1:-1:2]:
        for width in WIDTHS:
            yield Function(f"({x} - (abs({x} + {{1}}) - abs({x} - {{1}})) / 2)",
                           f"what {column} is off {{0}} by more than {{1}}",
                           f"with_{column}_off_{{0}}_{{1}}", 4, column, "simple",
                           (place, width * span), (far, 2.0))
    for width in WIDTHS:
        yield Function(f"exp(-{x} / {{1}})", f"{column}, and decays within {{1}}",
                       f"with_{column}_decaying_{{1}}", 3, column,
                       numbers=(low, width * span), steps=(0.0, 2.0))
        yield Function(f"exp({x} / {{1}})", f"{column}, and grows e-fold within {{1}}",
                       f"with_{column}_growing_{{1}}", 3, column, "simple",
                       (low + span, width * span), (0.0, 2.0))
        for pole in (low - width * span, low + (1 + width) * span):
            yield Function(f"1 / {x}", f"the inverse of {column} from {{0}}",
                           f"with_inverse_of_{column}_{{0}}", 3, column, "simple",
                           (pole,), (-width * span / 2,))
    for halves in range(1, min(MOST_WAVES, count // POSES_PER_WAVE) + 1):
        for phase in PHASES:
            yield Function(f"sin(2 * pi * {x} / {{1}} + {{2}})",
                           f"a wave in {column} of period {{1}}",
                           f"with_wave_in_{column}_{{1}}_{{2}}", 4, column, "bias",
                           (float(np.median(values)), 2 * span / halves, phase),
                           (0.0, (halves + 1) / halves, -np.pi / 4))


def _of_past(
    column: str, values: FloatArray, time_constants: Sequence[float]
) -> Iterator[Function]:
    """Functions of a column's past."""
    span, places = float(np.ptp(values)), np.quantile(values, SHARES)
    several = len(np.unique(values)) >= FEWEST_VALUES
    for tau in time_constants:
        at, next_to = (tau,), (LAG_RATIO,)
        lag, late = f"lag({column}, {{0}})", f"{column} with a time constant of {{0}} s"
        name = f"{column}_behind_{{0}}"
        yield Function(lag, late, f"with_{name}", 2, column, "every", at, next_to)
        yield Function(f"({column} - {lag})", f"with a time constant of {{0}} s, how far {column} "
                       f"has moved lately", f"with_{column}_ahead_{{0}}", 3, column, "simple", at,
                       next_to)
        if not several:
            continue
        yield Function(f"lag({column}**2, {{0}})", f"the square of {column}, and that with a time "
                       f"constant of {{0}} s", f"with_square_of_{name}", 3, column, "simple", at,
                       next_to)
        yield Function(f"{lag}**2", f"the square of {late}", f"with_{name}_squared", 3, column,
                       "simple", at, next_to)
        for place in places[1:-1:2]:
            both, apart = (tau, float(place)), (LAG_RATIO, -span / 8)
            yield Function(f"(1 + sign({lag} - {{1}})) / 2", f"a step where {late} passes {{1}}",
                           f"where_{name}_over_{{1}}", 4, column, "simple", both, apart)
            yield Function(f"lag((1 + sign({column} - {{1}})) / 2, {{0}})",
                           f"a step where {column} passes {{1}}, and that with a time constant "
                           f"of {{0}} s", f"with_step_of_{name}_over_{{1}}", 4, column, "simple",
                           both, apart)
    for width in PLAYS if several else ():
        at, next_to = (width * span,), (2.0,)
        yield Function(f"play({column}, {{0}})", f"{column} with a play of {{0}} either way",
                       f"with_play_of_{column}_{{0}}", 3, column, "simple", at, next_to)
        yield Function(f"({column} - play({column}, {{0}}))",
                       f"the way that {column} last went, within {{0}}",
                       f"with_way_of_{column}_{{0}}", 3, column, "simple", at, next_to)
    yield Function(f"total({column})", f"the total of {column} so far", f"with_total_of_{column}",
                   2, column, "simple")


def _of_two(
    one: str, values: FloatArray, other: str, others: FloatArray
) -> Iterator[Function]:
    """Functions of two columns: product, quotient, and one where the other is high or low."""
    if np.abs(others).min() > 0 and np.sign(others).min() == np.sign(others).max():
        yield Function(f"{one} / {other}", f"{one} over {other}", f"with_{one}_over_{other}", 3,
                       one, "simple")
    for at in _zeros(values):
        x = f"({one} - {at})" if at else one
        ending = f"_{_word(at)}" if at else ""
        if one < other:
            for beside in _zeros(others):
                y = f"({other} - {beside})" if beside else other
                yield Function(f"{x} * {y}", f"the product of {one} and {other}",
                               f"with_{one}_times_{other}{ending}"
                               + (f"_{_word(beside)}" if beside else ""), 3, one)
        if len(np.unique(others)) < FEWEST_VALUES:
            continue
        for place in np.quantile(others, SHARES):
            for sign, word in (("+", "over"), ("-", "under")):
                yield Function(f"{x} * (1 {sign} sign({other} - {{0}})) / 2",
                               f"{one} where {other} is {word} {{0}}",
                               f"with_{one}{ending}_where_{other}_{word}_{{0}}", 5, one, "simple",
                               (float(place),), (-float(np.ptp(others)) / 8,))


def _zeros(values: FloatArray) -> Iterable[str]:
    """Origins of a column in a product: its middle, and its own zero if that is near."""
    middle = _number(float(np.median(values)))
    return ("", middle) if 0 <= values.min() <= np.ptp(values) else (middle,)


def _number(value: float) -> str:
    text = f"{value:.{DIGITS}g}"
    return f"{float(text):g}" if value >= 0 else f"({float(text):g})"


def _word(number: str) -> str:
    text = number.replace("-", "minus")
    return "".join(c if c.isalnum() else "_" for c in text).strip("_")
