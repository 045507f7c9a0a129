"""ArduPilot logs (DataFlash .bin): ACC and GYR, or IMU if these were not logged."""

import struct
from pathlib import Path

import numpy as np
from pymavlink.DFReader import FORMAT_TO_STRUCT, DFReader_binary

from calib.poses.imu_log import TEMPERATURE, FloatArray
from pipeline.errors import UnreadableInput
from pipeline.logs.columns import ACCELEROMETER, GYROSCOPE, TIME
from pipeline.logs.formats.file_table import FileTable

AXES = {"Acc": ACCELEROMETER, "Gyr": GYROSCOPE}
#: Message -> the field of its time, in microseconds, preferably that of the sample.
MESSAGES = {"ACC": "SampleUS", "GYR": "SampleUS", "IMU": "TimeUS", "IMU2": "TimeUS",
            "IMU3": "TimeUS"}


BEGINS = b"\xa3\x95"  #: first bytes of every message; its type follows
DEFINITION = 0x80  #: type of a message that defines another type
BODY = struct.Struct("<BB4s16s64s")  #: layout of a definition: type, length, name, format, labels
LARGEST_DAMAGE = 0.01
"""Largest share of bytes that belong to no message. A judgement: a log that lost power lacks its
last message, and a file of another kind has no messages at all. Half and twice change none of the
136 cases of ``tests.pipeline.logs``."""

LAST_PAGE = 528
"""Number of bytes that block-based logs may leave unwritten at their end. A fact of the library."""


def tables(path: Path) -> list[FileTable]:
    """A table for each instance of each sensor, in m/s², rad/s and seconds."""
    _require_sound(path)
    reader = DFReader_binary(str(path))
    try:
        rows = _rows(reader)
    finally:
        reader.data_map.close()
        reader.filehandle.close()
    raw = {name for name in rows if name.startswith(("ACC", "GYR"))}
    return [FileTable(name, _columns(name, samples))
            for name, samples in rows.items() if name in raw or not raw]


def _require_sound(path: Path) -> None:
    """Refuse files on which the library fails with an unspecific error, or prints a line per byte.

    Raises
    ------
    UnreadableInput
        A message has fields of no known type, or much of the file belongs to no message.
    """
    data = path.read_bytes()
    lengths = {DEFINITION: len(BEGINS) + 1 + BODY.size}
    at = lost = 0
    while at + len(BEGINS) < len(data):
        kind = data[at + len(BEGINS)]
        if not data.startswith(BEGINS, at) or kind not in lengths:
            following = data.find(BEGINS, at + 1)
            following = following if following > 0 else len(data)
            lost, at = lost + following - at, following
            continue
        if kind == DEFINITION and at + lengths[kind] <= len(data):
            number, length, _, fields, _ = BODY.unpack_from(data, at + len(BEGINS) + 1)
            if not set(fields.rstrip(b"\0").decode("latin-1")) <= set(FORMAT_TO_STRUCT):
                raise _damaged(path, at)
            lengths[number] = max(length, len(BEGINS) + 1)
        at += lengths[kind]
    if lost > max(LAST_PAGE, LARGEST_DAMAGE * len(data)):
        raise _damaged(path, at)


def _damaged(path: Path, at: int) -> UnreadableInput:
    return UnreadableInput(f"{path}: is damaged near byte {at}. Copy it again from the card of the "
                           "flight controller.")


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
        columns[TEMPERATURE] = np.array([sample["T"] for sample in samples], float)
    return columns
