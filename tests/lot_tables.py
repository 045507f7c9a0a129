"""A simulated lot as the table that ``pipeline fleet TABLE --design`` reads, and its design."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.csv
import pyarrow.parquet

from tests.world.lot import Lot

ACCELEROMETER_DESIGN = """\
sensor:
  name: simulated
  accelerometer: {full_scale_m_s2: %s, bits: %d, encoding: %s}
site: {gravity_m_s2: %s}
accelerometer:
  model: [bias, scale, misalignment]
"""


def lot_columns(lot: Lot, prefix: str = "acc") -> dict[str, Any]:
    """The columns of a lot's table, a sensor after another."""
    s, n = lot.counts.shape[:2]
    columns: dict[str, Any] = {
        "sensor": np.repeat([f"unit_{i:06d}" for i in range(s)], n),
        "pose": np.tile([f"pose_{i + 1:02d}" for i in range(n)], s),
        "run": np.full(s * n, "stopped"),
        "time_s": np.tile(lot.time_s, s),
    }
    for i, axis in enumerate("xyz"):
        columns[f"{prefix}_{axis}"] = lot.counts[:, :, i].ravel()
        columns[f"sd_{prefix}_{axis}"] = lot.sd_counts[:, :, i].ravel()
    return columns | {name: values.ravel() for name, values in lot.columns.items()}


def write_lot(path: Path, columns: Mapping[str, Any]) -> None:
    """Write a table as Parquet or CSV, by its name."""
    table = pa.table({name: pa.array(values) for name, values in columns.items()})
    if path.suffix == ".csv":
        pyarrow.csv.write_csv(table, path)
    else:
        pyarrow.parquet.write_table(table, path)


def write_design(path: Path, lot: Lot) -> None:
    """Write the design of a lot of accelerometers at rest."""
    triad = lot.triad
    encoding = "offset-binary" if triad.offset_binary else "twos-complement"
    path.write_text(ACCELEROMETER_DESIGN % (triad.full_scale, triad.bits, encoding,
                                            repr(float(lot.magnitude[0, 0]))), encoding="utf-8")
