"""Columns whose names say what they are, beside others that have one length in every attitude."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from pipeline.guess.agreement import disagreements
from pipeline.guess.files import guess_files
from pipeline.guess.session import SessionGuess, guess_session
from pipeline.guess.units import per_deg_of
from pipeline.logs.header_words import read_name
from tests.pipeline.guess.evening import Evening
from tests.pipeline.guess.hand_log import ACC_BIAS, ACC_SCALE, GRAVITY_M_S2, HandLog, hand_log

FIELD_UT = 48.9
MG = 1000 / GRAVITY_M_S2


def guessed(*files: Path) -> SessionGuess:
    return guess_session(guess_files(files, None)[0])


def computed_gravity(log: HandLog) -> np.ndarray:
    """Gravity as a phone computes it, of one length and nearly without noise."""
    up = (log.acc - ACC_BIAS) / ACC_SCALE
    return GRAVITY_M_S2 * up / np.linalg.norm(up, axis=1, keepdims=True)


def write_log(path: Path, log: HandLog, triads: dict[str, np.ndarray]) -> Path:
    """Triads by the pattern of their names, in which ``*`` is the axis."""
    names = [name.replace("*", axis) for name in triads for axis in "XYZ"]
    np.savetxt(path, np.column_stack([1000 * log.time_s, *triads.values()]), "%.4f", ";",
               header=";".join(["time (ms)", *names]), comments="", encoding="utf-8")
    return path


@pytest.mark.parametrize("push_m_s2", [0.0, 3.0])
@pytest.mark.parametrize(("force", "scale", "others"), [
    ("gF*", 1 / GRAVITY_M_S2, ("B*",)),
    ("a*", MG, ("m*",)),
    ("Accel *", 1.0, ("Gravity *", "Magnetometer *")),
    ("BESCHLEUNIGUNG * (m/s²)", 1.0, ("GRAVITATION * (m/s²)", "MAGNETFELD * (µT)")),
    ("Accélération * (g)", 1 / GRAVITY_M_S2, ("Gravité * (g)", "Champ * (µT)")),
    ("Przyspieszenie * [mg]", MG, ("Grawitacja * [mg]", "Pole * [uT]")),
])
def test_columns_that_are_called_an_accelerometer_go_before_a_field_and_computed_gravity(
    tmp_path: Path, force: str, scale: float, others: tuple[str, ...], push_m_s2: float
) -> None:
    log = hand_log(rate_hz=50.0, push_m_s2=push_m_s2)
    beside = [scale * computed_gravity(log)] * (len(others) - 1) + [FIELD_UT * log.field]
    path = write_log(tmp_path / "log.csv", log, {
        **dict(zip(others, beside, strict=True)), "Gyro * (rad/s)": log.gyr,
        force: scale * log.acc})
    guess = guessed(path)
    assert guess.accelerometer is not None
    assert guess.accelerometer.columns == tuple(force.replace("*", axis) for axis in "XYZ")
    assert not guess.accelerometer.doubt
    assert guess.gyroscope is not None
    assert "Gyro X (rad/s)" in guess.gyroscope.columns


@pytest.mark.parametrize("name", ["GRAVITY * (m/s²)", "Schwerkraft *", "MAGNETIC FIELD * (µT)"])
def test_columns_that_are_called_another_quantity_are_no_accelerometer(
    tmp_path: Path, name: str
) -> None:
    log = hand_log(rate_hz=50.0)
    vector = FIELD_UT * log.field if "FIELD" in name else computed_gravity(log)
    guess = guessed(write_log(tmp_path / "log.csv", log, {
        name: vector, "Gyro * (rad/s)": log.gyr}))
    assert guess.accelerometer is None


@pytest.mark.parametrize("name", ["accelerationIncludingGravity_x", "Acceleration (with gravity) y",
                                  "linear_acceleration.z", "field.linear_acceleration.x",
                                  "Bx (m/s²)"])
def test_an_acceleration_with_gravity_is_an_accelerometer(name: str) -> None:
    words = read_name(name)
    assert words.quantity == "acc"
    assert not words.is_other


@pytest.mark.parametrize("name", ["FreeAcc_X", "userAcceleration.x", "Linear Accelerometer X"])
def test_an_acceleration_without_gravity_is_none_that_could_be_the_accelerometer(name: str) -> None:
    assert read_name(name).gravity_free


@pytest.mark.parametrize("name", ["chyba x", "acc_x_err", "Unsicherheit X [m/s²]", "σ_x"])
def test_the_uncertainty_of_a_mean_is_its_sd_in_several_languages(name: str) -> None:
    words = read_name(name)
    assert (words.quantity, words.axis) == ("sd", 0)


@pytest.mark.parametrize(("rate", "sign"), [("rotationRate", -1), ("gyro", 1)])
def test_apple_s_accelerometer_reads_gravity_beside_a_rate_of_its_name(
    tmp_path: Path, rate: str, sign: int
) -> None:
    """CoreMotion's names of both sensors are `acceleration` and `rotationRate`, in g and rad/s."""
    log = hand_log(rate_hz=50.0)
    path = tmp_path / "take.csv"
    np.savetxt(path, np.column_stack([log.time_s, -log.acc / 9.80665, log.gyr]), "%.6f", ",",
               comments="", header=",".join(["timestamp", *(f"acceleration.{x}" for x in "xyz"),
                                             *(f"{rate}.{x}" for x in "xyz")]))
    accelerometer = guessed(path).accelerometer
    assert accelerometer is not None
    assert np.sign(accelerometer.si_per_unit) == sign


