"""What the table and the evidence of all sessions show of a lot, triad by triad."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, partial
from pathlib import Path
from typing import Any

import numpy as np

from calib.diagnosis.population.evidence import Evidence
from calib.diagnosis.population.lot import AT_ONCE, LotEvidence
from calib.diagnosis.population.pool import Pool, PooledEffect, pool
from calib.diagnosis.population.random_effects import RandomEffects
from calib.diagnosis.population.repeatability import Repeatability, repeatability
from calib.diagnosis.population.spread import Spread, spread_of, weighed_together
from calib.poses.averaging.mean_noise import NOISE_DOF_PER_POSE
from calib.poses.imu_log import AXES, TRIADS, FloatArray
from pipeline.fleet.record import evidence_path, kept_evidence
from pipeline.fleet.rows import Row
from pipeline.results.json_values import Json, number, numbers
from pipeline.results.names import PARAMETERS
from pipeline.results.units import unit_of

POPULATION_NAME = "population.json"


@dataclass(frozen=True, eq=False)
class TriadPopulation:
    """One triad over a lot.

    Parameters
    ----------
    triad : str
    rows : sequence of Row
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
    rows: Sequence[Row]
    copies: Mapping[str, str]
    sensors: tuple[str, ...]
    spreads: tuple[Spread, ...]
    repeats: tuple[Repeatability, ...]
    pool: Pool | None

    def sessions_of(self, sensor: int) -> list[str]:
        """The names of a sensor's sessions."""
        return self._sessions.get(self.sensors[sensor], [])

    @cached_property
    def _sessions(self) -> dict[str, list[str]]:
        sessions: dict[str, list[str]] = {}
        for row in self.rows:
            sessions.setdefault(row["sensor"], []).append(row["session"])
        return sessions


def populations_of(rows: Sequence[Row], output: Path) -> tuple[TriadPopulation, ...]:
    """Every triad of which a session was calibrated; the evidence stands in ``output``."""
    populations = []
    for triad in TRIADS:
        calibrated = [row for row in rows if row["triad"] == triad and row["exit_code"] == 0]
        if calibrated:
            populations.append(_population(triad, calibrated, output))
    return tuple(populations)


def _population(triad: str, calibrated: Sequence[Row], output: Path) -> TriadPopulation:
    rows, copies = _distinct(calibrated)
    sensors = tuple(dict.fromkeys(row["sensor"] for row in rows))
    number_of = {sensor: i for i, sensor in enumerate(sensors)}
    sensor = np.array([number_of[row["sensor"]] for row in rows])
    noise_dof = NOISE_DOF_PER_POSE * _column(rows, "n_poses")
    spreads, repeats = [], []
    for name in parameter_names():
        value = _column(rows, name)
        spread = spread_of(
            name, *weighed_together(value, _column(rows, f"{name}_sd"), sensor, len(sensors)))
        if spread is not None:
            spreads.append(spread)
            repeats.append(repeatability(
                name, value, _column(rows, f"{name}_noise_sd"), noise_dof, sensor, len(sensors)))
    blocks = partial(_evidence_blocks, rows, triad, output)
    has_evidence = next(blocks(), None) is not None
    return TriadPopulation(
        triad, rows, copies, sensors, tuple(spreads), tuple(each for each in repeats if each.dof),
        pool(blocks) if has_evidence else None,
    )


def _distinct(rows: Sequence[Row]) -> tuple[list[Row], dict[str, str]]:
    """Rows with measurements of their own; names of the others with whose they repeat.

    No two measurements give the same chi-square and parameters to the last bit.
    """
    first: dict[tuple[Any, ...], Row] = {}
    copies = {}
    for row in rows:
        key = (row["chi2"], *(row.get(name) for name in parameter_names()))
        if key in first:
            copies[row["session"]] = first[key]["session"]
        else:
            first[key] = row
    return list(first.values()), copies


def parameter_names() -> list[str]:
    """The columns of the nine parameters."""
    return [f"{key}_{axis}" for key in PARAMETERS for axis in AXES]


def parameter_unit(name: str, triad: str) -> str:
    """The unit of one of them."""
    return unit_of(name.rpartition("_")[0], triad)


def _column(rows: Sequence[Row], name: str) -> FloatArray:
    return np.array([np.nan if row.get(name) is None else row[name] for row in rows], float)


def _evidence_blocks(rows: Sequence[Row], triad: str, output: Path) -> Iterator[LotEvidence]:
    """The evidence of all sessions, so many at once that memory holds them."""
    for first in range(0, len(rows), AT_ONCE):
        lot = LotEvidence.of(_evidence(rows[first : first + AT_ONCE], triad, output))
        if lot is not None:
            yield lot


def _evidence(
    rows: Sequence[Row], triad: str, output: Path
) -> Iterator[tuple[str, Evidence]]:
    for row in rows:
        evidence = kept_evidence(evidence_path(output, row["session"], triad))
        if evidence is not None:
            yield row["sensor"], evidence


def population_json(populations: Sequence[TriadPopulation]) -> Json:
    """The same for programs: SI units and those of results.json; null for what is not known."""
    return {each.triad: _triad_json(each) for each in populations}


def _triad_json(population: TriadPopulation) -> Json:
    pooled = population.pool
    return {
        "sensors": len(population.sensors),
        "sessions": len(population.rows),
        "copies": dict(population.copies),
        "missing": [] if pooled is None else [_effect_json(each) for each in pooled.effects],
        "candidates": [] if pooled is None else [
            {"name": each.trial.name, "shape": each.trial.shape, "sessions": each.sessions,
             "p_common_size": each.p_common, "p_any_size": each.p_any}
            for each in pooled.candidates
        ],
        "parameters": {
            each.name: _effects_json(each.of_lot) | {
                "unlike": [population.sensors[i] for i in np.flatnonzero(each.unlike)]}
            for each in population.spreads
        },
        "repeatability": {
            each.name: {"birge_ratio": number(each.birge), "dof": each.dof,
                        "p_value": number(each.p_value),
                        "moved": [population.sensors[i] for i in np.flatnonzero(each.moved)]}
            for each in population.repeats
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
