"""A lot in one table: every sensor calibrated, one table of them, and what the lot is missing."""

import io
import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path
from typing import Any

import numpy as np

from calib.diagnosis.population.pool import FALSE_ALARM
from calib.diagnosis.population.spread import spread_of
from calib.errors import FitFailed
from calib.fit.least_squares.result import MISFIT_P_VALUE
from calib.lot import CalibratedBlock, calibrate_blocks, pool_of_lot, station_errors
from calib.poses.imu_log import AXES, Triad
from calib.rounding import with_sd
from pipeline.errors import DONE, FIT_FAILED, UNDETERMINED
from pipeline.fleet.lot_sets import LotSets
from pipeline.fleet.page import PAGE_NAME, fleet_html
from pipeline.fleet.population import (
    POPULATION_NAME,
    TriadPopulation,
    parameter_names,
    population_json,
)
from pipeline.fleet.record import SessionRecord
from pipeline.fleet.summary_text import MEANING
from pipeline.fleet.table import CSV_NAME, PARQUET_NAME
from pipeline.fleet.words import pool_text
from pipeline.results.json_values import Json
from pipeline.results.names import PARAMETERS
from pipeline.results.written import write_output
from pipeline.text.formatting import count
from pipeline.text.plain import cell, one_line

MOST_IN_CSV = 100_000  #: sensors; a limit of memory: more have the Parquet table alone
FITS, MISFIT = "noise explains it", "misfit"


@dataclass(frozen=True, eq=False)
class LotSummary:
    """What the command prints and returns: ``lines`` of text, and the population as JSON."""

    lines: tuple[str, ...]
    population: str


def run_lot(sets: LotSets, output: Path) -> LotSummary:
    """Calibrate the sensors of a table, and write table, population and page.

    Raises
    ------
    UnreadableInput
        The table cannot be read.
    UnwritableOutput
        A file cannot be written, or is none that a fleet wrote.
    """
    table = _Table()
    populations, stations, lines = [], {}, []
    records: dict[str, SessionRecord] = {}
    for triad in sets.triads:
        population, of_stations = _population(sets, triad, table, records)
        if population is not None:
            populations.append(population)
            stations[triad] = _stations_json(of_stations)
            lines += [*_verdicts(population), f"{triad}: {pool_text(population)}",
                      *_station_lines(triad, of_stations)]
    whole = population_json(populations)
    for triad, of_triad in stations.items():
        whole[triad]["stations"] = of_triad
    text = json.dumps(whole, indent=1, ensure_ascii=False, allow_nan=False) + "\n"
    ordered = list(records.values())
    title = f"Lot {output.absolute().name}"
    page = fleet_html(title, ordered, populations, False, datetime.now().astimezone())
    table.write(output)
    write_output(output, output / POPULATION_NAME, text)
    write_output(output, output / PAGE_NAME, page)
    return LotSummary((*_head(ordered), *lines, str(output / PAGE_NAME)), text)


def _population(
    sets: LotSets, triad: Triad, table: "_Table", records: dict[str, SessionRecord]
) -> tuple[TriadPopulation | None, Any]:
    """One triad over the lot; its rows go into ``table``, its refusals into ``records``."""
    model, spec = sets.model(triad), sets.spec(triad)

    def passes() -> Iterator[Any]:
        return sets.blocks(triad)

    values: list[np.ndarray] = []
    sds: list[np.ndarray] = []
    rows: list[dict[str, Any]] = []
    stations: list[str] = []
    for block in calibrate_blocks(passes, model, spec):
        value, sd = _values(block)
        values.append(value)
        sds.append(sd)
        stations += block.stations
        verdicts = [MISFIT if p < MISFIT_P_VALUE else FITS for p in block.p_value]
        rows += [{"session": name, "sensor": name, "verdict": verdict, "missing": ""}
                 for name, verdict in zip(block.sensors, verdicts, strict=True)]
        table.add(triad, block, value, sd, verdicts)
        for name in block.sensors:
            records.setdefault(name, SessionRecord(name, name, "", DONE))
        for name, error in block.refusals.items():
            code = FIT_FAILED if isinstance(error, FitFailed) else UNDETERMINED
            records[name] = SessionRecord(name, name, "", code, one_line(str(error)))
            table.refuse(triad, name, code, str(error))
    for name, reason in sets.refusals.items():
        if name not in records or records[name].exit_code == DONE:
            records[name] = SessionRecord(name, name, "", UNDETERMINED, one_line(reason))
            table.refuse(triad, name, UNDETERMINED, reason)
    if not rows:
        return None, None
    value, sd = np.concatenate(values), np.concatenate(sds)
    spreads = [spread_of(name, value[:, i], sd[:, i])
               for i, name in enumerate(parameter_names())]
    population = TriadPopulation(
        triad, rows, {}, tuple(row["sensor"] for row in rows),
        tuple(spread for spread in spreads if spread is not None), (),
        pool_of_lot(passes, model))
    scale = value[:, [parameter_names().index(f"{PARAMETERS[2]}_{axis}") for axis in AXES]]
    return population, station_errors(stations, scale) if any(stations) else None


