"""The rows of all sessions as one table, Parquet and CSV; the same whoever made them, and when."""

import csv
import io
from collections.abc import Sequence
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from calib.poses.imu_log import TRIADS
from pipeline.config.file_patterns import natural_key
from pipeline.errors import ConfigError
from pipeline.fleet.record import SessionRecord
from pipeline.fleet.rows import SIZE, Row
from pipeline.results.written import write_output
from pipeline.text.names import DISTRIBUTION
from pipeline.text.plain import cell

CSV_NAME, PARQUET_NAME = "fleet.csv", "fleet.parquet"
WHOLE = {"exit_code", "warnings", "n_poses", "dof"}


def require_parquet() -> None:
    """Refuse before anything slow where the library of the Parquet format is not installed.

    Raises
    ------
    ConfigError
        With the command that installs it.
    """
    if find_spec("pyarrow") is None:
        raise ConfigError(f"`pipeline fleet` writes Parquet, whose library is not installed. "
                          f"Type: pip install '{DISTRIBUTION}[fleet]'")


def fleet_rows(records: Sequence[SessionRecord]) -> list[Row]:
    """All rows, by session and triad, each with every column; None where it has no value."""
    order = {triad: i for i, triad in enumerate(TRIADS)}
    rows = [dict(row) for record in records for row in record.rows]
    rows.sort(key=lambda row: (natural_key(row["session"]), order.get(row["triad"], -1)))
    names = dict.fromkeys(name for row in sorted(rows, key=lambda row: -len(row)) for name in row)
    columns = [*(name for name in names if not name.startswith(SIZE)),
               *sorted(name for name in names if name.startswith(SIZE))]
    return [{name: row.get(name) for name in columns} for row in rows]


def write_table(rows: Sequence[Row], output: Path) -> None:
    """Write ``fleet.csv`` and ``fleet.parquet``."""
    write_output(output, output / CSV_NAME, csv_text(rows))
    write_output(output, output / PARQUET_NAME, _parquet(rows))


def csv_text(rows: Sequence[Row]) -> str:
    """The table as CSV; what has no value is empty, and no text is run as a formula."""
    text = io.StringIO()
    writer = csv.DictWriter(text, fieldnames=list(rows[0]), lineterminator="\n")
    writer.writeheader()
    for row in rows:
        writer.writerow({name: cell(each) if isinstance(each, str) else each
                         for name, each in row.items()})
    return text.getvalue()


def _parquet(rows: Sequence[Row]) -> bytes:
    import pyarrow as pa
    import pyarrow.parquet as pq

    columns = {name: pa.array([row[name] for row in rows], type=_type(pa, name, rows))
               for name in rows[0]}
    buffer = io.BytesIO()
    pq.write_table(pa.table(columns), buffer)
    return buffer.getvalue()


def _type(pa: Any, name: str, rows: Sequence[Row]) -> Any:
    """Type of a column: text where it has any, else numbers, of which some are counts."""
    if name in WHOLE:
        return pa.int64()
    is_text = any(isinstance(row[name], str) for row in rows)
    return pa.string() if is_text else pa.float64()
