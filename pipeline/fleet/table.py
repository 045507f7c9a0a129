"""The rows of a lot, one for each triad of a session, as one table, Parquet and CSV."""

import io
from collections.abc import Iterable, Iterator
from importlib.util import find_spec
from itertools import pairwise, product
from pathlib import Path
from typing import TYPE_CHECKING, Any

from calib.fit.least_squares.result import MISFIT_P_VALUE
from calib.poses.imu_log import AXES, FloatArray
from calib.poses.triad_kind import TRIAD_KINDS
from pipeline.config.file_patterns import natural_key
from pipeline.config.load import Config
from pipeline.errors import ConfigError
from pipeline.fleet.sessions import FleetSession
from pipeline.results.names import PARAMETERS
from pipeline.results.schema.file import ResultsFile
from pipeline.results.schema.triad import TriadSection
from pipeline.results.written import write_output
from pipeline.text.names import DISTRIBUTION
from pipeline.text.plain import cell, one_line

if TYPE_CHECKING:
    from pandas import DataFrame


Row = dict[str, Any]

SIZE, SIZE_SD = "size", "size_sd"
"""Prefixes of the name of an effect: columns with its largest parameter, SI, and the sd of that."""

FITS, MISFIT = "noise explains it", f"misfit (p below {MISFIT_P_VALUE:g})"
"""Verdicts on a sensor of one table, which is fitted and not diagnosed."""


def rows_of_results(session: FleetSession, results: ResultsFile) -> tuple[Row, ...]:
    """A row for each triad that was calibrated."""
    return tuple(
        _head(session, triad) | {
            "exit_code": 0, "reason": "", "title": results.title, "sensor_name": results.sensor,
            "session_start_s": results.session_start_s, "warnings": len(results.warnings),
        } | _triad_columns(section) for triad, section in results.triads.items())


def rows_of_failure(
    session: FleetSession, config: Config | None, exit_code: int, reason: str
) -> tuple[Row, ...]:
    """A row for each triad of the session, or one, with the reason why it is not calibrated."""
    triads = [] if config is None else list(config.triads)
    return tuple(_head(session, triad) | {"exit_code": exit_code, "reason": one_line(reason)}
                 for triad in (triads or [""]))


def _head(session: FleetSession, triad: str) -> Row:
    return {"session": session.name, "sensor": session.sensor, "triad": triad}


def _triad_columns(section: TriadSection) -> Row:
    diagnosis, prediction = section.diagnosis, section.prediction
    row: Row = {
        "verdict": diagnosis.verdict,
        "missing": " + ".join(diagnosis.names),
        "group": " ".join(diagnosis.group),
        "says": diagnosis.in_words,
        "model": " + ".join(section.model),
    }
    sheet = section.correction.sheet
    row["sheet"] = f"{sheet.full_scale} {sheet.bits} {sheet.encoding} {sheet.si_per_unit}"
    for key in ("n_poses", "chi2", "dof", "p_value", "residual_rms", "loo_rms", "sd_widened_by"):
        row[key] = getattr(section, key)
    row["prediction_sd_median"] = prediction and prediction.sd_median
    row["prediction_sd_worst"] = prediction and prediction.sd_worst
    parts = {"": section.parameters, "_sd": section.sd, "_noise_sd": section.sd_parts["noise"]}
    for key, (i, axis), (end, part) in product(PARAMETERS, enumerate(AXES), parts.items()):
        row[f"{key}_{axis}{end}"] = getattr(part, key)[i]
    return row | dict(_sizes(section))


def _sizes(section: TriadSection) -> Iterator[tuple[str, float | None]]:
    """Largest parameter of every effect that is in the model or named as missing, with its sd."""
    shown = {one.name: (one.size, one.sd) for one in section.diagnosis.ranking
             if one.name in section.diagnosis.names}
    shown |= {name: (one.values, one.sd) for name, one in section.effects.items()}
    for name, sized in shown.items():
        stated = [(abs(size), size, sd) for size, sd in zip(*sized, strict=True)
                  if size is not None]
        if stated:
            _, size, sd = max(stated, key=lambda one: one[0])
            yield f"{SIZE}_{name}", size
            yield f"{SIZE_SD}_{name}", sd


CSV_NAME, PARQUET_NAME = "fleet.csv", "fleet.parquet"
WHOLE = ("exit_code", "warnings", "n_poses", "dof")
MOST_IN_CSV = 200_000  #: rows; a limit of memory: more have the Parquet table alone

PARAMETER_NAMES = tuple(f"{key}_{axis}" for key in PARAMETERS for axis in AXES)
"""Columns of the nine parameters."""


def require_libraries() -> None:
    """Refuse, before anything slow, if a library is not installed.

    Raises
    ------
    ConfigError
        With the command that installs it.
    """
    for library, name in {"pyarrow": "pyarrow (for Parquet)", "pandas": "pandas",
                          "distributed": "Dask"}.items():
        if find_spec(library) is None:
            raise ConfigError(f"`pipeline fleet` needs {name}, which is not installed. Type: pip "
                              f"install '{DISTRIBUTION}[fleet]'")


def fleet_table(parts: "Iterable[DataFrame]") -> "DataFrame":
    """All rows of a lot, by session and triad, with the same columns; NaN where it has no value."""
    from pandas import RangeIndex, concat

    table = concat(parts, ignore_index=True)
    order = {triad: i for i, triad in enumerate(TRIAD_KINDS)}
    keys = ((natural_key(session), order.get(triad, -1))
            for session, triad in zip(table["session"], table["triad"], strict=True))
    if any(later < before for before, later in pairwise(keys)):  # a large table is in order
        sessions = sorted(table["session"].unique(), key=natural_key)
        place = {name: i for i, name in enumerate(sessions)}
        rows = table["session"].map(place) * (len(order) + 1) + table["triad"].map(order).fillna(-1)
        table = table.iloc[rows.argsort(kind="stable")]
        table.index = RangeIndex(len(table))
    columns = [name for name in table.columns if not name.startswith(SIZE)]
    columns += sorted(name for name in table.columns if name.startswith(SIZE))
    return table[columns].astype({name: "Int64" for name in WHOLE if name in columns})


def column(table: "DataFrame", name: str) -> FloatArray:
    """A column as numbers (n,) in its unit; NaN where a row has none."""
    import numpy as np

    if name not in table:
        return np.full(len(table), np.nan)
    return np.asarray(table[name].to_numpy(float, na_value=np.nan))


def write_table(table: "DataFrame", output: Path) -> None:
    """Write ``fleet.parquet``, and ``fleet.csv`` of a lot that is not too large for it.

    In CSV missing values are empty, and no text is run as a formula.
    """
    from pandas.api.types import is_numeric_dtype

    buffer = io.BytesIO()
    table.to_parquet(buffer, index=False)
    write_output(output, output / PARQUET_NAME, buffer.getvalue())
    if len(table) <= MOST_IN_CSV:
        texts = {name: table[name].map(cell, na_action="ignore")
                 for name in table.columns if not is_numeric_dtype(table[name])}
        plain = table.assign(**texts).to_csv(index=False, lineterminator="\n")
        write_output(output, output / CSV_NAME, plain)
