"""The rows of a lot as one table, Parquet and CSV; the same whoever made them, and when."""

import io
from collections.abc import Sequence
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any

from calib.poses.imu_log import AXES, FloatArray
from calib.poses.triad_kind import TRIAD_KINDS
from pipeline.config.file_patterns import natural_key
from pipeline.errors import ConfigError
from pipeline.fleet.rows import SIZE
from pipeline.results.names import PARAMETERS
from pipeline.results.units import unit_of
from pipeline.results.written import write_output
from pipeline.text.names import DISTRIBUTION
from pipeline.text.plain import cell

if TYPE_CHECKING:
    from pandas import DataFrame

CSV_NAME, PARQUET_NAME = "fleet.csv", "fleet.parquet"
WHOLE = ("exit_code", "warnings", "n_poses", "dof")
MOST_IN_CSV = 200_000  #: rows; a limit of memory: more have the Parquet table alone

PARAMETER_NAMES = tuple(f"{key}_{axis}" for key in PARAMETERS for axis in AXES)
"""Columns of the nine parameters."""


def require_libraries() -> None:
    """Refuse before anything slow where a library of the table is not installed.

    Raises
    ------
    ConfigError
        With the command that installs it.
    """
    for library in ("pyarrow", "pandas"):
        if find_spec(library) is None:
            raise ConfigError(f"`pipeline fleet` writes a table (Parquet), and {library} is not "
                              f"installed. Type: pip install '{DISTRIBUTION}[fleet]'")


def fleet_table(parts: "Sequence[DataFrame]") -> "DataFrame":
    """All rows of a lot, by session and triad, each with every column; NaN where it has no value.
    """
    from pandas import concat

    table = concat(parts, ignore_index=True)
    order = {triad: i for i, triad in enumerate(TRIAD_KINDS)}
    sessions = sorted(table["session"].unique(), key=natural_key)
    place = {name: i for i, name in enumerate(sessions)}
    rows = table["session"].map(place) * (len(order) + 1) + table["triad"].map(order).fillna(-1)
    table = table.iloc[rows.argsort(kind="stable")].reset_index(drop=True)
    columns = [name for name in table.columns if not name.startswith(SIZE)]
    columns += sorted(name for name in table.columns if name.startswith(SIZE))
    whole = {name: "Int64" for name in WHOLE if name in columns}
    return table[columns].astype(whole)


def column(table: "DataFrame", name: str) -> FloatArray:
    """A column as numbers (n,) in its unit; NaN where a row has none."""
    import numpy as np

    if name not in table:
        return np.full(len(table), np.nan)
    return np.asarray(table[name].to_numpy(float, na_value=np.nan))


def parameter_unit(name: str, triad: str) -> str:
    """The unit of one of the nine parameters."""
    return unit_of(name.rpartition("_")[0], triad)


def write_table(table: "DataFrame", output: Path) -> None:
    """Write ``fleet.parquet``, and ``fleet.csv`` of a lot that is not too large for it.

    In CSV what has no value is empty, and no text is run as a formula.
    """
    buffer = io.BytesIO()
    table.to_parquet(buffer, index=False)
    write_output(output, output / PARQUET_NAME, buffer.getvalue())
    if len(table) <= MOST_IN_CSV:
        plain = table.map(_plain, na_action="ignore")
        write_output(output, output / CSV_NAME, plain.to_csv(index=False, lineterminator="\n"))


def _plain(value: Any) -> Any:
    return cell(value) if isinstance(value, str) else value
