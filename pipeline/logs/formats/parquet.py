"""Files of Apache Parquet and Arrow, written for example by pandas and R."""

from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.feather as feather
import pyarrow.parquet as pq

from pipeline.logs.formats.file_table import FileTable

ARROW = b"ARROW1"  #: first bytes of a file of Arrow, or Feather


def tables(path: Path) -> list[FileTable]:
    """The numeric columns, and the time stamps as seconds since 1970."""
    columns = {}
    with path.open("rb") as file:
        is_arrow = file.read(len(ARROW)) == ARROW
    table = feather.read_table(path) if is_arrow else pq.read_table(path)
    for name, column in zip(table.column_names, table.columns, strict=True):
        kind = column.type
        if pa.types.is_timestamp(kind):
            stamps = column.cast(pa.timestamp("ns")).to_numpy()
            columns[name] = stamps.astype("datetime64[ns]").astype(np.int64) * 1e-9
        elif pa.types.is_integer(kind) or pa.types.is_floating(kind) or pa.types.is_decimal(kind):
            columns[name] = np.asarray(column.cast(pa.float64(), safe=False).to_numpy(), float)
    return [FileTable(path.stem, columns)] if columns else []
