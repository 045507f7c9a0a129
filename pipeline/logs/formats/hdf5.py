"""HDF5 files, including those of MATLAB 7.3."""

from pathlib import Path

import h5py
import numpy as np

from pipeline.logs.formats.file_table import FileTable, columns_of_array, tables_by_length


def tables(path: Path) -> list[FileTable]:
    """The numeric data sets of a file, with those of one length in one table."""
    columns: dict[str, np.ndarray] = {}

    def visit(name: str, item: object) -> None:
        if isinstance(item, h5py.Dataset) and not name.startswith("#"):
            columns.update(columns_of_array(name, np.asarray(item)))

    with h5py.File(path) as file:
        file.visititems(visit)
    return tables_by_length(columns)
