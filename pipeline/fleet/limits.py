"""Pass and fail of a lot: limits on columns of its table, with a guard band of their sds.

A value passes if it is within the limit by more than its uncertainty, fails if it is beyond by
more, and is undecided in between (ISO/IEC 17025, 7.8.6: the rule is stated with the result).
"""

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from math import isfinite
from pathlib import Path
from statistics import NormalDist
from typing import TYPE_CHECKING, Any

from calib.diagnosis.verdict.decision import Code
from calib.effects.catalogue import UnknownEffect, find_effect
from calib.poses.imu_log import AXES
from calib.poses.triad_kind import TRIAD_KINDS
from calib.rounding import with_sd
from pipeline.config.yaml_text import YamlSource, read_source
from pipeline.errors import DONE, ConfigError
from pipeline.fleet.table import MISFIT, SIZE, SIZE_SD, column
from pipeline.text.names import nearest_name

if TYPE_CHECKING:
    from pandas import DataFrame

WRONG = "wrong"  #: key of the share of values at a limit that may pass although they are beyond
USUAL_WRONG = 0.05
"""Share of sensors exactly at a limit that pass, or fail, wrongly. Chosen: as decision rules do."""
BOUNDS = ("min", "max")
PASS, FAIL, OPEN = "pass", "fail", "undecided"
UNNAMED = (MISFIT, Code.UNKNOWN, Code.REFUSED)  #: verdicts that leave open what is missing


@dataclass(frozen=True)
class ColumnLimit:
    """Bounds of one column of one triad; NaN where there is none."""

    triad: str
    column: str
    low: float
    high: float


@dataclass(frozen=True)
class Limits:
    """A file of limits: each of them, and how many sds the guard band is."""

    limits: tuple[ColumnLimit, ...]
    guard_sds: float


def read_limits(path: Path) -> Limits:
    """Read a file of limits.

    Raises
    ------
    ConfigError
        It is no YAML, or has a key or a value that is none of a limit; with its line.
    """
    source = read_source(path)
    wrong = source.values.get(WRONG, USUAL_WRONG)
    if not isinstance(wrong, int | float) or not 0 < wrong <= 0.5:
        raise ConfigError(source.problem((WRONG,), "a share between 0 and 0.5 is expected."))
    limits: list[ColumnLimit] = []
    for triad, columns in source.values.items():
        if triad == WRONG:
            continue
        if triad not in TRIAD_KINDS or not isinstance(columns, Mapping):
            raise ConfigError(source.problem((triad,), (
                f"a triad with limits is expected, or `{WRONG}`"
                f"{nearest_name(triad, [*TRIAD_KINDS, WRONG])}.")))
        limits += [_limit(source, triad, name, bounds) for name, bounds in columns.items()]
    if not limits:
        raise ConfigError(f"{path}: states no limit. Write for example:\ngyroscope:\n"
                          f"  scale_counts_per_unit: {{min: 7300, max: 7700}}")
    return Limits(tuple(limits), NormalDist().inv_cdf(1 - wrong))


def _limit(source: YamlSource, triad: str, name: str, bounds: Any) -> ColumnLimit:
    where = (triad, name)
    if not isinstance(bounds, Mapping) or not bounds or {*bounds} - {*BOUNDS}:
        raise ConfigError(source.problem(where, "`{min: ..., max: ...}` is expected, or one of "
                                                "the two."))
    low, high = (bounds.get(key, float("nan")) for key in BOUNDS)
    for key in bounds:
        if not isinstance(bounds[key], int | float) or not isfinite(bounds[key]):
            raise ConfigError(source.problem((*where, key), "a number is expected."))
    if low >= high:
        raise ConfigError(source.problem(where, f"min {low:g} is not below max {high:g}."))
    return ColumnLimit(triad, name, float(low), float(high))


