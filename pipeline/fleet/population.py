"""Statistics of a lot from the table and the evidence of all sessions, triad by triad."""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from calib.diagnosis.population.pool import Pool, PooledEffect
from calib.diagnosis.population.random_effects import RandomEffects
from calib.diagnosis.population.repeatability import Repeatability, repeatability
from calib.diagnosis.population.spread import Spread, spread_of, weighed_together
from calib.poses.averaging.mean_noise import NOISE_DOF_PER_POSE
from calib.poses.triad_kind import TRIAD_KINDS
from pipeline.errors import DONE
from pipeline.fleet.table import PARAMETER_NAMES, column
from pipeline.results.json_values import Json, number, numbers

if TYPE_CHECKING:
    from pandas import DataFrame

POPULATION_NAME = "population.json"


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
        tuple(one for one in repeats if one.dof), pooled(triad, rows))


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


def population_json(populations: Iterable[TriadPopulation]) -> Json:
    """The same data for programs: SI units and those of results.json; null for unknown values."""
    return {one.triad: _triad_json(one) for one in populations}


def _triad_json(population: TriadPopulation) -> Json:
    pooled = population.pool
    return {
        "sensors": len(population.sensors),
        "sessions": len(population.rows),
        "copies": dict(population.copies),
        "missing": [] if pooled is None else [*map(_effect_json, pooled.effects)],
        "candidates": [] if pooled is None else [
            {"name": one.trial.name, "shape": one.trial.shape, "sessions": one.sessions,
             "p_common_size": one.p_common, "p_any_size": one.p_any}
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
        "alternatives": list(effect.alternatives), "sessions": effect.evidence.sessions,
        "p_common_size": effect.evidence.p_common, "p_any_size": effect.evidence.p_any,
        "parameters": parameters,
    }


def _effects_json(of_lot: RandomEffects) -> Json:
    mean, mean_sd, spread, spread_sd = numbers(
        [of_lot.mean, of_lot.mean_sd, of_lot.spread, of_lot.spread_sd])
    return {"mean": mean, "mean_sd": mean_sd, "spread": spread, "spread_sd": spread_sd,
            "p_same": of_lot.p_same, "sensors": of_lot.sensors}
