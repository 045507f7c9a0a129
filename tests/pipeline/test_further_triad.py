"""A triad is data: one that accelerometer and gyroscope are not goes from logs to every output."""

import re
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from calib.poses.triad_kind import TRIAD_KINDS, TriadKind
from pipeline.export.formats import FORMATS
from tests.sessions import magnetometer_session, pipeline, results_in, run_without_page
from tests.world.magnetometer import Magnetometer

FLUXGATE = TriadKind("fluxgate", "fluxgate", "µT", "nT", 1e3, "the field of the Earth",
                     ("flux_x", "flux_y", "flux_z"), ("ut",), "field_ut")
SEED = 4
PER_KELVIN = np.array([0.12, -0.08, 0.10])


@pytest.fixture
def fluxgate() -> Iterator[TriadKind]:
    """A kind that no line of the program knows."""
    TRIAD_KINDS[FLUXGATE.name] = FLUXGATE
    yield FLUXGATE
    del TRIAD_KINDS[FLUXGATE.name]


def test_a_kind_that_is_registered_goes_through_everything(
    tmp_path: Path, fluxgate: TriadKind, capsys: pytest.CaptureFixture[str]
) -> None:
    config = magnetometer_session(
        tmp_path, SEED, Magnetometer(per_kelvin=PER_KELVIN), fluxgate.name)
    assert pipeline("check", config) == 0
    assert pipeline("run", config) == 0
    before = results_in(tmp_path / "config.run")["fluxgate"]
    missing = before["diagnosis"]
    said = capsys.readouterr().out
    assert re.search(rf"^fluxgate: '{missing['name']}'.* is missing", said, re.MULTILINE)
    # In poses in which the temperature rises with the time a warm-up and a drift look the same.
    assert "temperature_bias" in {missing["name"], *missing["group"]}
    assert before["reference"] == {"value": 49.1, "sd": 0.05, "unit": "µT"}
    assert pipeline("add", config, "fluxgate.temperature_bias") == 0
    after = results_in(tmp_path / "config.run")["fluxgate"]
    assert after["loo_rms"] < 0.5 * before["loo_rms"]
    page = (tmp_path / "config.run/report.html").read_text(encoding="utf-8")
    assert re.search(r"<h2[^>]*>\s*Fluxgate", page)
    assert pipeline("history", config) == 0
    assert "fluxgate" in capsys.readouterr().out
    for form in FORMATS:
        assert pipeline("export", tmp_path / "config.run", "--to", form,
                        "--output", tmp_path / form) == 0, form
    exported = (tmp_path / "arduino/imu_calibration.h").read_text(encoding="utf-8")
    assert "calibrate_fluxgate" in exported
    assert "without the fluxgate" in capsys.readouterr().err


def test_a_magnetometer_is_calibrated_against_the_stated_field(tmp_path: Path) -> None:
    sensor = Magnetometer()
    config = magnetometer_session(tmp_path, SEED, sensor)
    results = run_without_page(config)["magnetometer"]
    assert results["diagnosis"]["verdict"] == "nothing_missing"
    bias, sd = (np.array(results[key]["bias_counts"]) for key in ("parameters", "sd"))
    assert np.abs((bias / sensor.counts_per_ut - sensor.offset_ut) / (sd / sensor.counts_per_ut)
                  ).max() < 4
    log = tmp_path / "accelerometer/pose_05.csv"
    output = tmp_path / "corrected.csv"
    assert pipeline("apply", tmp_path / "config.run", log, "--output", output) == 0
    rows = np.genfromtxt(output, delimiter=",", names=True)
    corrected = np.array([rows[f"mag_{axis}_ut"].mean() for axis in "xyz"])
    assert np.linalg.norm(corrected) == pytest.approx(
        sensor.field_ut, abs=4 * results["prediction"]["sd_worst"])


@pytest.mark.parametrize(("old", "new", "said"), [
    ("  field_ut: 49.1\n", "", "field_ut"),
    ("  field_ut: 49.1\n", "  field_nt: 49100\n", "write field_ut"),
    ("  field_ut: 49.1\n", "  field_ut: 4.91\n", "reads"),
    ("magnetometer:\n  poses", "magnetometre:\n  poses", "did you mean 'magnetometer'"),
    ("  poses: accelerometer/pose_*.csv\n  field", "  poses: gyroscope/*/pose_*.csv\n  field",
     "mag_x, mag_y, mag_z"),
])
def test_mistakes_in_its_section_are_told(
    tmp_path: Path, old: str, new: str, said: str, capsys: pytest.CaptureFixture[str]
) -> None:
    config = magnetometer_session(tmp_path, SEED, Magnetometer())
    text = config.read_text(encoding="utf-8")
    assert old in text
    config.write_text(text.replace(old, new), encoding="utf-8")
    assert pipeline("check", config) in (2, 4)
    captured = capsys.readouterr()
    assert said in captured.err + captured.out
