"""The table of a lot: one row for each pose of each sensor, read block by block.

Columns: ``sensor``, ``pose``, ``run`` (the setting of the plate, or ``stopped``), ``acc_x`` ...
``gyr_z`` (means in counts), ``sd_acc_x`` ... ``sd_gyr_z`` (their sds), and, where they are known,
``time_s``, ``temperature_c``, ``station`` and further numeric columns. The rows of a sensor stand
together.
"""

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from calib.poses.imu_log import FloatArray
from pipeline.errors import UnreadableInput

SENSOR, POSE, RUN, STATION = "sensor", "pose", "run", "station"
TABLES = (".parquet", ".csv")  #: endings of the name of a lot in one table
TEXTS = (SENSOR, POSE, RUN, STATION)
ROWS_AT_ONCE = 20_000  #: rows of the table; a limit of memory


@dataclass(frozen=True, eq=False)
class SensorRows:
    """The rows of one sensor: texts and numbers by column, each (n,)."""

    sensor: str
    station: str
    pose: tuple[str, ...]
    run: tuple[str, ...]
    numbers: Mapping[str, FloatArray]


def sensor_blocks(
    path: Path, needed: Sequence[str], settings: Collection[str], is_sorted: bool = False
) -> Iterator[list[SensorRows]]:
    """The sensors of a table, some hundreds at a time.

    Parameters
    ----------
    path : Path
        Parquet or CSV.
    needed : sequence of str
        Columns without which the lot cannot be calibrated.
    settings : collection of str
        Of the plate, as the design names them; one alone is the run of every row where the table
        has no such column.
    is_sorted : bool
        Whether the rows of every sensor are known to stand together.

    Raises
    ------
    UnreadableInput
        The table cannot be read, lacks a column or rows, the rows of a sensor do not stand
        together, or are of two stations.
    """
    only = next(iter(settings)) if len(settings) == 1 else ""
    ended: set[str] | None = None if is_sorted else set()
    rest: dict[str, Any] = {}
    for batch in _batches(path, [*needed, *([] if only else [RUN])]):
        columns = {name: np.concatenate([rest[name], values]) if rest else values
                   for name, values in batch.items()}
        names = columns[SENSOR]
        begins = np.flatnonzero(np.append(True, names[1:] != names[:-1]))
        rest = {name: values[begins[-1] :] for name, values in columns.items()}
        if len(begins) > 1:
            yield _split(columns, begins, ended, path, only)
    if not rest:
        raise UnreadableInput(f"{path.name}: has no row; one for each pose of each sensor is "
                              f"expected.")
    yield _split(rest, np.array([0, len(rest[SENSOR])]), ended, path, only)


def _split(
    columns: Mapping[str, Any], begins: Any, ended: set[str] | None, path: Path, only: str
) -> list[SensorRows]:
    """The sensors between the rows ``begins``; what follows the last of these is left."""
    blocks = []
    texts = {name: columns[name] for name in TEXTS if name in columns}
    numbers = {name: values for name, values in columns.items() if name not in TEXTS}
    for first, last in pairwise(begins):
        part, n = slice(first, last), int(last - first)
        sensor = str(columns[SENSOR][first])
        if not sensor.strip():
            raise UnreadableInput(f"{path.name}: a row has no name in its column `{SENSOR}`.")
        if ended is not None:
            if sensor in ended:
                raise UnreadableInput(
                    f"{path.name}: the rows of sensor {sensor} do not stand together. Sort the "
                    f"table by its column `{SENSOR}`.")
            ended.add(sensor)
        stations = [*dict.fromkeys(map(str, texts[STATION][part]))] if STATION in texts else [""]
        if len(stations) > 1:
            raise UnreadableInput(
                f"{path.name}: the rows of sensor {sensor} are of the stations "
                f"{', '.join(stations)}. A calibration is of one: give each visit a sensor's name "
                f"of its own, as in {sensor}/{stations[0]}.")
        blocks.append(SensorRows(
            sensor,
            stations[0],
            tuple(map(str, texts[POSE][part])) if POSE in texts
            else tuple(f"pose {i + 1}" for i in range(n)),
            tuple(map(str, texts[RUN][part])) if RUN in texts else (only,) * n,
            {name: values[part] for name, values in numbers.items()},
        ))
    return blocks


def _batches(path: Path, needed: Sequence[str]) -> Iterator[dict[str, Any]]:
    import pyarrow as pa
    import pyarrow.csv
    import pyarrow.parquet

    try:
        if path.suffix.lower() == ".csv":
            delimiter, point = _dialect(path)
            options = pyarrow.csv.ConvertOptions(
                column_types={name: pa.string() for name in TEXTS}, decimal_point=point)
            reader: Any = pyarrow.csv.open_csv(
                path, convert_options=options,
                parse_options=pyarrow.csv.ParseOptions(delimiter=delimiter))
        else:
            reader = pyarrow.parquet.ParquetFile(path).iter_batches(ROWS_AT_ONCE)
        for batch in reader:
            absent = [name for name in (SENSOR, *needed) if name not in batch.schema.names]
            if absent:
                raise UnreadableInput(
                    f"{path.name}: no column {', '.join(absent)}. It has "
                    f"{', '.join(batch.schema.names)}. A row is a pose of a sensor: {SENSOR}, "
                    f"{POSE}, {RUN}, the means in counts and their sds.")
            if batch.num_rows:
                yield {name: _values(path, name, batch.column(name))
                       for name in batch.schema.names}
    except (pa.ArrowException, OSError) as error:
        raise UnreadableInput(f"{path}: cannot be read as a table: {error}") from error


def _dialect(path: Path) -> tuple[str, str]:
    """Delimiter and decimal point of a CSV file: a spreadsheet in German writes ``;`` and ``,``."""
    with path.open(encoding="utf-8", errors="replace") as file:
        header, row = file.readline(), file.readline()
    delimiter = max(",;\t", key=header.count)
    return delimiter, "," if delimiter != "," and "," in row else "."


def _values(path: Path, name: str, column: Any) -> Any:
    """The values of a column (n,); of a text each once, so that one that is kept pins no others."""
    if name in TEXTS:
        texts, index = np.unique(np.array(column.to_pylist(), dtype=object).astype(str),
                                 return_inverse=True)
        return np.array(texts.tolist(), dtype=object)[index]
    try:
        return np.asarray(column.to_numpy(zero_copy_only=False), dtype=float)
    except (TypeError, ValueError) as error:
        raise UnreadableInput(f"{path.name}: column {name} is not numeric ({error}). Leave it out "
                              f"of the table.") from error
