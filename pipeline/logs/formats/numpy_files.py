"""NumPy's .npy files."""

from pathlib import Path

import numpy as np

from pipeline.logs.formats.file_table import FileTable, columns_of_array, tables_by_length


def tables(path: Path) -> list[FileTable]:
    """The columns of the array."""
    return tables_by_length(columns_of_array(path.stem, np.load(path, allow_pickle=False)))
