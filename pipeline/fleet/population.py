"""Statistics of a lot from the table and the evidence of all sessions, triad by triad.

They come as JSON for programs, and in words for the page and the terminal.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from calib.diagnosis.population.pool import FALSE_ALARM, Pool, PooledEffect
from calib.diagnosis.population.random_effects import RandomEffects
from calib.diagnosis.population.spread import (
    Repeatability,
    Spread,
    repeatability,
    spread_of,
    weighed_together,
)
from calib.diagnosis.verdict.wording import enumeration
from calib.effects.units import display_unit
from calib.poses.averaging.mean_noise import NOISE_DOF_PER_POSE
from calib.poses.triad_kind import TRIAD_KINDS
from calib.rounding import with_sd
from pipeline.errors import DONE
from pipeline.fleet.table import PARAMETER_NAMES, column
from pipeline.results.json_values import Json, number, numbers
from pipeline.text.formatting import count

if TYPE_CHECKING:
    from pandas import DataFrame


POPULATION_NAME = "population.json"
MOST_COPIES = 5  #: named in words; the JSON has all. It chooses words only


@dataclass(frozen=True, eq=False)
class TriadPopulation:
    """One triad over a lot.

    Parameters
    ----------
    triad : str
    rows : DataFrame
        Those of its sessions that were calibrated, each measurement once.
    copies : mapping of str to str
        Sessions that hold the very measurements of another one, and that one: they tell nothing
        more, and count once.
    sensors : tuple of str
        In the order of the arrays.
    spreads : tuple of Spread
        Of each parameter that was fitted.
    repeats : tuple of Repeatability
        The same over the sessions of each sensor; empty where no sensor has two.
    pool : Pool or None
        What is missing in the lot; None where no evidence is kept.
    """

    triad: str
    rows: "DataFrame"
    copies: Mapping[str, str]
    sensors: tuple[str, ...]
    spreads: tuple[Spread, ...]
    repeats: tuple[Repeatability, ...]
    pool: Pool | None

    def sessions_of(self, sensor: int) -> list[str]:
        """The names of a sensor's sessions."""
        return list(self.rows.loc[self.rows["sensor"] == self.sensors[sensor], "session"])


Pooled = Callable[[str, "DataFrame"], Pool | None]
"""The pool of a triad over the sessions of these rows."""


def populations_of(table: "DataFrame", pooled: Pooled) -> tuple[TriadPopulation, ...]:
    """Every triad that a session calibrated; ``pooled`` gives the effects that its lot lacks."""
    done = table["exit_code"] == DONE
    return tuple(_population(triad, rows, pooled) for triad in TRIAD_KINDS
                 if len(rows := table[done & (table["triad"] == triad)]))


def _population(triad: str, calibrated: "DataFrame", pooled: Pooled) -> TriadPopulation:
    rows, copies = _distinct(calibrated)
    sensor, names = rows["sensor"].factorize()
    noise_dof = NOISE_DOF_PER_POSE * column(rows, "n_poses")
    spreads, repeats = [], []
    for name in PARAMETER_NAMES:
        value = column(rows, name)
        spread = spread_of(
            name, *weighed_together(value, column(rows, f"{name}_sd"), sensor, len(names)))
        if spread is not None:
            spreads.append(spread)
            repeats.append(repeatability(
                name, value, column(rows, f"{name}_noise_sd"), noise_dof, sensor, len(names)))
    return TriadPopulation(
        triad, rows, copies, tuple(map(str, names)), tuple(spreads),
        tuple(one for one in repeats if one.dof),
        pooled(triad, rows) if sheets_of(rows) < 2 else None)


def sheets_of(rows: "DataFrame") -> int:
    """Number of data sheets of sessions; 0 in a table that does not state them."""
    return int(rows["sheet"].nunique()) if "sheet" in rows else 0


