"""The result of a reader of files: tables of numbers with names."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from calib.poses.imu_log import FloatArray

REAL = "iuf"  #: kinds of NumPy's types, without complex ones, whose imaginary part would be lost


@dataclass(frozen=True, eq=False)
class FileTable:
    """One table of a file: a topic, a message type, a member of an archive, an array.

    Parameters
    ----------
    name : str
        Name by which a configuration selects it, as in ``flight.ulg/sensor_accel_0``.
    columns : mapping of str to array, shape (t,)
        In the order of the file, with its names, or with ours if the format states its units.
    first_line : int
        Number of the line of the first row of a text; 0 if the rows are no lines.
    """

    name: str
    columns: Mapping[str, FloatArray]
    first_line: int = 0

    def place(self, row: int) -> str:
        """Where a row is in the file, for messages."""
        return f":{self.first_line + row}" if self.first_line else f", row {row + 1}"


@dataclass(frozen=True, eq=False)
class TextFile:
    """A file of text, or one in an archive: its name there, and its bytes."""

    name: str
    data: bytes


def columns_of_array(name: str, array: np.ndarray) -> dict[str, FloatArray]:
    """The columns of an array (t,) or (t, k); (k, t) is transposed: a log is longer than wide.

    A structured array has its own names. Three columns are axes, ``name[0]`` to ``name[2]``; other
    columns are named by their position, ``name:1``, ``name:2``, ...
    """
    if array.dtype.names:
        return {field: np.asarray(array[field], float).ravel() for field in array.dtype.names
                if array[field].dtype.kind in REAL}
    if array.ndim > 2 or array.dtype.kind not in REAL or array.size < 2:
        return {}
    table = np.atleast_2d(np.asarray(array, float))
    if table.shape[0] < table.shape[1]:
        table = table.T
    if table.shape[1] == 1:
        return {name: table[:, 0]}
    if table.shape[1] == 3:
        return {f"{name}[{i}]": column for i, column in enumerate(table.T)}
    return {f"{name}:{i}": column for i, column in enumerate(table.T, 1)}


def tables_by_length(columns: Mapping[str, FloatArray]) -> list[FileTable]:
    """Tables of the columns of one file that have the same length.

    The name of a table is the array of all its columns, or its number of rows.
    """
    lengths = dict.fromkeys(len(values) for values in columns.values())
    tables = []
    for length in lengths:
        names = [name for name, values in columns.items() if len(values) == length]
        arrays = {name.partition("[")[0].partition(":")[0] for name in names}
        alone = arrays.pop() if len(arrays) == 1 else ""
        tables.append(FileTable(alone or f"{length}_rows", {name: columns[name]
                                                            for name in names}))
    return tables
