"""Logs in our own form are parsed at once, and read as any other log is."""

import gzip
from pathlib import Path

import numpy as np
import pytest

from pipeline.errors import UnreadableInput
from pipeline.logs.formats.file_table import TextFile
from pipeline.logs.plain import plain_table
from pipeline.logs.read import read_log

HEADER = "time_s,acc_x,acc_y,acc_z,temperature_c,supply_v"
ROWS = [f"{0.01 * i:.3f},{i % 7},{-i % 5},{8192 + i % 3},{24 + 1e-3 * i:.3f},5.01"
        for i in range(60)]
WIDE = [f"{row},{i % 2 + 1}" for i, row in enumerate(ROWS)]


def written(*rows: str, header: str = HEADER) -> bytes:
    return "\n".join([header, *rows, ""]).encode()


def test_a_plain_log_is_read_as_it_is_line_by_line(tmp_path: Path) -> None:
    """The same log with a comment, and packed."""
    path, beside, packed = (tmp_path / name for name in ("a.csv", "b.csv", "c.csv.gz"))
    path.write_bytes(written(*ROWS))
    beside.write_bytes(b"# an evening\n" + written(*ROWS))
    packed.write_bytes(gzip.compress(written(*ROWS).replace(b"\n", b"\r\n")))
    assert plain_table(TextFile("", path.read_bytes())) is not None
    assert plain_table(TextFile("", beside.read_bytes())) is None
    logs = [read_log(each) for each in (path, beside, packed)]
    for log in logs[1:]:
        np.testing.assert_array_equal(log.time_s, logs[0].time_s)
        np.testing.assert_array_equal(log.accelerometer, logs[0].accelerometer)
        assert [*log.columns] == [*logs[0].columns] == ["temperature_c", "supply_v"]
        np.testing.assert_array_equal(log.columns["supply_v"], logs[0].columns["supply_v"])


@pytest.mark.parametrize(
    "data",
    [
        written(*ROWS[:30], "", *ROWS[30:]),  # an empty line
        written(*ROWS[:-1], ROWS[-1][:9]),  # the last line cut off
        written(*ROWS[:30], "0.30,ready", *ROWS[30:]),  # words of a sketch
        written(*(row.replace(",8192", ",8E12") for row in ROWS)),  # perhaps a register
        written(*(row.replace(",", ";") for row in ROWS), header=HEADER.replace(",", ";")),
        written(*WIDE, header=f"{HEADER},board"),  # two sensors that take turns
        written(*ROWS, header=HEADER.replace("supply_v", "stamp_ms")),  # another clock
        written(*ROWS, header=HEADER.replace("supply_v", "acc2_x")),  # another sensor
        written(*ROWS, header=HEADER.replace("time_s", "millis")),
        written(*ROWS, header=HEADER.replace("time_s", "counter")),  # times by a stated rate
        written(*ROWS, header=HEADER.replace("acc_z", "acc_x")),
        written(),
    ],
)  # fmt: skip
def test_a_log_that_leaves_a_question_is_not_plain(data: bytes) -> None:
    assert plain_table(TextFile("", data)) is None


def test_messages_name_the_line_of_a_plain_log(tmp_path: Path) -> None:
    path = tmp_path / "late.csv"
    late = ROWS[10].replace("0.100,3", "0.100,4")  # with its readings it would count once
    path.write_bytes(written(*ROWS[:20], late, *ROWS[20:]))
    with pytest.raises(UnreadableInput, match=r"late\.csv:\d+: "):
        read_log(path)
