"""ArduPilot logs (DataFlash .bin): ACC and GYR, or IMU where these were not logged."""

from pathlib import Path

import numpy as np
from pymavlink.DFReader import DFReader_binary

from calib.poses.imu_log import FloatArray
from pipeline.logs.columns import ACCELEROMETER, GYROSCOPE, TIME
from pipeline.logs.formats.file_table import FileTable

AXES = {"Acc": ACCELEROMETER, "Gyr": GYROSCOPE}
#: Message -> the field of its time, in microseconds: that of the sample where there is one.
MESSAGES = {"ACC": "SampleUS", "GYR": "SampleUS", "IMU": "TimeUS", "IMU2": "TimeUS",
            "IMU3": "TimeUS"}


def tables(path: Path) -> list[FileTable]:
    """A table for each instance of each sensor, in m/s², rad/s and seconds."""
    reader = DFReader_binary(str(path))
    try:
        rows = _rows(reader)
    finally:
        reader.data_map.close()
        reader.filehandle.close()
    raw = {name for name in rows if name.startswith(("ACC", "GYR"))}
    return [FileTable(name, _columns(name, samples))
            for name, samples in rows.items() if name in raw or not raw]


def _rows(reader: DFReader_binary) -> dict[str, list[dict[str, float]]]:
    """The fields of every message, by sensor and instance."""
    rows: dict[str, list[dict[str, float]]] = {}
    while (message := reader.recv_match(type=list(MESSAGES))) is not None:
        sample = message.to_dict()
        kind = message.get_type()
        rows.setdefault(f"{kind}_{int(sample.get('I', 0))}", []).append(sample)
    return rows


def _columns(name: str, samples: list[dict[str, float]]) -> dict[str, FloatArray]:
    stamp = MESSAGES[name.partition("_")[0]]
    stamp = stamp if stamp in samples[0] else "TimeUS"
    columns = {TIME: np.array([sample[stamp] for sample in samples], float) * 1e-6}
    for theirs, triad in AXES.items():
        if f"{theirs}X" in samples[0]:
            columns |= {ours: np.array([sample[f"{theirs}{axis}"] for sample in samples], float)
                        for ours, axis in zip(triad, "XYZ", strict=True)}
    if "T" in samples[0]:
        columns["temperature_c"] = np.array([sample["T"] for sample in samples], float)
    return columns
