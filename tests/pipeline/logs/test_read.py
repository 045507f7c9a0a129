"""Logs: every readable form gives the same readings, every fault is named with its line."""

import gzip
from pathlib import Path

import numpy as np
import pytest

from calib.errors import UnusableLog
from calib.poses.imu_log import ImuLog
from pipeline.errors import UnreadableInput
from pipeline.logs.clock import StatedClock
from pipeline.logs.join import join_logs
from pipeline.logs.read import read_log
from tests.paths import REAL

TABLE = np.array([[0.00, 33108, 33329, 36429, 32786, 32429, 32499],
                  [0.01, 33109, 33330, 36430, 32787, 32430, 32500],
                  [0.02, 33110, 33331, 36431, 32788, 32431, 32501]])
NAMES = ["time_s", "acc_x", "acc_y", "acc_z", "gyr_x", "gyr_y", "gyr_z"]
HEAD = "time_s,acc_x,acc_y,acc_z\n"


def as_text(delimiter: str, header: str | None = None) -> str:
    rows = [delimiter.join(f"{value:g}" for value in row) for row in TABLE]
    return "\n".join([delimiter.join(NAMES) if header is None else header, *rows]) + "\n"


def write(folder: Path, content: str | bytes, name: str = "pose.csv") -> Path:
    path = folder / name
    path.write_bytes(content.encode() if isinstance(content, str) else content)
    return path


@pytest.mark.parametrize("content", [
    as_text(","), as_text(";"), as_text("\t"), as_text(" "), as_text(", "), as_text("   "),
    "\ufeff" + as_text(","), as_text(",").replace("\n", "\r\n"), as_text(",").rstrip(),
    "# a comment\n\n// another\n" + as_text(","), "# " + as_text(","),
    as_text(",").replace("\n0.01", "\n# in between\n\n0.01"),
    as_text(",").replace("\n", ",\n"),
    as_text(",", ",".join(f'"{name}"' for name in NAMES)),
    as_text("\t", "\t".join(name.title() if name != "time_s" else name for name in NAMES)),
    "Fs,100\nLogging Type,0\n" + as_text(","),
    gzip.compress(as_text(",").encode(), mtime=0),
])
def test_every_form_of_the_same_log_reads_the_same(tmp_path: Path, content: str | bytes) -> None:
    log = read_log(write(tmp_path, content))
    np.testing.assert_array_equal(log.time_s, TABLE[:, 0])
    np.testing.assert_array_equal(log.accelerometer, TABLE[:, 1:4])
    np.testing.assert_array_equal(log.gyroscope, TABLE[:, 4:])
    assert log.label == "pose.csv"


def test_columns_name_what_a_file_without_a_header_holds(tmp_path: Path) -> None:
    path = write(tmp_path, as_text(" ").split("\n", 1)[1])
    log = read_log(path, ["time_s", "gyr_x", "gyr_y", "gyr_z", "skip", "supply_v", "skip"])
    np.testing.assert_array_equal(log.gyroscope, TABLE[:, 1:4])
    assert not log.has("accelerometer")
    np.testing.assert_array_equal(log.columns["supply_v"], TABLE[:, 5])
    assert list(log.columns) == ["supply_v"]


def test_columns_replace_a_header(tmp_path: Path) -> None:
    path = write(tmp_path, as_text(",", "a,b,c,d,e,f,g"))
    np.testing.assert_array_equal(read_log(path, NAMES).gyroscope, TABLE[:, 4:])


def test_every_further_numeric_column_is_kept_and_text_is_not(tmp_path: Path) -> None:
    path = write(tmp_path, "part,time_s,acc_x,acc_y,acc_z,temperature_c,supply_v\n"
                           "x_a,0,1,2,3,25.5,nan\nx_b,1,1,2,3,26.5,3.3\n")
    log = read_log(path)
    assert set(log.columns) == {"temperature_c", "supply_v"}
    np.testing.assert_array_equal(log.columns["temperature_c"], [25.5, 26.5])
    np.testing.assert_array_equal(log.columns["supply_v"], [np.nan, 3.3])


