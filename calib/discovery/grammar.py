"""The grammar of formulas: a factor that errs, times a function of logged columns.

    error_k = c · F_k · φ(x),    F in 1, s, s_j, |s|, s², s³, s_i s_j, f_j, s f, Ω, p, vibration

with φ of :mod:`calib.discovery.functions`; and the response of an axis itself, φ(s_k), with a
number in it. Each is an expression of :mod:`calib.effects.expression` whose unit follows by
construction, ready to be an effect of a configuration.
"""

import re
from collections.abc import Collection, Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Literal

import numpy as np

from calib.discovery.functions import LAG_RATIO, Function, functions
from calib.discovery.response import response_functions
from calib.effects.effect import Effect
from calib.effects.expression import KNOWN_NAMES, read_expression
from calib.effects.units import coefficient_unit
from calib.effects.user_defined import Per, user_effect
from calib.poses.conditions import RUN_COLUMN
from calib.poses.imu_log import SI_UNIT, Triad
from calib.poses.pose_set import PoseSet

Factor = Literal["bias", "gain", "cross", "size", "square", "cube", "others", "force",
                 "gain_by_force", "rate", "memory", "vibration"]

FACTORS: dict[Factor, tuple[str, str, int]] = {
    "bias": ("", "the bias", 0),
    "gain": ("s", "the gain", 1),
    "cross": ("s", "the gain across the axes", 2),
    "size": ("abs(s)", "an error in proportion to the size of the reading", 2),
    "square": ("s**2", "an error in proportion to the square of the reading", 2),
    "cube": ("s**3", "an error in proportion to the cube of the reading", 2),
    "others": ("others", "an error in proportion to the product of the other two axes", 2),
    "force": ("f", "the sensitivity to gravity", 2),
    "gain_by_force": ("s * f", "an error in proportion to the reading times the force",
                      2),
    "rate": ("spin_rad_s", "an error in proportion to the rate of the plate", 2),
    "memory": ("p", "the memory of the pose before", 2),
    "vibration": ("vibration", "an error in proportion to the vibration", 2),
}
"""Factor of a formula -> its expression, its words, and its length in terms. Definition."""

PERS: dict[Factor, tuple[Per, ...]] = {
    "bias": ("axis", "common"), "gain": ("axis", "common"), "cross": ("matrix",),
    "force": ("matrix",),
}
"""Factor -> how its parameters belong to the axes; one for each axis where it is not listed."""

OF_BASE: tuple[Factor, ...] = ("bias", "gain", "cross")
"""Factors that the base contains already as constants."""

CONSTANT = Function("1", "", "", 0, "")


@dataclass(frozen=True)
class Formula:
    """One formula of the grammar.

    Attributes
    ----------
    factor : str
        What errs.
    per : str
        How its parameters belong to the axes, as in an effect of a configuration.
    function : Function
    triad : str
    """

    factor: Factor
    per: Per
    function: Function
    triad: Triad

    @property
    def column(self) -> str:
        """The logged column, ``time_s`` or READING that it follows; empty where it follows none."""
        return self.function.column

    @property
    def expression(self) -> str:
        """The expression of an effect of a configuration."""
        text = FACTORS[self.factor][0]
        parts = [text, self.function.expression if self.column else ""]
        return " * ".join(part for part in parts if part)

    @property
    def words(self) -> str:
        """A sentence without its full stop: "the bias follows the square of tx_power_w"."""
        _, words, _ = FACTORS[self.factor]
        of = {"axis": " of each axis", "common": ", the same on all axes,"}.get(self.per, "")
        follows = f"follows {self.function.said}" if self.column else "is not zero"
        return f"{words}{of} {follows}"

    @property
    def name(self) -> str:
        """The name of the effect."""
        common = "common" if self.per == "common" else ""
        return "_".join(part for part in (self.factor, common, self.function.called) if part)

    @property
    def length(self) -> int:
        """Number of its terms."""
        return FACTORS[self.factor][2] + self.function.length + (self.per == "matrix")

    @cached_property
    def effect(self) -> Effect:
        """The formula as an effect."""
        read = read_expression(self.expression)
        return user_effect(self.name, read, self.per, coefficient_unit(read, self.triad),
                           self.triad)