def _distinct(rows: "DataFrame") -> "tuple[DataFrame, dict[str, str]]":
    """Rows with measurements of their own; names of the others with those they repeat.

    No two measurements give the same chi-square and parameters to the last bit.
    """
    key = ["chi2", *(name for name in PARAMETER_NAMES if name in rows)]
    copied = rows.duplicated(key)
    if not copied.any():
        return rows, {}
    first = rows[~copied]
    of_first = rows[copied].merge(first[[*key, "session"]], on=key, suffixes=("", "_first"))
    return first, dict(zip(of_first["session"], of_first["session_first"], strict=True))


def population_json(population: TriadPopulation) -> Json:
    """The same data for programs: SI units and those of results.json; null for unknown values."""
    pooled = population.pool
    return {
        "sensors": len(population.sensors),
        "sessions": len(population.rows),
        "copies": dict(population.copies),
        "missing": [] if pooled is None else [*map(_effect_json, pooled.effects)],
        "candidates": [] if pooled is None else [
            {"name": one.trial.name, "shape": one.trial.shape, "sessions": one.sessions,
             "p_common_size": one.p_common, "p_any_size": one.p_any, "p_same_size": one.p_same}
            for one in pooled.candidates
        ],
        "parameters": {
            one.name: _effects_json(one.of_lot) | {
                "unlike": [population.sensors[i] for i in np.flatnonzero(one.unlike)]}
            for one in population.spreads
        },
        "repeatability": {
            one.name: {"birge_ratio": number(one.birge), "dof": one.dof,
                       "p_value": number(one.p_value),
                       "moved": [population.sensors[i] for i in np.flatnonzero(one.moved)]}
            for one in population.repeats
        },
    }


def _effect_json(effect: PooledEffect) -> Json:
    trial, sizes = effect.evidence.trial, effect.sizes
    parameters: dict[str, Any] = {
        name: None if size is None else _effects_json(size)
        for name, size in zip(trial.parameters, sizes, strict=True)
    }
    return {
        "name": effect.name, "shape": trial.shape, "unit": trial.unit,
        "alternatives": list(effect.alternatives), "only": effect.only,
        "sessions": effect.evidence.sessions,
        "p_common_size": effect.evidence.p_common, "p_any_size": effect.evidence.p_any,
        "p_same_size": effect.evidence.p_same,
        "parameters": parameters,
    }


def _effects_json(of_lot: RandomEffects) -> Json:
    mean, mean_sd, spread, spread_sd = numbers(
        [of_lot.mean, of_lot.mean_sd, of_lot.spread, of_lot.spread_sd])
    return {"mean": mean, "mean_sd": mean_sd, "spread": spread, "spread_sd": spread_sd,
            "p_same": of_lot.p_same, "sensors": of_lot.sensors}


CLEAR_SDS = 2.0
"""Size in sds from which it is quoted; derived: 95 % of a normal distribution."""


def pool_headline(population: TriadPopulation) -> str:
    """Effects that the lot lacks, by name."""
    pooled = population.pool
    if pooled is None or not pooled.effects:
        return pool_text(population)
    return f"Missing in the lot: {'; '.join(map(_named, pooled.effects))}."


def pool_text(population: TriadPopulation) -> str:
    """Effects that the lot lacks, or that it lacks none, in one paragraph."""
    pooled = population.pool
    if (sheets := sheets_of(population.rows)) > 1:
        return (f"The sessions have {sheets} different data sheets (range, bits, encoding or "
                f"unit): a count of one is none of another, and their effects are not pooled. Give "
                f"each type of sensor a pattern of its own.")
    if pooled is None:
        return "No evidence of single sessions is kept, so nothing was pooled."
    lot = f"{count(len(population.rows), 'session')} of {count(len(pooled.sensors), 'sensor')}"
    if not pooled.effects:
        return (f"Nothing is missing in the lot: the evidence of {lot}, added up, shows none of "
                f"{count(len(pooled.candidates), 'candidate')} (false alarms in "
                f"{100 * FALSE_ALARM:.0f} % of lots).")
    return f"Pooled over {lot}: " + " ".join(effect_text(effect) for effect in pooled.effects)


