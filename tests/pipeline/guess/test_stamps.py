"""Stamps that come twice: of whole seconds, and of rows that a logger has written twice."""

from pathlib import Path

import numpy as np
import pytest

from pipeline.guess.clocks import guess_clock
from pipeline.guess.config_text import Choices, config_text
from pipeline.guess.files import guess_files
from pipeline.guess.raw_tables import RawTable
from pipeline.guess.session import guess_session
from pipeline.guess.table_guess import TableGuess
from pipeline.logs.read import read_log
from tests.pipeline.guess.corpus import READ
from tests.pipeline.guess.hand_log import hand_log

NAMES = ("ax", "ay", "az", "gx", "gy", "gz")


def guessed(path: Path, stamp: str, columns: list[np.ndarray], digits: str) -> TableGuess:
    np.savetxt(path, np.column_stack(columns), [digits, *["%.5f"] * 6], ",", comments="",
               header=",".join((stamp, *NAMES)))
    (guess,), _ = guess_files([path], None)
    return guess


@pytest.mark.parametrize("rate_hz", [12.5, 50.0, 104.0])
@pytest.mark.parametrize(("first", "rows"), [(0.0, 500), (0.37, 500), (0.99, 777)])
def test_stamps_of_whole_seconds_give_the_rate_between_their_changes(
    tmp_path: Path, rate_hz: float, first: float, rows: int
) -> None:
    """The seconds at both ends are not whole ones: 500 rows at 50 Hz read 55 Hz."""
    log = hand_log()
    seconds = np.floor(1.7e9 + first + np.arange(rows) / rate_hz)
    table = guessed(tmp_path / "log.csv", "time (s)", [seconds, log.acc[:rows], log.gyr[:rows]],
                    "%d")
    assert table.clock.rate_hz == pytest.approx(rate_hz, rel=0.5 / (rows / rate_hz - 2) / rate_hz
                                                + 1e-3)


@pytest.mark.parametrize(("since", "rate_hz"), [(1.7e9, 5.0), (1.7e9, 1.0), (0.0, 5.0)])
def test_a_slow_log_counts_in_seconds(since: float, rate_hz: float) -> None:
    """Five rows per unit of the time are no 5 kHz in ms where that is usual of seconds too."""
    times = since + np.arange(1, 1000) / rate_hz
    assert guess_clock({"ts": times, "ax": times, "ay": times}, None, None).unit == "s"


def test_a_clock_has_the_unit_of_its_name_and_the_reason_is_the_step_of_its_rows() -> None:
    times = 20.0 * np.arange(1000)
    assert guess_clock({"time_ms": times, "ax": times, "ay": times}, None, None).unit == "ms"
    clock = guess_clock({"t": 1000 * times, "ax": times, "ay": times}, None, None)
    assert (clock.unit, clock.because) == ("us", "rows 20000 apart")


def test_a_slow_log_is_in_the_seconds_of_its_name_where_it_is_no_longer_than_poses() -> None:
    for rows, unit in ((60, "s"), (20_000, "ms")):  # of 1 Hz, and of 1 kHz under a wrong name
        columns = {"time_s": np.arange(rows, dtype=float), "ax": np.zeros(rows)}
        assert guess_clock(columns, None, None).unit == unit


def test_a_clock_that_stands_still_is_told(tmp_path: Path) -> None:
    """It is there: that the file holds no times would not be true."""
    log = hand_log()
    stopped = np.full(len(log.acc), 12.5)
    table = guessed(tmp_path / "log.csv", "time_s", [stopped, log.acc, log.gyr], "%.3f")
    assert table.clock.rate_hz == pytest.approx(100, rel=0.02)
    assert table.clock.doubt.startswith(
        "'time_s' reads 12.5 in every row, a clock that stands still; ")
    clock = guess_clock({"time_s": stopped, "ax": stopped, "ay": stopped}, None, None)
    assert "stands still, and nothing states the sample rate" in clock.doubt
    assert table.further == []  # told once