def test_a_sample_rate_stands_for_the_time(tmp_path: Path) -> None:
    path = write(tmp_path, "ax,ay,az\n1,2,3\n1,2,3\n1,2,3\n")
    np.testing.assert_allclose(read_log(path, clock=StatedClock(50)).time_s, [0, 0.02, 0.04])


def test_mt_manager_time_counts_lost_packets_over_the_counter_s_wrap(tmp_path: Path) -> None:
    head = "// Start Time: Unknown\n// Update Rate: 100.0Hz\nPacketCounter\tAcc_X\tAcc_Y\tAcc_Z\n"
    path = write(tmp_path, head + "65534\t1\t2\t3\n65535\t1\t2\t3\n1\t1\t2\t3\n")
    np.testing.assert_allclose(read_log(path).time_s, [0, 0.01, 0.03])


def test_mt_manager_fine_time_ticks_at_10_khz(tmp_path: Path) -> None:
    path = write(tmp_path, "PacketCounter\tSampleTimeFine\tAcc_X\tAcc_Y\tAcc_Z\tRoll\n"
                           "7\t10000\t1\t2\t3\tNaN\n8\t10100\t1\t2\t3\tNaN\n")
    np.testing.assert_allclose(read_log(path).time_s, [1.0, 1.01])


FAULTS = [
    ("", "pose.csv: the file is empty"),
    (HEAD, "no row of numbers below the header"),
    (HEAD + "0,1,2,3\n1,1,2\n2,1,2,3\n", "pose.csv:3: 3 values found, 4 expected"),
    (HEAD + "0,1,2,3\n1,1,2,3,4\n2,1,2,3\n", "pose.csv:3: 5 values found, 4 expected"),
    (HEAD + "0,1,2,3\n1,1,2\n", "pose.csv:3: 3 values found, 4 expected"),
    (HEAD + "0,1,2,3\n1,one,2,3\n", "pose.csv:3: column acc_x: found 'one', a number"),
    (HEAD + "0,a,b,c\n1,1,2,3\n2,1,2,3\n", "pose.csv:2: column acc_x: found 'a'"),
    (HEAD + "0,1,2,3\n1,,2,3\n", "pose.csv:3: column acc_x: found nan, a finite"),
    (HEAD + "0,1,2,3\n1,1_0,2,3\n", "pose.csv:3: column acc_x: found '1_0'"),
    (HEAD + "0,1,2,3\n# note\n\n1,nan,2,3\n", "pose.csv:5: column acc_x: found nan, a finite"),
    (HEAD + "0,1,2,3\n1,1,2,inf\n", "pose.csv:3: column acc_z: found inf"),
    (HEAD + "0,1,2,3\n\n2,1,2,3\n1,1,2,3\n", "pose.csv:5: time does not increase: 1 s after 2 s"),
    (HEAD + "0,1,2,3\n0,1,2,4\n", "pose.csv:3: time does not increase: 0 s after 0 s"),
    ("time_s,accx,acc_y,acc_z\n0,1,2,3\n", "pose.csv:1: .*acc_x missing.*mean 'acc_x' for 'accx'"),
    ("a,b,c\n0,1,2\n", "pose.csv:1: found a, b, c: neither acc_x"),
    ("when,acc_x,acc_y,acc_z\n0,1,2,3\n", "no column time_s .columns: when, acc_x"),
    ("time_s,acc_x,acc_y,acc_z,acc_x\n0,1,2,3,4\n", "'acc_x' is there twice"),
    ("0,1,2,3\n1,1,2,3\n", "pose.csv:1: 4 columns of numbers without a header.*columns: .time_s"),
    (HEAD.encode() + b"0,1,2,3\n1,1,\xff,3\n", "pose.csv:3: byte 0xff is not text"),
    (b"\x00\x01\x02" * 50, "pose.csv:1: byte 0x00 is not text"),
    (gzip.compress(as_text(",").encode() * 9, mtime=0)[:-12],
     "compressed file is damaged or cut off"),
    (gzip.compress(as_text(",").encode(), mtime=0)[:20] + b"xxxxxxxxxxxxxxxxx",
     "damaged or cut off"),
]


