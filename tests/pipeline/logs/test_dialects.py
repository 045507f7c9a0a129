"""Text tables as other people's tools write them: every dialect gives the same readings."""

from pathlib import Path

import numpy as np
import pytest

from pipeline.errors import UnreadableInput
from pipeline.logs.clock import StatedClock
from pipeline.logs.columns import Renamed, TimeUnit
from pipeline.logs.head import find_head
from pipeline.logs.read import read_log
from pipeline.logs.source import decimal_numbers
from pipeline.logs.text import raw_text

TIME_S = np.array([0.0, 0.01, 0.02, 0.03])
ACC = np.array([[0.125, -9.5, 1.75], [0.25, -9.25, 1.5], [0.375, -9.0, 1.25], [0.5, -8.75, 1.0]])


def write(folder: Path, text: str, encoding: str = "utf-8") -> Path:
    path = folder / "log.csv"
    path.write_bytes(text.encode(encoding))
    return path


def rows(delimiter: str, *, comma: bool = False, times: list[str] | None = None) -> str:
    lines = []
    for i, (t, acc) in enumerate(zip(TIME_S, ACC, strict=True)):
        cells = [times[i] if times else f"{t:g}", *(f"{value:g}" for value in acc)]
        lines.append(delimiter.join(cell.replace(".", ",") if comma else cell for cell in cells))
    return "\n".join(lines) + "\n"


HEAD = "time_s,acc_x,acc_y,acc_z\n"
DIALECTS = {
    "semicolons and decimal commas": HEAD.replace(",", ";") + rows(";", comma=True),
    "tabs and decimal commas": HEAD.replace(",", "\t") + rows("\t", comma=True),
    "blanks and decimal commas": HEAD.replace(",", " ") + rows(" ", comma=True),
    "blanks in the names and decimal commas": (
        "  Time [s]  Accel. X [g]  Accel. Y [g]  Accel. Z [g]\n" + rows("    ", comma=True)),
    "bars": HEAD.replace(",", "|") + rows("|"),
    "quoted decimal commas": HEAD + "".join(
        '"' + line.replace(";", '","') + '"\n' for line in rows(";", comma=True).splitlines()),
    "a trailing semicolon": HEAD.replace(",", ";") + rows(";", comma=True).replace("\n", ";\n"),
    "a trailing blank": "# time_s acc_x acc_y acc_z \n" + rows(" ").replace("\n", " \n"),
    "units below the header": HEAD + "s,m/s²,m/s²,m/s²\n" + rows(","),
    "milliseconds": HEAD.replace("time_s", "time_ms") + rows(",", times=["0", "10", "20", "30"]),
    "a comma only in a later row": "time_s;acc_x;acc_y;acc_z\n" + rows(";", comma=True),
}


@pytest.mark.parametrize("text", DIALECTS.values(), ids=DIALECTS)
@pytest.mark.parametrize("encoding", ["utf-8", "utf-16"])
def test_a_dialect_reads_as_any_other(tmp_path: Path, text: str, encoding: str) -> None:
    log = read_log(write(tmp_path, text, encoding))
    np.testing.assert_allclose(log.time_s, TIME_S, atol=1e-12)
    np.testing.assert_array_equal(log.accelerometer, ACC)


def test_a_header_in_the_signs_of_windows_is_read(tmp_path: Path) -> None:
    path = write(tmp_path, "Zeit (s);ax (m/s²);ay (m/s²);az (m/s²)\n" + rows(";", comma=True),
                 "cp1252")
    picked = Renamed((("time_s", "Zeit (s)"), ("acc_x", "ax (m/s²)"), ("acc_y", "ay (m/s²)"),
                      ("acc_z", "az (m/s²)")))
    with pytest.raises(UnreadableInput, match=r"picks 'ax .m/s.2.', but the columns are Zeit"):
        read_log(path, Renamed((("acc_x", "ax (m/s^2)"), ("acc_y", "b"), ("acc_z", "c"))))
    np.testing.assert_array_equal(read_log(path, picked).accelerometer, ACC)