@pytest.mark.parametrize("comma", [".", ","])
def test_minutes_and_seconds_with_a_fraction_are_times(tmp_path: Path, comma: str) -> None:
    log = hand_log()
    rows = [";".join([f"{int(t // 60):02d}:{t % 60:06.3f}", *(f"{v:.5f}" for v in (*a, *w))])
            for t, a, w in zip(log.time_s + 50, log.acc, log.gyr, strict=True)]
    path = tmp_path / "log.csv"
    path.write_text("\n".join([";".join(("tijd", *NAMES)), *rows]).replace(".", comma), "utf-8")
    (guess,), _ = guess_files([path], None)
    np.testing.assert_allclose(guess.clock.time_s, log.time_s + 50)


def test_stamps_of_rows_in_another_order_are_times() -> None:
    """A receiver of packets writes some rows in the wrong order, under any name."""
    stamps = 1.7e9 + np.arange(1000) / 100
    swapped = np.arange(50, 950, 90)
    stamps[[*swapped, *(swapped + 1)]] = stamps[[*(swapped + 1), *swapped]]
    clock = guess_clock({"packet": np.arange(1000.0), "received": stamps, "ax": stamps % 7}, None,
                        None)
    assert clock.doubt == "'received' repeats or goes back 10 times, so it is not used"
    assert clock.unused == "received"
    assert clock.rate_hz == pytest.approx(100, rel=1e-3)


def test_a_column_without_a_name_beside_others_with_one_is_no_cause() -> None:
    """The zone behind a time of the day is a number too."""
    columns = {name: np.arange(9.0) for name in ("t", "2", "ax", "fan")}
    clock = guess_clock(columns, None, None)
    table = TableGuess(RawTable(Path("log.csv"), columns), clock, None, None, {"acc_x": "ax"},
                       False)
    assert table.further == ["fan"]


def test_rows_that_repeat_the_one_before_are_no_samples_and_the_clock_is_used(
    tmp_path: Path
) -> None:
    log = hand_log()
    times = 1 + (np.random.default_rng(2).random(len(log.time_s)) < 0.07)
    columns = [np.repeat(values, times, axis=0) for values in (
        1000 * log.time_s, log.acc, log.gyr)]
    table = guessed(tmp_path / "log.csv", "timestamp_ms", columns, "%d")
    assert (table.clock.column, table.table.rows) == ("timestamp_ms", len(log.time_s))
    ours = tmp_path / "ours.csv"
    np.savetxt(ours, np.column_stack(columns), "%.5f", ",", comments="", header="time_ms,acc_x,"
               "acc_y,acc_z,gyr_x,gyr_y,gyr_z")
    read = read_log(ours)
    np.testing.assert_allclose(read.time_s, log.time_s, atol=1e-9)
    assert read.notes == (f"rows that repeat those before and are left out: "
                          f"{times.sum() - len(times)} of {times.sum()}",)


@pytest.mark.parametrize("names", ["header.stamp.secs,header.stamp.nsecs", "sec,nanosec"])
def test_seconds_beside_their_parts_show_a_pause_of_seconds(tmp_path: Path, names: str) -> None:
    """A pause of seconds, which the parts alone would make 0.02 s long."""
    ticks = 20_000_000 * np.arange(200)
    ticks[100:] += 3_000_000_000
    rows = [f"{1_772_355_001 + tick // 10**9},{tick % 10**9},{','.join(map(str, acc))}"
            for tick, acc in zip(ticks.tolist(), hand_log().acc, strict=False)]
    path = tmp_path / "stamps.csv"
    path.write_text("\n".join([f"{names},ax,ay,az", *rows]), encoding="utf-8")
    (table,), _ = guess_files([path], None)
    assert np.ptp(table.clock.time_s) == pytest.approx(199 * 0.02 + 3.0)
    log = table.log()
    assert log is not None
    assert np.ptp(log.time_s) == pytest.approx(199 * 0.02 + 3.0)


