"""Encodings and units of a sensor's sheet: the same readings, whatever stands in the log."""

from pathlib import Path

import numpy as np
import pytest

from pipeline.cli import main
from pipeline.config.load import load_config
from pipeline.stages.context import RunContext
from pipeline.stages.plate_settings import measure_rates
from pipeline.stages.run import run_stages
from tests.pipeline.guess.hand_log import ACC_SCALE, GYR_BIAS, HandLog, hand_log

pytestmark = pytest.mark.usefixtures("bare_page")

COUNTS_PER_G = 4096.0
G = 9.80665
SESSION = """\
sensor: {accelerometer: {%s}}
site: {gravity_m_s2: 9.80665}
accelerometer: {poses: {log: log.csv, find: still}, model: [bias, scale, misalignment]}
"""
CONVERTER = "full_scale_g: 8, bits: 16, encoding: "


@pytest.fixture(scope="module")
def log() -> HandLog:
    return hand_log(seed=2)


def counts(log: HandLog) -> np.ndarray:
    return np.asarray(np.rint(log.acc / G * COUNTS_PER_G))


def session(folder: Path, log: HandLog, readings: np.ndarray, sheet: str) -> Path:
    save(folder / "log.csv", log.time_s, readings, "acc")
    (folder / "config.yaml").write_text(SESSION % sheet)
    return folder / "config.yaml"


@pytest.mark.parametrize(("sheet", "per_m_s2", "offset", "modulus"), [
    (CONVERTER + "twos-complement", COUNTS_PER_G / G, 0, 0),
    (CONVERTER + "unsigned-twos-complement", COUNTS_PER_G / G, 0, 65536),
    (CONVERTER + "offset-binary", COUNTS_PER_G / G, 32768, 0),
    ("counts_per_g: 4096, bits: 16, encoding: twos-complement", COUNTS_PER_G / G, 0, 0),
    ("counts_per_g: 4096", COUNTS_PER_G / G, 0, 0),
    ("counts_per_m_s2: 417.7", COUNTS_PER_G / G, 0, 0),
    ("unit: mg", 1000 / G, 0, None),
    ("unit: g", 1 / G, 0, None),
])
def test_every_sheet_gives_the_same_calibration(
    tmp_path: Path, log: HandLog, sheet: str, per_m_s2: float, offset: int, modulus: int | None
) -> None:
    readings = log.acc * per_m_s2 if modulus is None else counts(log) + offset
    config = session(tmp_path, log, readings % modulus if modulus else readings, sheet)
    outcome = run_stages(load_config(config), RunContext())
    assert outcome.triad("accelerometer") is not None
    parameters = outcome.triad("accelerometer").calibration.parameters
    np.testing.assert_allclose(parameters.scale_counts_per_unit / per_m_s2, ACC_SCALE, atol=2e-3)


def test_a_log_of_unsigned_counts_is_corrected_as_it_was_calibrated(
    tmp_path: Path, log: HandLog, capsys: pytest.CaptureFixture[str]
) -> None:
    config = session(tmp_path, log, counts(log) % 65536, CONVERTER + "unsigned-twos-complement")
    assert main(["run", str(config)]) == 0
    corrected = tmp_path / "corrected.csv"
    assert main(["apply", str(tmp_path / "config.run"), str(tmp_path / "log.csv"), "--output",
                 str(corrected)]) == 0
    table = np.genfromtxt(corrected, delimiter=",", names=True)
    force = np.column_stack([table[f"acc_{axis}_m_s2"] for axis in "xyz"])[log.rest >= 0]
    assert np.median(np.linalg.norm(force, axis=1)) == pytest.approx(G, abs=0.003)


@pytest.mark.parametrize("poses", ["'*.csv'", "{log: [rates.csv, forces.csv], find: still}"])
def test_codes_about_zero_are_the_numbers_that_they_stand_for(
    tmp_path: Path, log: HandLog, poses: str
) -> None:
    """Neither strays, nor the rests of a log, nor readings between two samples tell them apart."""
    rates = np.rint((log.gyr - GYR_BIAS) * 3754)
    fits = []
    for modulus, encoding in ((None, "twos-complement"), (65536, "unsigned-twos-complement")):
        readings = rates % modulus if modulus else rates
        if "log" in poses:
            save(tmp_path / "rates.csv", log.time_s + 0.003, readings, "gyr")
            save(tmp_path / "forces.csv", log.time_s, log.acc, "acc")
        else:
            for rest in range(18):
                here = log.rest == rest
                save(tmp_path / f"{rest}.csv", log.time_s[here], readings[here], "gyr")
        config = tmp_path / "config.yaml"
        config.write_text(f"""\
sensor:
  accelerometer: {{unit: m_s2}}
  gyroscope: {{full_scale_deg_s: 500, bits: 16, encoding: {encoding}}}
gyroscope: {{runs: [{{poses: {poses}, rate: stopped}}], model: [bias]}}
""")
        triad = run_stages(load_config(config), RunContext()).triad("gyroscope")
        fits.append([triad.calibration.fit.chi2, *triad.calibration.parameters.bias_counts])
    np.testing.assert_array_equal(*fits)


def save(path: Path, time_s: np.ndarray, readings: np.ndarray, triad: str) -> None:
    np.savetxt(path, np.column_stack([time_s, readings]), "%.9g", ",", comments="",
               header="time_s," + ",".join(f"{triad}_{axis}" for axis in "xyz"))


@pytest.mark.parametrize(("stated", "logged", "says"), [
    ("offset-binary", 0, "Is the encoding twos-complement"),
    ("twos-complement", 65536, "Is the encoding unsigned-twos-complement, offset-binary"),
])
def test_a_wrong_encoding_is_refused_with_the_likely_one(
    tmp_path: Path, log: HandLog, stated: str, logged: int, says: str,
    capsys: pytest.CaptureFixture[str],
) -> None:
    for rest in range(18):
        rows = counts(log)[log.rest == rest]
        np.savetxt(tmp_path / f"{rest}.csv", rows % logged if logged else rows, delimiter=",",
                   fmt="%d", header="acc_x,acc_y,acc_z", comments="")
    config = tmp_path / "config.yaml"
    config.write_text((SESSION % (CONVERTER + stated)).replace("{log: log.csv, find: still}",
                                                               "'*.csv'"))
    assert main(["run", str(config)]) == 3
    assert says in capsys.readouterr().err


def test_a_negative_known_rate_turns_the_other_way(tmp_path: Path) -> None:
    config = tmp_path / "config.yaml"
    config.write_text("sensor: {gyroscope: {unit: rad_s}}\n"
                      "rate: {back: {rate_rad_s: -3.49, sd_rad_s: 0.001}}\n")
    rate = measure_rates(load_config(config), RunContext())["back"]
    assert rate.plate.rate_rad_s[0] == 3.49
    assert rate.plate.direction == "cw"