@pytest.mark.parametrize(("content", "says"), FAULTS)
def test_a_fault_is_named_in_one_paragraph(
    tmp_path: Path, content: str | bytes, says: str
) -> None:
    with pytest.raises(UnreadableInput, match=says) as caught:
        read_log(write(tmp_path, content))
    assert "\n" not in str(caught.value)
    assert caught.value.exit_code == 3


def test_rows_that_skip_columns_are_still_counted(tmp_path: Path) -> None:
    path = write(tmp_path, "part,time_s,acc_x,acc_y,acc_z\na,0,1,2,3\nb,1,1,9,2,3\n")
    with pytest.raises(UnreadableInput, match=r"pose.csv:3: 6 values found, 5 expected"):
        read_log(path)


@pytest.mark.parametrize(("odd", "kept"), [
    ("{row}\n40,inf,2,3\n", 40),
    ("{row}\n40,EVENT,button,\n", 40), ("{row}\nmarker 3,1\n", 40), ("{row}\n40,x,2,3,,,\n", 40),
    ("{cut}", 39)], ids=["inf", "event", "marker", "other width", "last line cut off"])
def test_few_rows_that_are_no_samples_are_left_out_and_told(
    tmp_path: Path, odd: str, kept: int
) -> None:
    rows = [f"{i},{i % 7},2,3" for i in range(40)]
    whole = "\n".join([HEAD.strip(), *rows[:-1], odd.format(row=rows[-1], cut=rows[-1][:-2])])
    read = read_log(write(tmp_path, whole))
    np.testing.assert_array_equal(read.accelerometer[:, 0], np.arange(kept) % 7)
    assert read.notes == (f"rows that lack a reading and are left out: 1 of {kept + 1}",)
    many = [row if i % 8 else f"{i},EVENT,button," for i, row in enumerate(rows)]
    with pytest.raises(UnreadableInput, match=r"csv:2: .*'EVENT', .* 5 of its 40 rows are no samp"):
        read_log(write(tmp_path, "\n".join([HEAD.strip(), *many])))


@pytest.mark.parametrize(("first", "last", "lost"), [
    (-1e9, 3.9, 1), (0, 1e11, 1), (-5, 1e300, 2), (-3, 7, 2), (-1.5, 5.5, 0), (2.5, 3.9, 1),
    (0, 2.2, 1)])
def test_a_row_at_an_end_whose_time_is_far_off_is_left_out_and_told(
    tmp_path: Path, first: float, last: float, lost: int
) -> None:
    times = [first, *np.arange(0.1, 3.85, 0.1), last]
    rows = [f"{time},{i % 7},2,3" for i, time in enumerate(times)]
    read = read_log(write(tmp_path, HEAD + "\n".join(rows)))
    assert len(read.time_s) == 40 - lost
    assert [note.rpartition(": ")[2] for note in read.notes] == [f"{lost} of 40"] * (lost > 0)


def test_a_missing_file_is_refused(tmp_path: Path) -> None:
    with pytest.raises(UnreadableInput, match=r"absent.csv: cannot be read"):
        read_log(tmp_path / "absent.csv")


def test_columns_that_do_not_fit_the_file_are_refused(tmp_path: Path) -> None:
    path = write(tmp_path, "0 1 2 3 4\n1 1 2 3 4\n")
    with pytest.raises(UnreadableInput, match="5 values found, 4 expected"):
        read_log(path, NAMES[:4])


def test_two_clocks_are_refused(tmp_path: Path) -> None:
    with pytest.raises(UnreadableInput, match="has time_s, and sample_rate_hz"):
        read_log(write(tmp_path, as_text(",")), clock=StatedClock(100))