def _values(block: CalibratedBlock) -> tuple[np.ndarray, np.ndarray]:
    """The nine parameters of every sensor and their sds, in the order of their columns."""
    of_block = block.parameters
    return (np.concatenate([getattr(of_block, name) for name in PARAMETERS], axis=1),
            np.concatenate(of_block.sd, axis=1))


class _Table:
    """The table of a lot, kept in columns until it is written."""

    def __init__(self) -> None:
        self.parts: list[Any] = []
        self.sensors = 0

    def add(
        self, triad: Triad, block: CalibratedBlock, value: np.ndarray, sd: np.ndarray,
        verdicts: Sequence[str],
    ) -> None:
        """The rows of calibrated sensors."""
        names = parameter_names()
        numbers = {"n_poses": block.poses, "chi2": block.chi2, "dof": block.dof,
                   "p_value": block.p_value}
        for i, name in enumerate(names):
            numbers |= {name: value[:, i], f"{name}_sd": sd[:, i]}
        n = len(block.sensors)
        self._append({
            "sensor": list(block.sensors), "triad": [triad] * n, "station": list(block.stations),
            "exit_code": [DONE] * n, "reason": [""] * n, "verdict": list(verdicts), **numbers,
        })
        self.sensors += n

    def refuse(self, triad: Triad, sensor: str, code: int, reason: str) -> None:
        """The row of a sensor that is not calibrated."""
        self._append({"sensor": [sensor], "triad": [triad], "station": [""], "exit_code": [code],
                      "reason": [one_line(reason)], "verdict": [""]})

    def _append(self, columns: Mapping[str, Any]) -> None:
        import pyarrow as pa

        self.parts.append(pa.table(columns))

    def write(self, output: Path) -> None:
        """Write ``fleet.parquet``, and ``fleet.csv`` of a lot that is not too large for it."""
        import pyarrow as pa
        import pyarrow.csv
        import pyarrow.parquet

        whole = pa.concat_tables(self.parts, promote_options="default")
        buffer = io.BytesIO()
        pyarrow.parquet.write_table(whole, buffer)
        write_output(output, output / PARQUET_NAME, buffer.getvalue())
        if self.sensors <= MOST_IN_CSV:
            text = io.BytesIO()
            pyarrow.csv.write_csv(_without_formulas(whole), text)
            write_output(output, output / CSV_NAME, text.getvalue())


def _without_formulas(table: Any) -> Any:
    """The table where no text is run as a formula."""
    import pyarrow as pa

    for i, field in enumerate(table.schema):
        if pa.types.is_string(field.type):
            texts = [None if text is None else cell(text) for text in table.column(i).to_pylist()]
            table = table.set_column(i, field.name, pa.array(texts, pa.string()))
    return table


def _head(records: Sequence[SessionRecord]) -> Iterator[str]:
    codes = [record.exit_code for record in records]
    yield f"{count(len(codes), 'sensor')}: {codes.count(DONE)} calibrated"
    for code in sorted(set(codes) - {DONE}):
        yield f"  {codes.count(code)} with exit code {code}: {MEANING[code]}"


def _verdicts(population: TriadPopulation) -> Iterator[str]:
    fits = sum(row["verdict"] == FITS for row in population.rows)
    yield (f"{population.triad:15s} {fits} {FITS}, {len(population.rows) - fits} {MISFIT} "
           f"(p below {MISFIT_P_VALUE:g})")


def _stations_json(stations: Any) -> Json | None:
    if stations is None:
        return None
    errors, effects = stations
    return {"p_same": effects.p_same, "spread": effects.spread,
            "gain_off": {name: {"value": off, "sd": sd} for name, (off, sd) in errors.items()}}


def _station_lines(triad: Triad, stations: Any) -> Iterator[str]:
    if stations is None:
        return
    errors, effects = stations
    if effects.p_same >= FALSE_ALARM:
        yield (f"{triad}: the gains of {count(len(errors), 'station')} are the same within the "
               f"spread of their sensors (p {effects.p_same:.2g}).")
        return
    off = "; ".join(f"{name} {with_sd(100 * value, 100 * sd)} %"
                    for name, (value, sd) in errors.items())
    yield (f"{triad}: stations differ (p {effects.p_same:.2g}): the mean gain of each against the "
           f"lot is {off}. That is 'reference_scale', the rate or the gravity of a station: no "
           f"sensor by itself shows it. Check its clock and its rate.")