@pytest.mark.parametrize(("name", "unit"), [
    ("accel_x_mps2", "m_s2"), ("acc_x_m_per_s_2", "m_s2"), ("gyro_x_radps", "rad_s"),
    ("Gyroscope_X_rad_sec", "rad_s"), ("gyro x degrees per second", "deg_s"),
    ("gyro_x_mradps", "mrad_s"), ("gyro_x_rad_s", "rad_s"), ("vel_x_mps", "")])
def test_a_unit_in_words_at_the_end_of_a_name_is_that_unit(name: str, unit: str) -> None:
    words = read_name(name)
    assert (words.axis, words.unit) == (0, unit)


def test_a_temperature_beside_readings_in_a_unit_is_no_word_of_a_register(tmp_path: Path) -> None:
    """MAVLink's is in hundredths of a degree: 27.5 °C, and 44.6 °C by the map of an MPU-6050."""
    log = hand_log(rate_hz=50.0)
    rows = np.column_stack([1000 * log.time_s, MG * log.acc, 1000 * log.gyr,
                            2750 + np.arange(len(log.acc)) % 5])
    path = tmp_path / "SCALED_IMU2.csv"
    np.savetxt(path, rows, "%d", ",", comments="", header="time_boot_ms,xacc,yacc,zacc,xgyro,"
               "ygyro,zgyro,temperature")
    guess = guessed(path)
    assert guess.accelerometer is not None
    assert guess.accelerometer.unit == "mg"
    assert not [doubt for doubt in guess.doubts if "register map" in doubt]


def test_counts_of_no_range_of_an_mpu_have_no_temperature_by_its_map(tmp_path: Path) -> None:
    """An ADIS16470 has 800 counts per g, and tenths of a degree."""
    files = Evening(range_g=32768 / 800).write(tmp_path, "rest", 0.0, 1)
    doubts = guess_session(guess_files(files, None)[0]).doubts
    assert any("no usual unit or range" in doubt for doubt in doubts)
    assert not [doubt for doubt in doubts if "register map" in doubt]


def test_poses_in_files_of_json_are_those_of_one_logger(tmp_path: Path) -> None:
    """Acceleration without gravity reads alike in every rest, as a gyroscope does; its name says
    what it is. Alpha, beta and gamma of a browser are about x, y and z."""
    log = hand_log(rate_hz=50.0, rpm=33.33)
    quiet = np.random.default_rng(0).normal(0, 0.02, log.acc.shape)
    names = ("acceleration", "accelerationIncludingGravity", "rotationRate")
    axes = ("xyz", "xyz", ("alpha", "beta", "gamma"))
    for i in range(18):
        (folder := tmp_path / f"{i // 9}").mkdir(exist_ok=True)
        (folder / f"motion-{i % 9}.jsonl").write_text("\n".join(json.dumps({
            "timeStamp": 1000 * log.time_s[row], **{
                name: dict(zip(axis, values[row].round(4).tolist(), strict=True)) for
                name, axis, values in zip(names, axes, (quiet, log.acc, np.degrees(log.gyr)),
                                          strict=True)}})
            for row in np.flatnonzero(log.rest == i)), encoding="utf-8")
    gyroscope = guessed(*sorted(tmp_path.glob("*/*.jsonl"))).gyroscope
    assert gyroscope is not None
    assert gyroscope.columns == ("rotationRate.alpha", "rotationRate.beta", "rotationRate.gamma")