@pytest.mark.parametrize("times", [
    ["2024-12-31 23:59:59.98", "2024-12-31 23:59:59.99", "2025-01-01 00:00:00",
     "2025-01-01 00:00:00.01"],
    ["2024-12-31T23:59:59.980Z", "2024-12-31T23:59:59.990Z", "2025-01-01T00:00:00.000Z",
     "2025-01-01T00:00:00.010Z"],
    ["23:59:59.98", "23:59:59.99", "00:00:00.00", "00:00:00.01"],
    ["11:59:59.98 PM", "11:59:59.99 PM", "12:00:00.00 AM", "12:00:00.01 AM"],
    ["31.12.2024 11:00:00.00", "31.12.2024 11:00:00.01", "31.12.2024 11:00:00.02",
     "31.12.2024 11:00:00.03"],
    ["2024/12/31/11:00:00.00", "2024/12/31/11:00:00.01", "2024/12/31/11:00:00.02",
     "2024/12/31/11:00:00.03"],
    ["31/Dec/2024 23:59:59.98", "31/Dec/2024 23:59:59.99", "1. January 2025 00:00:00.00",
     "1. January 2025 00:00:00.01"],
], ids=["date", "ISO 8601", "time of the day", "am and pm", "local date", "a slash", "a month"])
def test_dates_and_times_of_the_day_are_seconds(tmp_path: Path, times: list[str]) -> None:
    log = read_log(write(tmp_path, HEAD + rows(",", times=times)))
    np.testing.assert_allclose(log.time_s - log.time_s[0], TIME_S, atol=1e-6)
    np.testing.assert_array_equal(log.accelerometer, ACC)


def test_a_local_date_that_changes_is_refused(tmp_path: Path) -> None:
    times = ["3/4/2024 23:59:59.98", "3/4/2024 23:59:59.99", "4/4/2024 00:00:00.00",
             "4/4/2024 00:00:00.01"]
    with pytest.raises(UnreadableInput, match=r"log.csv:4: the date changes .*2024-12-31"):
        read_log(write(tmp_path, HEAD + rows(",", times=times)))


def test_commas_that_may_separate_thousands_are_refused(tmp_path: Path) -> None:
    text = "time_s;acc_x;acc_y;acc_z\n" + "".join(f"{i};16,384;16,{i}84;1,384\n" for i in (1, 2, 3))
    with pytest.raises(UnreadableInput, match="may be a decimal comma or separate thousands"):
        read_log(write(tmp_path, text))


def test_columns_are_picked_by_the_names_in_the_file(tmp_path: Path) -> None:
    head = "Timestamp,Accel X (g),Accel Y (g),Accel Z (g),acc_x,note,time_s\n"
    text = head + "".join(f"{1000 + 10 * i},0,{i},1,999,4,7\n" for i in range(4))
    picked = Renamed((("time_ms", "Timestamp"), ("acc_x", "Accel X (g)"), ("acc_y", "Accel Y (g)"),
                      ("acc_z", "Accel Z (g)")))
    log = read_log(write(tmp_path, text), picked)
    np.testing.assert_allclose(log.time_s, 1 + 0.01 * np.arange(4))
    np.testing.assert_array_equal(log.accelerometer[3], [0, 3, 1])
    assert list(log.columns) == ["note"]


def test_an_axis_that_reads_gravity_has_the_sign_of_the_specific_force(tmp_path: Path) -> None:
    names = ("time_s", *(f"minus_acc_{axis}" for axis in "xyz"))
    log = read_log(write(tmp_path, rows(",")), names)
    np.testing.assert_array_equal(log.accelerometer, -ACC)


def test_a_log_at_one_kilohertz_in_milliseconds_is_not_one_of_an_hour(tmp_path: Path) -> None:
    """One row a second alone would be slow and possible."""
    path = write(tmp_path, HEAD + "".join(f"{i},1,2,3\n" for i in range(3000)))
    with pytest.raises(UnreadableInput, match=r"makes no sense.*`time_unit: ms`"):
        read_log(path)