def formulas(
    poses: PoseSet, columns: tuple[str, ...], known: Collection[Function] = ()
) -> list[Formula]:
    """Every formula of the initial grid for these poses.

    Parameters
    ----------
    poses : PoseSet
    columns : tuple of str
        The logged columns that may cause an error.
    known : collection of Function
        Functions that are tried in addition.
    """
    named = _named(columns)
    drivers = {key: poses.columns[name] for key, name in named.items()}
    if np.isfinite(poses.time_s).all():
        drivers["time_s"] = poses.time_s
    drivers = {name: values for name, values in drivers.items()
               if np.isfinite(values).all() and np.ptp(values) > 0}
    every = _spelt(functions(drivers, time_constants(poses), len(poses)), named)
    every += [one for one in known if one.column in columns]
    every += _of_runs(poses)
    of_axis = response_functions(float(np.abs(poses.reading).max()), SI_UNIT[poses.triad])
    return [Formula("bias", "axis", function, poses.triad) for function in of_axis] + [
        Formula(factor, per, function, poses.triad)
        for factor, per in known_factors(poses)
        for function in (*(() if factor in OF_BASE else (CONSTANT,)), *every)
        if _may_follow(factor, function)]


def _of_runs(poses: PoseSet) -> list[Function]:
    """What is different in one run: another clamping, or another rate than stated."""
    runs = [*dict.fromkeys(poses.run)]
    return [
        Function(f"run({name!r})".replace("{", "{{").replace("}", "}}"),
                 f"whether a pose is of the run {name}".replace("{", "{{").replace("}", "}}"),
                 f"in_{name}" if re.fullmatch("[A-Za-z0-9_]+", name) else f"in_run_{i}", 1,
                 RUN_COLUMN + name)
        for i, name in enumerate(runs, 1)
    ] if len(runs) > 1 else []


def _named(columns: Iterable[str]) -> dict[str, str]:
    """The logged columns by their form in names of effects: letters, digits and ``_``."""
    named: dict[str, str] = {}
    for name in columns:
        key = re.sub(r"[^A-Za-z0-9]+", "_", name)
        key = key if key == name and not name[:1].isdigit() else f"column_{key.strip('_')}"
        while key in named:
            key += "_"
        if name not in KNOWN_NAMES:
            named[key] = name
    return named


def _spelt(every: list[Function], named: Mapping[str, str]) -> list[Function]:
    """The functions with their columns by name, ``column('NAME')`` where that is no identifier."""
    strange = {key: name.replace("{", "{{").replace("}", "}}")
               for key, name in named.items() if key != name}
    if not strange:
        return every
    key = re.compile(rf"\b({'|'.join(strange)})\b")
    return [replace(
        one, text=key.sub(lambda part: f"column({strange[part[0]]!r})", one.text),
        words=key.sub(lambda part: strange[part[0]], one.words),
        column=named.get(one.column, one.column)) for one in every]


def _may_follow(factor: Factor, function: Function) -> bool:
    followers = {"every": True, "simple": factor in ("bias", "gain"), "bias": factor == "bias",
                 "others": factor not in ("bias", "gain")}
    return followers[function.breadth]


def known_factors(poses: PoseSet) -> Iterator[tuple[Factor, Per]]:
    """Factors and their parameters' axes, as far as these poses contain the quantities needed."""
    at = poses.conditions(poses.reading)
    for factor, (text, _, _) in FACTORS.items():
        if "force" in factor and poses.triad == "accelerometer":
            continue  # gravity is its own measurand
        if factor == "rate" and not np.ptp(poses.spin_rad_s) > 0:
            continue
        if not text or np.isfinite(read_expression(text)(at)).all():
            for per in PERS.get(factor, ("axis",)):
                yield factor, per


def time_constants(poses: PoseSet) -> list[float]:
    """Time constants that are tried in these poses, s; none where their times are not known."""
    steps = np.diff(np.unique(poses.time_s))
    if not len(steps) or not np.isfinite(steps).all():
        return []
    least, most = float(np.median(steps)), float(np.ptp(poses.time_s)) / 4
    count = int(np.log(max(most / least, 1.0)) / np.log(LAG_RATIO)) + 1
    return [least * LAG_RATIO**k for k in range(count)]
