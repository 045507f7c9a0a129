"""MATLAB files up to version 7.2; files of version 7.3 are HDF5."""

from pathlib import Path

import numpy as np
from scipy.io import loadmat

from pipeline.logs.formats.file_table import FileTable, columns_of_array, tables_by_length


def tables(path: Path) -> list[FileTable]:
    """The numeric arrays of a file, with those of one length in one table."""
    columns: dict[str, np.ndarray] = {}
    with path.open("rb") as file:
        variables = loadmat(file, squeeze_me=False, struct_as_record=False)
    for name, value in variables.items():
        if not name.startswith("__"):
            columns |= _columns(name, value)
    return tables_by_length(columns)


def _columns(name: str, value: object) -> dict[str, np.ndarray]:
    """Columns of an array, or of the arrays in a struct."""
    if isinstance(value, np.ndarray) and value.dtype == object:
        # A struct, or a cell, is an array of one object.
        return _columns(name, value.item()) if value.size == 1 else {}
    if isinstance(value, np.ndarray):
        return columns_of_array(name, value)
    arrays: dict[str, np.ndarray] = {}
    for field in getattr(value, "_fieldnames", ()):
        arrays |= _columns(f"{name}.{field}", getattr(value, field))
    return arrays