@pytest.mark.parametrize(("scale", "unit"), [(1e3, "ms"), (1e6, "us"), (1e9, "ns")])
def test_a_clock_that_makes_no_sense_names_the_likely_unit(
    tmp_path: Path, scale: float, unit: TimeUnit
) -> None:
    text = HEAD + "".join(f"{0.01 * i * scale:g},1,2,3\n" for i in range(300))
    path = write(tmp_path, text)
    with pytest.raises(UnreadableInput, match=f"makes no sense.*`time_unit: {unit}`") as caught:
        read_log(path)
    assert "\n" not in str(caught.value)
    log = read_log(path, clock=StatedClock(unit=unit))
    np.testing.assert_allclose(np.diff(log.time_s), 0.01, rtol=1e-6)
    # A unit that is stated settles it, whatever the rate.
    slow = read_log(path, clock=StatedClock(unit="s"))
    np.testing.assert_allclose(np.diff(slow.time_s), 0.01 * scale, rtol=1e-6)


@pytest.mark.parametrize("period", [2**16, 2**32, 2**24, 2**8])
def test_a_counter_that_wraps_goes_on(tmp_path: Path, period: int) -> None:
    ticks = (period - 25 + 10 * np.arange(6)) % period
    text = HEAD.replace("time_s", "time_ms") + "".join(f"{t},1,2,3\n" for t in ticks)
    log = read_log(write(tmp_path, text))
    np.testing.assert_allclose(np.diff(log.time_s), 0.01)


def test_a_step_back_that_is_no_wrap_is_refused(tmp_path: Path) -> None:
    text = HEAD + "0,1,2,3\n0.01,1,2,3\n0.02,1,2,3\n0.005,1,2,3\n0.03,1,2,3\n"
    with pytest.raises(UnreadableInput, match=r"log.csv:5: time does not increase"):
        read_log(write(tmp_path, text))


def test_poses_at_rest_need_no_clock_and_others_do(tmp_path: Path) -> None:
    path = write(tmp_path, "acc_x,acc_y,acc_z\n" + "1,2,3\n" * 5)
    assert len(read_log(path, clock=StatedClock(needed=False)).time_s) == 5
    with pytest.raises(UnreadableInput, match="no sample rate is known"):
        read_log(path)


def test_the_bar_between_two_words_of_a_cell_separates_no_columns(tmp_path: Path) -> None:
    head = HEAD.replace("\n", ",mode\n")
    flags = rows(",").replace("\n", ",ANGLE_MODE|ARM\n")
    np.testing.assert_array_equal(read_log(write(tmp_path, head + flags)).accelerometer, ACC)


def test_a_row_of_units_may_hold_one_that_nobody_knows() -> None:
    lines = ["clock;one;two;three;four", "ms;mg;mg;mg;local_flux", "1;2;3;4;5", "2;2;3;4;5"]
    assert (find_head(lines).names or [])[-2:] == ["three (mg)", "four (local_flux)"]


def test_the_dates_of_a_query_are_no_clock_beside_that_of_the_sample(tmp_path: Path) -> None:
    """InfluxDB writes the bounds of the query before the time."""
    lines = ["_start,_time,ax,ay,az", *(f"2024-05-05T12:00:00Z,2024-05-05T14:00:0{i}Z,1,2,3"
                                        for i in range(4))]
    text = raw_text(tmp_path / "influx.csv", lines)
    assert text is not None
    assert text.dated == 1


def test_a_line_of_any_number_of_registers_is_read() -> None:
    """A line like those of a binary log; a search from every word to the end took an hour."""
    words = decimal_numbers(" ".join(["00A0"] * 100_000)).split()
    assert (len(words), words[-3:]) == (100_000, ["160", "160", "160"])
    row = decimal_numbers("\n".join(["17 00A0 FF00 0B07"] * 20))
    assert row.split("\n")[0] == "17 160 -256 2823"  # the last three of each line
