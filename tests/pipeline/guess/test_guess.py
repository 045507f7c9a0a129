"""Files of other people's tools become a session that runs, in the right units."""

from pathlib import Path

import numpy as np
import pytest

from pipeline.config.load import parse_config
from pipeline.config.sensor import sensor_specs
from pipeline.errors import UnreadableInput
from pipeline.guess.agreement import disagreements
from pipeline.guess.checked import CheckedConfig, checked_config
from pipeline.guess.config_text import Choices, config_text
from pipeline.guess.files import guess_files
from pipeline.guess.session import guess_session
from pipeline.stages.context import RunContext
from pipeline.stages.run import run_stages
from pipeline.stages.session_logs import read_session
from tests.pipeline.guess.corpus import READ
from tests.pipeline.guess.foreign import Foreign
from tests.pipeline.guess.hand_log import ACC_BIAS, ACC_SCALE, GRAVITY_M_S2, HandLog, hand_log
from tests.pipeline.guess.refused_files import REFUSED
from tests.sessions import pipeline

SITE = "{gravity_m_s2: 9.80665}"
CALIBRATED = (
    "phyphox", "one_file_per_pose", "offset_binary", "no_header_no_time", "nine_unnamed",
    "low_resolution", "two_chips", "newest_first", "blocks", "headed_blocks", "means",
    "means_with_sds", "labels_from_the_first_line",
)  # fmt: skip
"""A file of each layout, kind of counts and order of the rows: all others read as one of these."""

SPARSE = ("missing_values", "slow_gyroscope", "sensors_in_uneven_turns",
          "a_clock_beside_every_channel")
"""Files that lack many readings of a sensor: of a log of 25 Hz too few are left."""


@pytest.fixture(scope="module")
def log() -> HandLog:
    return hand_log(rate_hz=50.0)


@pytest.fixture(scope="module")
def slow_log() -> HandLog:
    return hand_log(rate_hz=25.0)


def imported(foreign: Foreign, folder: Path) -> CheckedConfig:
    tables, _ = guess_files(foreign.files, foreign.rate_hz)
    return checked_config(guess_session(tables), folder / "session.yaml", Choices(SITE),
                          lambda config: run_stages(config, RunContext()))