def with_limits(table: "DataFrame", limits: Limits) -> "DataFrame":
    """The table with a column ``limits``: pass, undecided or fail, and at which limit.

    Raises
    ------
    ConfigError
        A limit is of a column that the table does not have.
    """
    stated = []
    group = table["group"].fillna("") if "group" in table else [""] * len(table)
    open_to = [(verdict, names.split()) for verdict, names in
               zip(table["verdict"], group, strict=True)]
    for limit in limits.limits:
        for name in _columns(table, limit):
            value, sd = column(table, name), column(table, f"{name}_sd")
            if name.startswith(f"{SIZE}_"):  # the largest parameter, whatever its sign
                value, sd = abs(value), column(table, name.replace(SIZE, SIZE_SD, 1))
            stated.append((limit, name, value, sd))
    judged, triads = [], {limit.triad for limit in limits.limits}
    calibrated = table.groupby("session")["triad"].agg(set)
    for i, (session, code, triad) in enumerate(
            zip(table["session"], table["exit_code"], table["triad"], strict=True)):
        told = [_judged(limit, name, value[i], sd[i], limits.guard_sds, *open_to[i])
                for limit, name, value, sd in stated if limit.triad == triad]
        told += [(FAIL, f"the {other} is not calibrated")
                 for other in sorted(triads - calibrated[session])]
        worst = next((standing for standing in (FAIL, OPEN)
                      if any(one == standing for one, _ in told)), PASS)
        what = "; ".join(text for standing, text in told if standing == worst and text)
        judged.append(f"{FAIL}: not calibrated" if code != DONE else
                      f"{worst}: {what}" if what else worst if told else "")
    return table.assign(limits=judged)


def _columns(table: "DataFrame", limit: ColumnLimit) -> list[str]:
    """The column of a limit, or the three of its axes; one of an effect may be in no session."""
    axes = [f"{limit.column}_{axis}" for axis in AXES]
    if limit.column in table:
        return [limit.column]
    if limit.column.startswith(f"{SIZE}_"):
        try:
            find_effect(limit.column.removeprefix(f"{SIZE}_"))
        except UnknownEffect as error:
            raise ConfigError(f"limits: {limit.triad}.{limit.column}: {error}, and no row of the "
                              "table has a size of it. Correct the name.") from error
        return [limit.column]
    if axes[0] in table:
        return axes
    numeric = [name for name in table.columns if table[name].dtype.kind in "fi"]
    raise ConfigError(f"limits: {limit.triad}.{limit.column}: the table has no such column"
                      f"{nearest_name(limit.column, numeric)}. fleet.csv shows their names.")


def _judged(
    limit: ColumnLimit, name: str, value: float, sd: float, guard: float,
    verdict: str, group: Sequence[str],
) -> tuple[str, str]:
    """Whether one value passes, and a message if it does not.

    An effect without a size passes, unless the verdict leaves open that it is what is missing.
    """
    if not isfinite(value):
        if not name.startswith(f"{SIZE}_"):
            return OPEN, f"{name} is not known"
        if verdict in UNNAMED or name.removeprefix(f"{SIZE}_") in group:
            return OPEN, f"{name} is not known, and the verdict does not exclude it"
        return PASS, ""
    band = guard * sd if isfinite(sd) else 0.0
    over = max((value - limit.high) if isfinite(limit.high) else -float("inf"),
               (limit.low - value) if isfinite(limit.low) else -float("inf"))
    if over <= -band:
        return PASS, ""
    bound = limit.high if isfinite(limit.high) and value - limit.high == over else limit.low
    shown = with_sd(value, sd) if band else f"{value:.4g}"
    side = "above" if bound == limit.high else "below"
    if over > band:
        return FAIL, f"{name} {shown} is {side} {bound:g}"
    return OPEN, f"{name} {shown} is within its uncertainty of {bound:g}"


def limit_lines(table: "DataFrame") -> Iterator[str]:
    """Numbers of rows that pass and names of those that do not, for the terminal and the page."""
    if "limits" not in table:
        return
    stated = [text for text in table["limits"] if text]
    counts = Counter(text.partition(":")[0] for text in stated)
    yield "limits: " + ", ".join(f"{counts[word]} {word}" for word in (PASS, OPEN, FAIL)
                                 if counts[word])
    for session, triad, text in zip(table["session"], table["triad"], table["limits"], strict=True):
        if text and not text.startswith(PASS):
            yield f"  {session} {triad}: {text}"
