"""A lot in one table: the calibration of every sensor, and the effects that the lot lacks."""

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from calib.consistency.data_sheet import SHEET_TOLERANCE
from calib.diagnosis.population.pool import FALSE_ALARM, Pool
from calib.diagnosis.population.random_effects import RandomEffects
from calib.errors import FitFailed
from calib.fit.least_squares.result import MISFIT_P_VALUE
from calib.lot import CalibratedBlock, SensorPoses, calibrate_blocks, pool_of_lot, station_errors
from calib.poses.data_sheet import TriadSpec
from calib.poses.imu_log import AXES, FloatArray, Triad
from calib.rounding import with_sd
from pipeline.errors import DONE, FIT_FAILED, UNDETERMINED
from pipeline.fleet.finish import FleetSummary, write_lot
from pipeline.fleet.limits import Limits
from pipeline.fleet.lot_sets import LotSets
from pipeline.fleet.table import FITS, MISFIT, SIZE, SIZE_SD, column, fleet_table
from pipeline.results.json_values import Json
from pipeline.results.names import PARAMETERS
from pipeline.text.formatting import count
from pipeline.text.plain import one_line

if TYPE_CHECKING:
    from pandas import DataFrame

Stations = tuple[dict[str, tuple[float, float]], RandomEffects]


def run_lot(sets: LotSets, output: Path, limits: Limits | None = None) -> FleetSummary:
    """Calibrate the sensors of a table, and write table, population and page.

    ``limits`` are those of its sensors.

    Raises
    ------
    UnreadableInput
        The table cannot be read.
    UnwritableOutput
        A file cannot be written, or is none that a fleet wrote.
    ConfigError
        A limit is of a column that the table does not have.
    """
    table = fleet_table(part for triad in sets.triads for part in _parts(sets, triad))

    def pooled(name: str, rows: "DataFrame") -> Pool:
        triad = next(one for one in sets.triads if one == name)
        of_triad = table.loc[table["triad"] == name, "sensor"]
        without = set(of_triad[~of_triad.index.isin(rows.index)])  # few: names of all are large

        def passes() -> Iterator[list[SensorPoses]]:
            for block in sets.blocks(triad):
                yield [one for one in block if one.sensor not in without]

        return pool_of_lot(passes, sets.model(triad))

    stations = {triad: errors for triad in sets.triads
                if (errors := _stations(table[table["triad"] == triad])) is not None}
    return write_lot(
        f"Lot {output.absolute().name}", table, pooled, output, limits=limits,
        more={triad: {"stations": _stations_json(stations.get(triad))} for triad in sets.triads},
        notes=[*(_station_line(triad, errors) for triad, errors in stations.items()),
               *(line for triad in sets.triads
                 if (line := _gain_line(triad, table[table["triad"] == triad], sets.spec(triad))))])


def _parts(sets: LotSets, triad: Triad) -> "Iterator[DataFrame]":
    """The rows of one triad, block by block; those of its refusals last."""
    refused: dict[str, tuple[int, str]] = {}
    for block in calibrate_blocks(lambda: sets.blocks(triad), sets.model(triad), sets.spec(triad)):
        if block.sensors:
            yield _rows(triad, block, sets.model(triad).names)
        for name, error in block.refusals.items():
            refused[name] = FIT_FAILED if isinstance(error, FitFailed) else UNDETERMINED, str(error)
    refused |= {name: (UNDETERMINED, reason)
                for (one, name), reason in sets.refusals.items() if one == triad}
    for name, (code, reason) in refused.items():
        yield _frame(triad, [name], exit_code=code, reason=one_line(reason))


def _rows(triad: Triad, block: CalibratedBlock, model: Sequence[str]) -> "DataFrame":
    sizes = {f"{prefix}_{name}": value for name, sized in block.sizes.items()
             for prefix, value in zip((SIZE, SIZE_SD), sized, strict=True)}
    return _frame(triad, block.sensors, station=block.stations, exit_code=DONE, reason="",
                  verdict=np.where(block.p_value < MISFIT_P_VALUE, MISFIT, FITS), missing="",
                  model=" + ".join(model), n_poses=block.poses, chi2=block.chi2, dof=block.dof,
                  p_value=block.p_value, **block.columns(PARAMETERS), **sizes)


def _frame(triad: Triad, sensors: Sequence[str], **columns: Any) -> "DataFrame":
    from pandas import DataFrame

    return DataFrame({"session": sensors, "sensor": sensors, "triad": triad, **columns})


def _gain_line(triad: Triad, rows: "DataFrame", spec: TriadSpec) -> str:
    """The sensors whose gains are far from the data sheet's; empty where there are none."""
    gain = _scales(rows) * spec.nominal_scale
    off = rows["sensor"][np.abs(gain - 1).max(axis=1) > SHEET_TOLERANCE]
    return "" if off.empty else (
        f"{triad}: {count(off.size, 'sensor')} ({off.iloc[0]} first) with a gain more than "
        f"{100 * SHEET_TOLERANCE:.0f} % off the data sheet's. Either their range is another one, "
        f"or their reference is wrong by that factor and the scale with it.")


def _scales(rows: "DataFrame") -> FloatArray:
    """Scales of sensors, (S, 3), counts per SI unit; NaN for those that are refused."""
    return np.column_stack([column(rows, f"{PARAMETERS[2]}_{axis}") for axis in AXES])


def _stations(rows: "DataFrame") -> Stations | None:
    """Deviation of the gains of each station from the lot's; None where there are not two."""
    used = rows[rows["exit_code"] == DONE]
    if not len(used) or not used["station"].any():
        return None
    return station_errors(list(used["station"]), _scales(used))


def _stations_json(stations: Stations | None) -> Json | None:
    if stations is None:
        return None
    errors, effects = stations
    return {"p_same": effects.p_same, "spread": effects.spread,
            "gain_off": {name: {"value": off, "sd": sd} for name, (off, sd) in errors.items()}}


def _station_line(triad: Triad, stations: Stations) -> str:
    errors, effects = stations
    if effects.p_same >= FALSE_ALARM:
        return (f"{triad}: the gains of {count(len(errors), 'station')} are the same within the "
                f"spread of their sensors (p {effects.p_same:.2g}).")
    off = "; ".join(f"{name} {with_sd(100 * value, 100 * sd)} %"
                    for name, (value, sd) in errors.items())
    return (f"{triad}: stations differ (p {effects.p_same:.2g}): the mean gain of each against the "
            f"lot is {off}. That is 'reference_scale', the rate or the gravity of a station: no "
            f"sensor by itself shows it. Check its clock and its rate.")