def resting(readings: np.ndarray) -> np.ndarray:
    """Readings in the rests (18, 3): those of the first half of each eighteenth of the rows."""
    return np.array([np.median(part[: len(part) // 2], axis=0)
                     for part in np.array_split(readings, 18)])


@pytest.mark.parametrize("tool", [tool for tool in READ if tool not in CALIBRATED])
def test_a_session_reads_in_a_foreign_file_what_was_recorded(
    tmp_path: Path, log: HandLog, slow_log: HandLog, tool: str
) -> None:
    log = log if tool in SPARSE else slow_log
    foreign = READ[tool](tmp_path, log)
    guess = guess_session(guess_files(foreign.files, foreign.rate_hz)[0])
    assert [*disagreements(guess)] == []
    config = parse_config(tmp_path / "session.yaml", config_text(guess, tmp_path, Choices(SITE)))
    assert config.accelerometer is not None
    logs = read_session(config)[config.accelerometer.at_rest[0].recorded].logs
    for triad, per_si, recorded, within in (
        ("accelerometer", foreign.per_m_s2, log.acc, 0.03),
        ("gyroscope", foreign.per_rad_s, log.gyr, 0.001),
    ):
        if per_si is None:
            continue
        spec = sensor_specs(config.sensor)[triad]
        counts = spec.nominal(np.concatenate([each.readings(triad) for each in logs]))
        si = counts / (spec.nominal_scale * per_si)
        np.testing.assert_allclose(resting(si), resting(recorded), atol=within)
        assert spec.nominal_scale * per_si == pytest.approx(1.0, rel=0.01)
    # No time is needed of a file of one pose.
    seconds = sum(float(np.ptp(each.time_s)) for each in logs)
    assert len(logs) == 18 or seconds == pytest.approx(54.0, rel=0.01)


@pytest.mark.parametrize("tool", CALIBRATED)
def test_the_calibration_of_a_foreign_file_is_that_of_the_recording(
    tmp_path: Path, log: HandLog, tool: str
) -> None:
    foreign = READ[tool](tmp_path, log)
    checked = imported(foreign, tmp_path)
    assert checked.fault is None
    assert checked.outcome is not None
    accelerometer = checked.outcome.triad("accelerometer")
    assert accelerometer is not None
    assert len(checked.outcome.recordings.of(
        checked.outcome.config.accelerometer.at_rest[0]  # type: ignore[union-attr]
    ).means) == 18
    parameters = accelerometer.calibration.parameters
    np.testing.assert_allclose(parameters.scale_counts_per_unit / foreign.per_m_s2, ACC_SCALE,
                               atol=0.003)
    specs = sensor_specs(checked.outcome.config.sensor)
    spec, gyroscope = specs["accelerometer"], specs.get("gyroscope")
    bias = (parameters.bias_counts - spec.nominal_bias_counts) / foreign.per_m_s2
    np.testing.assert_allclose(bias, ACC_BIAS, atol=0.03)
    if foreign.per_rad_s is not None:
        assert gyroscope is not None
        assert gyroscope.nominal_scale * foreign.per_rad_s == pytest.approx(1.0, rel=0.01)
        assert checked.outcome.triad("gyroscope") is not None


@pytest.mark.parametrize(("per_g", "unit"), [(10_000, "counts, 10000 per g"), (9806.65, "mm/s²")])
def test_whole_numbers_near_ten_thousand_per_g_are_the_nearer_unit_and_in_doubt(
    tmp_path: Path, log: HandLog, per_g: float, unit: str
) -> None:
    rows = np.rint((log.acc - ACC_BIAS) / ACC_SCALE / GRAVITY_M_S2 * per_g).astype(int)
    path = tmp_path / "board.csv"
    path.write_text("time_s,acc_x,acc_y,acc_z\n" + "\n".join(
        f"{time:.3f},{x},{y},{z}" for time, (x, y, z) in zip(log.time_s, rows, strict=True)),
        encoding="utf-8")
    (table,), _ = guess_files([path], None)
    assert table.accelerometer is not None
    assert table.accelerometer.unit.startswith(unit)
    assert "mm/s², or counts of which 10,000 are 1 g" in table.accelerometer.doubt


def test_columns_called_counts_that_are_no_gravity_in_any_unit_are_refused(tmp_path: Path) -> None:
    rows = np.rint(np.random.default_rng(1).normal(0, (3, 3000, 1), (500, 3))).astype(int)
    path = tmp_path / "board.csv"
    path.write_text("Accel X (counts),Accel Y (counts),Accel Z (counts)\n"
                    + "\n".join(",".join(map(str, row)) for row in rows), encoding="utf-8")
    with pytest.raises(UnreadableInput, match=r"board\.csv"):
        guess_files([path], 100.0)


@pytest.mark.parametrize("tool", REFUSED)
def test_files_without_readings_are_refused_with_what_to_record(
    tmp_path: Path, log: HandLog, tool: str, capsys: pytest.CaptureFixture[str]
) -> None:
    write, says = REFUSED[tool]
    code = pipeline("import", *write(tmp_path, log).files, "--output", tmp_path / "c.yaml")
    assert code in (0, 3, 4)  # a gyroscope beside it may show its bias
    with pytest.raises(AssertionError, match=f"(?s){says}"):
        raise AssertionError(capsys.readouterr().err)


def test_sensors_that_are_mounted_differently_are_told_by_their_axes(
    tmp_path: Path, log: HandLog
) -> None:
    assert "accelerometer's -y, +x, +z" in imported(READ["two_chips"](tmp_path, log),
                                                    tmp_path).text


def test_columns_that_count_rows_are_no_causes(tmp_path: Path, log: HandLog) -> None:
    checked = imported(READ["german_excel_mg"](tmp_path, log), tmp_path)
    assert "covariates: [temperature_c]" in checked.text
    assert "unit: mg" in checked.text


def test_a_temperature_in_fahrenheit_is_no_temperature_in_celsius(
    tmp_path: Path, log: HandLog
) -> None:
    assert "temperature_c" not in imported(READ["fahrenheit"](tmp_path, log), tmp_path).text


def test_a_coarse_reading_that_others_follow_from_names_no_sensor(
    tmp_path: Path, log: HandLog
) -> None:
    force = log.acc / 9.80665
    force[:200] = np.random.default_rng(1).normal((0.05, 0.02, 0.99), 0.002, (200, 3))
    coarse = np.round(force, 3)
    tilt = np.degrees(np.arctan2(coarse[:, 0], coarse[:, 2]))
    np.savetxt(tmp_path / "a.csv", np.column_stack([log.time_s, tilt, coarse, log.gyr]), "%.3f",
               ",", header="t,tilt,ax,ay,az,gx,gy,gz", comments="")
    found = guess_session(guess_files([tmp_path / "a.csv"], None)[0])
    assert found.accelerometer is not None
    assert found.accelerometer.unit == "g"


def test_rows_of_lost_samples_are_left_out_and_counted(tmp_path: Path, log: HandLog) -> None:
    outcome = imported(READ["lost_samples"](tmp_path, log), tmp_path).outcome
    assert outcome is not None
    assert "rows that lack a reading and are left out: 59 of 2531" in " ".join(outcome.warnings)


def test_names_and_units_in_a_drawn_table_are_read(tmp_path: Path, log: HandLog) -> None:
    text = imported(READ["box_drawn"](tmp_path, log), tmp_path).text
    assert "accelerometer: {unit: cm_s2}" in text
    assert "acc_x" not in text  # the names are ours, and nothing renames them


def test_two_sensors_of_one_time_are_no_two_recordings(tmp_path: Path, log: HandLog) -> None:
    """Their tables stand beside each other too, but they turn together."""
    names = ",".join(["time", *(f"{kind}_{axis}" for kind in ("acc", "gyr") for axis in "xyz")])
    for name, begin in (("a.csv", 0), ("b.csv", 500)):
        one = np.column_stack([begin + log.time_s, log.acc, log.gyr])
        np.savetxt(tmp_path / name, np.hstack([one, one * [1, *(6 * [1.01])]]), "%.5f", ",",
                   header=f"{names},{names}", comments="")
    guess = guess_session(guess_files([tmp_path / "a.csv", tmp_path / "b.csv"], None)[0])
    assert [table.path.name for table in guess.tables] == ["1", "1"]
    (doubt,) = [each for each in guess.doubts if "a sensor of the same kind at the same" in each]
    assert doubt.endswith(f"pipeline import {tmp_path}/a.csv/2 {tmp_path}/b.csv/2")


def test_whole_mg_are_no_counts_of_a_bno055(tmp_path: Path, log: HandLog) -> None:
    text = imported(READ["whole_mg"](tmp_path, log), tmp_path).text
    assert "accelerometer: {unit: mg}" in text
    assert "may be mg, or counts of which 980.665 or 1024 are 1 g" in text
