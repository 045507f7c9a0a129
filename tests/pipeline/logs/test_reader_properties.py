"""Any bytes are a log or are refused; what was written is read back."""

import gzip
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from calib.errors import UnusableLog
from pipeline.errors import UnreadableInput
from pipeline.logs.read import read_log
from pipeline.logs.write import csv_rows

HEADER = "time_s,acc_x,acc_y,acc_z,gyr_x,gyr_y,gyr_z,temperature_c"
ROWS = [f"{i / 100:.2f},{i},-{i},{7 * i},3,2,{i % 5},25.0" for i in range(30)]
TEXT = "\n".join([HEADER, *ROWS]) + "\n"
PIECES = [
    "", ",", ";", "\t", "|", '"', "'", "#", "nan", "inf", "1e999", "-", "1_0", "\0", "\r", "\n",
    "\ufeff", "\x1b[2J", "\u2028", "\uff19", "12:30:00", "2024-01-01", "1,5", "\xe9", "{", "[",
    "PK\x03\x04", "time_s", "acc_x", "//", "%", " ", "=1+1", "0x1F", "NULL", "+", "e", ".",
]


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("read")


def read_or_refuse(folder: Path, data: bytes) -> None:
    """A log of finite numbers whose time goes forward, or an expected error."""
    path = folder / "log.csv"
    path.write_bytes(data)
    try:
        log = read_log(path)
    except (UnreadableInput, UnusableLog):
        return
    assert np.isfinite(log.time_s).all()
    assert (np.diff(log.time_s) > 0).all()


@settings(max_examples=300, deadline=None)
@given(data=st.binary(max_size=300))
def test_any_bytes_are_a_log_or_refused(folder: Path, data: bytes) -> None:
    read_or_refuse(folder, data)


@settings(max_examples=400, deadline=None)
@given(edits=st.lists(st.tuples(st.integers(0, len(TEXT)), st.integers(0, 8),
                                st.sampled_from(PIECES)), min_size=1, max_size=4),
       packed=st.booleans())
def test_an_edited_log_is_a_log_or_refused(
    folder: Path, edits: list[tuple[int, int, str]], packed: bool
) -> None:
    text = TEXT
    for at, length, piece in edits:
        text = text[:at] + piece + text[at + length :]
    data = text.encode()
    read_or_refuse(folder, gzip.compress(data) if packed else data)


@settings(max_examples=100, deadline=None)
@given(cut=st.integers(0, 400), flipped=st.integers(0, 400))
def test_a_damaged_gzip_is_a_log_or_refused(folder: Path, cut: int, flipped: int) -> None:
    data = bytearray(gzip.compress(TEXT.encode()))
    if flipped < len(data):
        data[flipped] ^= 0x55
    read_or_refuse(folder, bytes(data[: max(2, len(data) - cut)]))


@settings(max_examples=60, deadline=None)
@given(values=st.lists(st.lists(st.integers(-(2**31), 2**31), min_size=6, max_size=6),
                       min_size=12, max_size=30))
def test_what_was_written_is_read_back(folder: Path, values: list[list[int]]) -> None:
    table = np.array(values, float)
    time_s = np.arange(len(table)) / 100
    names = ["time_s", "acc_x", "acc_y", "acc_z", "gyr_x", "gyr_y", "gyr_z"]
    rows = b"".join(csv_rows([time_s, *table.T], [2] + [0] * 6))
    (folder / "log.csv").write_bytes(",".join(names).encode() + b"\n" + rows)
    log = read_log(folder / "log.csv")
    assert np.array_equal(np.hstack([log.accelerometer, log.gyroscope]), table)
    assert log.time_s == pytest.approx(time_s)
