"""``pipeline apply``: a log in counts becomes one in SI units, effects included."""

import gzip
import json
import math
import re
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from calib.errors import Undetermined, UnusableLog
from calib.poses.imu_log import ImuLog
from pipeline.export.apply import applied_csv, apply_results
from pipeline.export.parts import triad_named
from pipeline.logs.write import csv_rows
from pipeline.results.read import load_results
from tests.pipeline.conftest import RunSession
from tests.pipeline.export.stored_results import a_log, with_effects
from tests.sessions import pipeline, results_in


def test_the_corrected_log_is_eq_1_of_the_paper(finished: RunSession) -> None:
    stored, log = load_results(finished.folder), a_log()
    applied = apply_results(stored, log)
    for triad in ("accelerometer", "gyroscope"):
        given_by = results_in(finished.folder)[triad]["parameters"]
        x, y, z = given_by["misalignment_rad"]
        t = np.array([[1, z, y], [0, 1, x], [0, 0, 1]])
        k = np.diag(1 / np.array(given_by["scale_counts_per_unit"]))
        counts = getattr(log, triad) - given_by["bias_counts"]
        assert applied.triads[triad] == pytest.approx(counts @ (t @ k).T, abs=1e-10)


def test_the_command_writes_csv_with_units_in_its_header(
    finished: RunSession, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    log = finished.config.parent / "gyroscope/17rpm/pose_03.csv"
    out = tmp_path / "out.csv"
    assert pipeline("apply", finished.folder, log, "--output", out) == 0
    assert capsys.readouterr().out.strip() == str(out)
    header = out.read_text(encoding="utf-8").splitlines()[0]
    assert header == (
        "time_s,acc_x_m_s2,acc_y_m_s2,acc_z_m_s2,gyr_x_rad_s,gyr_y_rad_s,gyr_z_rad_s,"
        "temperature_c,saturated"
    )
    table = np.loadtxt(out, delimiter=",", skiprows=1)
    before = np.loadtxt(log, delimiter=",", skiprows=1)
    assert table[:, 0] == pytest.approx(before[:, 0])
    assert np.array_equal(table[:, 7], before[:, 7])
    # On the plate: gravity, and the rate that was stated.
    assert np.linalg.norm(table[:, 1:4].mean(axis=0)) == pytest.approx(9.803, abs=0.02)
    rate = results_in(finished.folder)["rate"]["17rpm"]["rate_rad_s"]
    assert np.linalg.norm(table[:, 4:7].mean(axis=0)) == pytest.approx(rate, rel=1e-3)


def test_without_an_output_the_csv_goes_to_standard_output(
    finished: RunSession, tmp_path: Path, capfdbinary: pytest.CaptureFixture[bytes]
) -> None:
    log = finished.config.parent / "accelerometer/pose_03.csv"
    packed = tmp_path / "pose_03.csv.gz"
    packed.write_bytes(gzip.compress(log.read_bytes()))
    assert pipeline("apply", finished.folder, log, "--output", tmp_path / "out.csv") == 0
    capfdbinary.readouterr()
    assert pipeline("apply", finished.folder, packed) == 0
    assert capfdbinary.readouterr().out == (tmp_path / "out.csv").read_bytes()


def test_an_effect_of_the_gyroscope_uses_the_corrected_accelerometer(
    finished: RunSession, tmp_path: Path
) -> None:
    g = np.arange(1, 10) * 1e-4
    stored = with_effects(finished, tmp_path, "gyroscope", {"g_sensitivity": g.tolist()})
    plain, better = (
        apply_results(each, a_log()) for each in (load_results(finished.folder), stored)
    )
    force = plain.triads["accelerometer"]
    gyroscope = triad_named(stored, "gyroscope")
    assert gyroscope is not None
    # G is of the sensitive axes; T of eq. (2) turns its error into the orthogonal ones.
    expected = plain.triads["gyroscope"] - force @ g.reshape(3, 3).T @ gyroscope.alignment.T
    assert better.triads["gyroscope"] == pytest.approx(expected, abs=1e-12)


def test_a_temperature_effect_follows_the_log_s_column(
    finished: RunSession, tmp_path: Path
) -> None:
    stored = with_effects(finished, tmp_path, "gyroscope", {"temperature_bias": [1.0, 0.0, 0.0]})
    warm = a_log(temperature_c=np.linspace(20, 40, 500))
    plain = apply_results(load_results(finished.folder), warm).triads["gyroscope"]
    better = apply_results(stored, warm).triads["gyroscope"]
    assert plain[:, 0] - better[:, 0] == pytest.approx(np.linspace(20, 40, 500) - 25)
    assert better[:, 1:] == pytest.approx(plain[:, 1:])


@pytest.mark.parametrize(
    ("effects", "says"),
    [
        ({"temperature_bias": [1.0, 0, 0]}, "temperature_bias, .* no column temperature_c"),
        ({"column:supply_v": [1.0, 0, 0]}, "column:supply_v, .* no column supply_v"),
    ],
)
def test_what_the_log_cannot_tell_is_refused_by_name(
    finished: RunSession, tmp_path: Path, effects: dict[str, list[float]], says: str
) -> None:
    stored = with_effects(finished, tmp_path, "accelerometer", effects)
    with pytest.raises(Undetermined, match=f"drive.csv: .* accelerometer contains {says}"):
        apply_results(stored, a_log())


def test_g_sensitivity_needs_an_accelerometer_in_the_log(
    finished: RunSession, tmp_path: Path
) -> None:
    stored = with_effects(finished, tmp_path, "gyroscope", {"g_sensitivity": [1e-4] * 9})
    log = a_log()
    alone = ImuLog("gyro.csv", log.time_s, np.full((500, 3), np.nan), log.gyroscope)
    with pytest.raises(Undetermined, match=r"g_sensitivity, .* Log the accelerometer too"):
        apply_results(stored, alone)


def test_a_drift_is_corrected_on_the_session_s_own_clock(
    finished: RunSession, tmp_path: Path
) -> None:
    stored = with_effects(finished, tmp_path, "accelerometer", {"bias_drift": [3600.0, 0, 0]})
    start = results_in(finished.folder)["session_start_s"]
    plain = apply_results(load_results(finished.folder), a_log()).triads["accelerometer"]
    better = apply_results(stored, a_log(), session_clock=True).triads["accelerometer"]
    assert plain[:, 0] - better[:, 0] == pytest.approx(np.arange(500) / 100 - start)


def test_errors_of_the_bench_stay_out_and_are_named(
    finished: RunSession, tmp_path: Path
) -> None:
    stored = with_effects(
        finished, tmp_path, "gyroscope", {"reference_offset": [0.1], "earth_rate": [1e-4]}
    )
    applied = apply_results(stored, a_log())
    plain = apply_results(load_results(finished.folder), a_log())
    assert np.array_equal(applied.triads["gyroscope"], plain.triads["gyroscope"])
    assert [says.split()[1] for says in applied.left_out] == ["reference_offset", "earth_rate"]


def test_an_effect_of_the_user_s_own_is_carried_by_its_expression(
    finished: RunSession, tmp_path: Path
) -> None:
    own = {"glow": {"expression": "supply_v", "python": None, "per": "axis", "unit": "m/s²/V"}}
    stored = with_effects(finished, tmp_path, "accelerometer", {"glow": [0.5, 0, 0]}, own)
    log = a_log(supply_v=np.full(500, 3.0))
    plain = apply_results(load_results(finished.folder), log).triads["accelerometer"]
    better = apply_results(stored, log).triads["accelerometer"]
    assert plain[:, 0] - better[:, 0] == pytest.approx(np.full(500, 1.5))


def test_what_a_log_does_not_hold_of_an_effect_s_past_is_said(
    finished: RunSession, tmp_path: Path
) -> None:
    own = {"late": {"expression": "lag(supply_v, 240)", "python": None, "per": "axis",
                    "unit": "m/s²/V"}}
    stored = with_effects(finished, tmp_path, "accelerometer", {"late": [0.5, 0, 0]}, own)
    [said] = apply_results(stored, a_log(supply_v=np.full(500, 3.0))).left_out
    assert said.startswith("accelerometer: late follows the past of supply_v, which drive.csv does")


def test_a_log_without_any_calibrated_triad_is_refused(
    finished: RunSession, tmp_path: Path
) -> None:
    found = results_in(finished.folder) | {"accelerometer": None}
    (tmp_path / "results.json").write_text(json.dumps(found), encoding="utf-8")
    log = a_log()
    alone = ImuLog("acc.csv", log.time_s, log.accelerometer, np.full((500, 3), np.nan))
    with pytest.raises(Undetermined, match="calibrates gyroscope, and the log has no such"):
        apply_results(load_results(tmp_path), alone)


# --- numbers as text ---------------------------------------------------------------------------


@settings(max_examples=60, deadline=None)
@given(
    st.lists(st.floats(-9e6, 9e6) | st.sampled_from([0.0, -0.0, 9999.9999, 1e4, 12345678.0]),
             min_size=1, max_size=20),
    st.integers(0, 8),
)
def test_numbers_are_written_as_python_writes_them(values: list[float], decimals: int) -> None:
    text = b"".join(csv_rows([np.array(values)], [decimals])).decode()
    scale = 10**decimals
    expected = [f"{round(value * scale) / scale:.{decimals}f}" for value in values]
    zero = f"{0:.{decimals}f}"
    assert text.split() == [zero if each == f"-{zero}" else each for each in expected]


def test_absent_numbers_are_empty_cells_and_columns_keep_their_decimals() -> None:
    columns = [np.array([1.0, 2.0]), np.array([math.nan, -123456789.25]), np.array([0.5, math.nan])]
    assert b"".join(csv_rows(columns, [0, 2, 3])) == b"1,,0.500\n2,-123456789.25,\n"


def test_blocks_join_without_a_seam() -> None:
    rows = np.arange(45_000.0)
    text = b"".join(csv_rows([rows, -rows], [0, 1]))
    table = np.loadtxt(text.decode().splitlines(), delimiter=",")
    assert np.array_equal(table, np.column_stack([rows, -rows]))


def test_a_time_stamp_in_nanoseconds_keeps_every_digit_that_a_float_has() -> None:
    assert b"".join(csv_rows([np.array([1.7e18])], [0])) == b"1700000000000000000\n"


@pytest.mark.parametrize("value", [math.inf, 1e19])
def test_what_is_too_large_is_not_written_wrongly(value: float) -> None:
    with pytest.raises(ValueError, match="too large to be written out"):
        list(csv_rows([np.array([value])], [0]))


@pytest.mark.parametrize("value", [1e18 / 7, 1e14 + 0.3, 1e-9, -0.125])
def test_columns_of_any_size_are_written(finished: RunSession, value: float) -> None:
    applied = apply_results(load_results(finished.folder), a_log(odd=np.full(500, value)))
    column = applied_csv(applied).decode().splitlines()[-1].split(",")[-2]
    assert float(column) == pytest.approx(value, rel=1e-15, abs=1e-6)


@pytest.mark.parametrize("value", [math.inf, 1e19])
def test_a_column_that_cannot_be_written_is_refused_by_name(
    finished: RunSession, value: float
) -> None:
    with pytest.raises(UnusableLog, match=re.escape(f"drive.csv: column odd contains {value:g}")):
        apply_results(load_results(finished.folder), a_log(odd=np.full(500, value)))


def test_a_log_s_csv_reads_back_to_the_last_decimal(finished: RunSession) -> None:
    applied = apply_results(load_results(finished.folder), a_log())
    table = np.loadtxt(applied_csv(applied).decode().splitlines()[1:], delimiter=",")
    assert np.abs(table[:, 1:4] - applied.triads["accelerometer"]).max() < 0.51e-6
    assert np.abs(table[:, 4:7] - applied.triads["gyroscope"]).max() < 0.51e-8


# --- the mounting ------------------------------------------------------------------------------

TURNED = np.array([[0.0, 0.6, 0.8], [1.0, 0.0, 0.0], [0.0, 0.8, -0.6]])
"""R of an installation: vehicle to sensor."""


def with_mounting(
    finished: RunSession, folder: Path, angles_rad: list[float] | None
) -> Path:
    """The session's results as they would be with an installation and these frame angles."""
    found = results_in(finished.folder)
    found["installation"] = {
        "order": "roll, pitch", "roll_deg": 0.0, "pitch_deg": 0.0, "sd_deg": [0.1, 0.1],
        "yaw_deg": None, "yaw_sd_deg": None, "floor_rise_deg": None, "floor_rise_sd_deg": None,
        "rotation": TURNED.tolist(), "before": [0.0, 0.0, 9.8], "after": [0.0, 0.0, 9.8],
        "magnitude_error_m_s2": 0.0, "readings": 100, "notes": [],
    }
    found["gyroscope"]["frame_to_accelerometer_rad"] = angles_rad
    (folder / "results.json").write_text(json.dumps(found), encoding="utf-8")
    return folder


def test_the_command_turns_both_triads_into_the_vehicle_s_axes_and_says_so(
    finished: RunSession, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    log = finished.config.parent / "gyroscope/17rpm/pose_03.csv"
    tables, said = [], []
    angle = 0.02
    with_mounting(finished, tmp_path, [0.0, 0.0, angle])
    for results in (finished.folder, tmp_path):
        output = tmp_path / f"{results.name}.csv"
        assert pipeline("apply", results, log, "--output", output) == 0
        tables.append(np.loadtxt(output, delimiter=",", skiprows=1))
        said.append(capsys.readouterr().err)
    plain, turned = tables
    # Written out: e_z of the vehicle is the third column of R in the sensor's axes.
    for axis in range(3):
        along = plain[:, 1:4] @ TURNED[:, axis]
        assert turned[:, 1 + axis] == pytest.approx(along, abs=2e-6)
    x, y, z = plain[:, 4:7].T
    in_accelerometer = np.column_stack([
        x * math.cos(angle) - y * math.sin(angle), x * math.sin(angle) + y * math.cos(angle), z
    ])
    assert turned[:, 4:7] == pytest.approx(in_accelerometer @ TURNED, abs=3e-8)
    assert "columns are in the axes of the sensor" in said[0]
    assert "columns are in the axes of the vehicle" in said[1]
    assert "count as 0" not in said[1]


def test_a_gyroscope_whose_frame_was_not_measured_is_turned_with_a_word(
    finished: RunSession, tmp_path: Path
) -> None:
    stored = load_results(with_mounting(finished, tmp_path, None))
    applied = apply_results(stored, a_log())
    plain = apply_results(load_results(finished.folder), a_log())
    assert applied.triads["gyroscope"] == pytest.approx(plain.triads["gyroscope"] @ TURNED)
    assert "were not measured and count as 0" in applied.axes
