"""Logs of flight controllers, byte by byte as their specifications say."""

import struct
from pathlib import Path

import numpy as np
from pyulog import ULog

ULOG_HEADER = b"ULog\x01\x12\x35\x01" + struct.pack("<Q", 0)
FORMATS = {
    "sensor_accel": "sensor_accel:uint64_t timestamp;float x;float y;float z;float temperature;",
    "sensor_gyro": "sensor_gyro:uint64_t timestamp;float x;float y;float z;float temperature;",
}


def px4_log(path: Path, time_s: np.ndarray, acc: np.ndarray, gyr: np.ndarray) -> Path:
    """A ULog of both sensors, rewritten by the format's own library."""
    parts = [ULOG_HEADER, _message(b"B", bytes(40))]
    parts += [_message(b"F", text.encode()) for text in FORMATS.values()]
    parts += [_message(b"A", struct.pack("<BH", 0, i) + name.encode())
              for i, name in enumerate(FORMATS)]
    for row, t in enumerate(time_s):
        for i, values in enumerate((acc, gyr)):
            stamp = round(t * 1e6)
            parts.append(_message(b"D", struct.pack("<HQ4f", i, stamp, *values[row], 25.0)))
    raw = path.with_suffix(".raw")
    raw.write_bytes(b"".join(parts))
    ULog(str(raw)).write_ulog(str(path))
    raw.unlink()
    return path


def _message(kind: bytes, data: bytes) -> bytes:
    return struct.pack("<Hc", len(data), kind) + data


HEAD = b"\xa3\x95"
FMT = 128


def ardupilot_log(path: Path, time_s: np.ndarray, acc: np.ndarray, gyr: np.ndarray) -> Path:
    """A DataFlash log with the messages ACC and GYR."""
    parts = [_format(FMT, 89, "FMT", "BBnNZ", "Type,Length,Name,Format,Columns")]
    parts += [_format(130 + i, 3 + 29, name, "QBQfff", f"TimeUS,I,SampleUS,{axes}")
              for i, (name, axes) in enumerate((("ACC", "AccX,AccY,AccZ"),
                                                ("GYR", "GyrX,GyrY,GyrZ")))]
    for row, t in enumerate(time_s):
        for i, values in enumerate((acc, gyr)):
            stamp = round(t * 1e6)
            data = struct.pack("<QBQ3f", stamp + 300, 0, stamp, *values[row])
            parts.append(HEAD + bytes([130 + i]) + data)
    path.write_bytes(b"".join(parts))
    return path


def _format(kind: int, length: int, name: str, form: str, columns: str) -> bytes:
    return HEAD + bytes([FMT]) + struct.pack("<BB4s16s64s", kind, length, name.encode(),
                                             form.encode(), columns.encode())