def p_text(p_value: float) -> str:
    """A probability as usually written.

    >>> p_text(0.25), p_text(3e-7), p_text(0.0)
    ('0.25', '3e-07', 'below 1e-300')
    """
    return f"{p_value:.2g}" if p_value > 1e-300 else "below 1e-300"


def effect_text(effect: PooledEffect) -> str:
    """One effect that the lot lacks."""
    form = (f" in sensor {effect.only} alone: without it the lot does not show it"
            if effect.only is not None else
            ", of sizes that differ between sessions" if effect.evidence.p_same < FALSE_ALARM
            else ", of one size in all sensors")
    return (f"{_named(effect)} is missing{form}, p {p_text(effect.evidence.p_value)}. "
            f"{sizes_text(effect)}")


def _named(effect: PooledEffect) -> str:
    also = f" (or {', '.join(effect.alternatives)})" if effect.alternatives else ""
    return f"'{effect.name}'{also}"


def sizes_text(effect: PooledEffect) -> str:
    """Common size and spread of the parameters that the lot shows clearly."""
    trial = effect.evidence.trial
    unit, factor = display_unit(trial.unit, [size.mean for size in effect.sizes if size])
    parts = [
        f"{name} {with_sd(factor * size.mean, factor * size.mean_sd)}{_spread(size, factor)}"
        for name, size in zip(trial.parameters, effect.sizes, strict=True)
        if size is not None and (abs(size.mean) > CLEAR_SDS * size.mean_sd or
                                 size.spread > CLEAR_SDS * size.spread_sd)
    ]
    if not parts:
        return ""
    return f"Common size and spread over the sensors, {unit}: {'; '.join(parts)}."


def _spread(size: RandomEffects, factor: float) -> str:
    if size.spread <= CLEAR_SDS * size.spread_sd:
        return ""
    return f", spread {with_sd(factor * size.spread, factor * size.spread_sd)}"


def parameter_name(name: str) -> str:
    """A column of the table in words.

    >>> parameter_name("scale_counts_per_unit_x")
    'scale x'
    """
    key, _, axis = name.rpartition("_")
    return f"{key.partition('_')[0]} {axis}"


def copies_text(population: TriadPopulation) -> str:
    """Number of sessions that repeat another one; empty where none does."""
    if not population.copies:
        return ""
    pairs = [f"'{copy}' is '{original}'" for copy, original in population.copies.items()]
    more = [f"{len(pairs) - MOST_COPIES} more"] if len(pairs) > MOST_COPIES else []
    verb = "has" if len(population.copies) == 1 else "have"
    return (f"{count(len(population.copies), 'session')} {verb} the very measurements of another "
            f"one, which count once: {enumeration([*pairs[:MOST_COPIES], *more], 'and')}.")


def is_unrepeatable(population: TriadPopulation) -> bool:
    """Whether the sessions of a sensor differ by more than their sds."""
    repeats = population.repeats
    return any(repeat.p_value * len(repeats) < FALSE_ALARM for repeat in repeats)


def repeat_text(population: TriadPopulation) -> str:
    """Whether the stated sds hold from session to session, in one sentence."""
    if not population.repeats:
        return ("No sensor has two sessions, so that nothing is known of its repeatability. "
                "It takes several folders of one sensor, as in 'lot/{sensor}/*/config.yaml'.")
    worst = max(population.repeats, key=lambda repeat: repeat.birge)
    if is_unrepeatable(population):
        return (f"Parameters differ from session to session by more than is stated: "
                f"{parameter_name(worst.name)} "
                f"by {worst.birge:.1f} times its sd (Birge ratio, {worst.dof} degrees of freedom).")
    return (f"The stated sds hold from session to session: the largest Birge ratio is "
            f"{worst.birge:.2f} ({parameter_name(worst.name)}, {worst.dof} degrees of freedom).")