def test_one_sample_is_no_log(tmp_path: Path) -> None:
    with pytest.raises(UnusableLog, match="1 sample"):
        read_log(write(tmp_path, HEAD + "0,1,2,3\n"))


# --- joining -----------------------------------------------------------------------------------


def log(label: str, time_s: np.ndarray, triad: str, **columns: np.ndarray) -> ImuLog:
    """A log whose axes are t, 2t and 3t."""
    readings = np.outer(time_s, [1.0, 2.0, 3.0])
    nothing = np.full_like(readings, np.nan)
    both = (readings, nothing) if triad == "accelerometer" else (nothing, readings)
    return ImuLog(label, time_s, *both, columns)


def test_equal_stamps_are_put_side_by_side() -> None:
    t = np.linspace(0, 1, 11)
    joined = join_logs([log("a", t, "accelerometer", supply_v=t), log("g", t, "gyroscope", x=-t)])
    np.testing.assert_array_equal(joined.accelerometer, joined.gyroscope)
    np.testing.assert_array_equal(joined.columns["x"], -t)
    np.testing.assert_array_equal(joined.columns["supply_v"], t)


def test_other_stamps_are_interpolated_within_the_overlap() -> None:
    a, g = np.arange(0, 10, 0.1), np.arange(2.005, 20, 0.07)
    for one, other, triad in ((log("a", a, "accelerometer"), log("g", g, "gyroscope"), "gyroscope"),
                              (log("g", a, "gyroscope"), log("a", g, "accelerometer"),
                               "accelerometer")):
        joined = join_logs([one, other])
        assert joined.time_s[0] == pytest.approx(2.1)
        assert joined.time_s[-1] == pytest.approx(9.9)
        np.testing.assert_allclose(getattr(joined, triad), np.outer(joined.time_s, [1, 2, 3]))


def test_a_pause_of_the_second_log_is_not_filled() -> None:
    t = np.arange(0, 10, 0.1)
    paused = t[(t < 4) | (t > 6)]
    joined = join_logs([log("a", t, "accelerometer"), log("g", paused, "gyroscope")])
    np.testing.assert_allclose(joined.time_s, paused)


def test_logs_without_common_time_are_refused() -> None:
    t = np.linspace(0, 1, 11)
    with pytest.raises(UnreadableInput, match=r"from 0 to 1 s .* 50 to 51 s; common time"):
        join_logs([log("a", t, "accelerometer"), log("g", t + 50, "gyroscope")])


def test_the_same_triad_twice_is_refused() -> None:
    t = np.linspace(0, 1, 11)
    with pytest.raises(UnreadableInput, match="both hold the gyroscope"):
        join_logs([log("a", t, "gyroscope"), log("g", t, "gyroscope")])


# --- real logs ---------------------------------------------------------------------------------


@pytest.mark.skipif(not REAL.exists(), reason="the shared real logs are not here")
def test_both_files_of_the_real_xsens_log_are_read_and_joined() -> None:
    folder = REAL / "imu_tk_xsens"
    accelerometer = read_log(folder / "xsens_acc.mat.gz", NAMES[:4])
    gyroscope = read_log(folder / "xsens_gyro.mat.gz", [NAMES[0], *NAMES[4:]])
    joined = join_logs([accelerometer, gyroscope])
    assert joined.accelerometer.shape == (51175, 3)
    np.testing.assert_array_equal(joined.accelerometer[0], [33108, 33329, 36429])
    np.testing.assert_array_equal(joined.gyroscope[0], [32786, 32429, 32499])


@pytest.mark.skipif(not REAL.exists(), reason="the shared real logs are not here")
def test_a_real_seven_column_log_is_not_taken_for_imu_tk_s() -> None:
    path = REAL / "nexus5_tyrex" / "calib_acc_d1_gyroscope.txt.gz"  # time, gyro, its bias estimate
    with pytest.raises(UnreadableInput, match="7 columns of numbers without a header"):
        read_log(path)