def test_stamps_out_of_place_make_no_other_rate_and_leave_the_others_their_times(
    tmp_path: Path,
) -> None:
    log = hand_log(rests=8, rate_hz=100.0)
    table = np.column_stack([log.time_s, log.acc, log.gyr])
    for i in range(8):
        rows = table[log.rest == i]
        rows[[90, 110, 130] if i == 3 else [], 0] = rows[0, 0] + 0.1
        np.savetxt(tmp_path / f"p{i}.csv", rows, "%.5f", ",", comments="",
                   header=",".join(("t", *NAMES)))
    guess = guess_session(guess_files(sorted(tmp_path.glob("*.csv")), None)[0])
    assert guess.tables[3].clock.rate_hz == pytest.approx(100.0, rel=0.03)
    assert "sample_rate_hz" not in config_text(guess, tmp_path, Choices())


def test_the_period_of_samples_above_the_columns_is_the_clock(tmp_path: Path) -> None:
    log = hand_log(rests=8, rate_hz=50.0)
    np.savetxt(tmp_path / "log.csv", np.column_stack([log.acc, log.gyr]), "%.5f", ",", comments="",
               header="Sample interval: 20 ms\n" + ",".join(NAMES))
    (guess,), _ = guess_files([tmp_path / "log.csv"], None)
    assert guess.clock.rate_hz == pytest.approx(50.0)


def test_a_doubt_is_told_once_whatever_its_numbers(tmp_path: Path) -> None:
    """Each file of a card ends within a line, each at another one."""
    log = hand_log(rests=8, rate_hz=25.0)
    table = np.column_stack([log.time_s, log.acc, log.gyr])
    for i in range(8):
        np.savetxt(tmp_path / f"p{i}.csv", table[log.rest == i][i:], "%.5f", ",", comments="",
                   header=",".join(("t", *NAMES)), footer="0.1,0.2")
    doubts = guess_session(guess_files(sorted(tmp_path.glob("*.csv")), None)[0]).doubts
    assert [doubt.partition(":")[0] for doubt in doubts if "no samples" in doubt] == [
        "p0.csv and 7 more"]


def test_a_pause_in_a_long_log_is_told_with_its_place(tmp_path: Path) -> None:
    log = hand_log(rests=8, rate_hz=50.0)
    time_s = log.time_s + np.where(log.time_s >= 9.0, 4.0, 0.0) + np.where(log.time_s >= 12, 2.0, 0)
    np.savetxt(tmp_path / "log.csv", np.column_stack([time_s, log.acc, log.gyr]), "%.5f", ",",
               comments="", header=",".join(("t", *NAMES)))
    (table,), _ = guess_files([tmp_path / "log.csv"], None)
    assert [doubt for doubt in table.doubts if "pauses 2 times" in doubt
            and "6.04 s in all" in doubt and "after 8.98 s and lasts 4.02 s" in doubt]


def test_numbers_in_the_properties_above_are_no_readings_and_state_the_rate(tmp_path: Path) -> None:
    log = hand_log(rate_hz=50.0)
    ((guess,), _) = guess_files(READ["properties_above"](tmp_path, log).files, None)
    assert guess.table.rows == len(log.time_s)
    assert (guess.clock.rate_hz, guess.clock.because) == (50.0, "the file's head")


def test_a_rate_that_grows_by_chance_between_wraps_of_a_counter_is_no_clock() -> None:
    """The means of eighteen poses, of which the first and the last were lost as well."""
    rate = [2.131, -18.3426, 11.2402, -11.3931, 198.4797, -200.3373, 18.6335, -42.3976, -7.8599,
            1.8846, 147.9787, -146.5154, 148.183, -132.5059, 139.9761, -135.5463, 147.0632]
    columns = {name: np.array(values) for name, values in (
        ("pose", range(1, 18)), ("wz [°/s]", rate), ("wy", rate[::-1]), ("wx", rate[5:] + rate[:5]),
        ("ax", rate))}
    assert guess_clock(columns, None, None).column is None