def test_a_plate_shows_the_rate_of_a_log_without_times(tmp_path: Path) -> None:
    """Gravity goes round in samples as often as the gyroscope says in seconds."""
    evening = Evening(seconds=9.0, rate_hz=100.0)
    files = []
    for name, rpm, seed in (("rest", 0.0, 1), ("turn", 100 / 3, 2)):
        for path in evening.write(tmp_path, name, rpm, seed):
            table = np.loadtxt(path, delimiter=",", skiprows=1)[::3]  # 33.3 Hz
            table[:, 5:] *= evening.range_deg_s / 32768
            np.savetxt(path, table[:, [1, 2, 3, 5, 6, 7]], "%.4f", ",", comments="",
                       header="acc_x,acc_y,acc_z,wx (deg/s),wy (deg/s),wz (deg/s)")
            files.append(path)
    guess = guessed(*files)
    assert [table.clock.rate_hz for table in guess.tables] == pytest.approx(
        [100 / 3] * len(files), rel=0.005)
    assert [source.rate for source in guess.sources] == ["stopped", "33.3rpm"]
    assert "--rate-hz" in " ".join(guess.doubts)


def test_a_range_that_stays_open_is_asked_with_the_speeds_that_follow(tmp_path: Path) -> None:
    evening = Evening(range_deg_s=250.0, rpm=25.0, lean_deg=0.0)
    guess = guessed(*evening.write(tmp_path, "turn", 25.0, 1))
    assert [choice.rpm for choice in guess.scales] == pytest.approx([25, 50, 100, 200], rel=0.02)


@pytest.mark.parametrize(("rpm", "stated", "unit"), [
    (100 / 3, None, "114.286 per"), (100 / 3, 250.0, "114.286 per"), (100 / 3, 2000.0, "16.384"),
    (45.0, None, "of a range that is open")])  # ±500 °/s of InvenSense would be 39 and 78 rpm
def test_a_range_of_st_s_parts_is_known_by_the_speed_of_the_plate(
    tmp_path: Path, rpm: float, stated: float | None, unit: str
) -> None:
    """A stated ±250 °/s is 114.3 counts per °/s in them, and 131.1 in others."""
    evening = Evening(range_deg_s=286.72, lean_deg=0.0)
    files = [path for name, speed in (("rest", 0.0), ("turn", rpm))
             for path in evening.write(tmp_path, name, speed, 1)]
    guess = guess_session(guess_files(files, None)[0], (), per_deg_of(stated))
    assert guess.gyroscope is not None
    assert unit in guess.gyroscope.unit
    if stated is None and guess.scales:
        assert [choice.rpm for choice in guess.scales] == pytest.approx([78.26, 45])


def test_counts_whose_names_state_a_unit_are_told_as_counts(tmp_path: Path) -> None:
    """At rest too, where no turn of gravity shows the scale."""
    log = hand_log()
    still = log.rest >= 0
    found = guessed(write_log(tmp_path / "a.csv", replace(
        log, time_s=np.arange(still.sum()) / 100), {
            "a* (m/s2)": log.acc[still],
            "g* (rad/s)": np.rint(np.degrees(log.gyr[still]) * 131.072)}))
    assert found.gyroscope is not None
    assert found.gyroscope.unit.startswith("counts")
    assert "they are counts" in found.gyroscope.doubt


def test_a_number_behind_the_axis_is_that_of_the_board(tmp_path: Path) -> None:
    """Three boards in one row were one accelerometer of the axes ax1, ay1, az1 and a field."""
    log, names = hand_log(rate_hz=50.0), [f"a{axis}{board}" for board in "123" for axis in "xyz"]
    np.savetxt(tmp_path / "log.csv", np.column_stack([log.time_s, log.acc, log.acc + 0.3,
                                                      log.acc[:, [1, 0, 2]]]), "%.4f", ",",
               header=",".join(["time_s", *names]), comments="")
    guess = guessed(tmp_path / "log.csv")
    assert guess.accelerometer is not None
    assert guess.accelerometer.columns == ("ax1", "ay1", "az1")
    assert "ax2, ay2, az2 may be an accelerometer's too" in guess.accelerometer.doubt
    assert not [*disagreements(guess)]


def test_whole_numbers_in_no_usual_unit_are_counts_and_not_the_nearest_unit(tmp_path: Path) -> None:
    """m/s² in 65536ths are 642,700 to a g, 1.56 times fewer than µg."""
    log = hand_log(rate_hz=25.0)
    rows = np.rint(np.column_stack([1000 * log.time_s, 65536 * log.acc]))
    np.savetxt(tmp_path / "q16.csv", rows, "%d", ",", header="ms,ax,ay,az", comments="")
    accelerometer = guessed(tmp_path / "q16.csv").accelerometer
    assert accelerometer is not None
    assert dict(accelerometer.sheet)["counts_per_g"] == pytest.approx(65536 * 9.80665, rel=0.02)
    assert "no usual unit" in accelerometer.doubt
