"""From a configuration with `installation:` and `certificate:` to what results.json holds."""

import json
import math
from pathlib import Path

import numpy as np
import pytest

from calib.consistency.certificate import compare_certificate
from calib.poses.imu_log import ImuLog
from pipeline.config.load import Config, load_config
from pipeline.console.parameter_text import certificate_lines, mounting_text
from pipeline.errors import ConfigError
from pipeline.results.schema.triad import CertificateGroup
from pipeline.results.write import installation_section
from pipeline.stages.mounting import measure_mounting
from pipeline.stages.references import Gravity, certificate_of
from tests.calib.mounting.simulated_reading import (
    TRIAD,
    G,
    Mounted,
    calibration,
    drive,
    floor,
    vehicle_to_sensor,
)

CONFIG = f"""\
sensor: xsens-mti
site: {{gravity_m_s2: {G}}}
accelerometer: {{poses: pose.csv}}
installation:
  log: installed.csv
"""
CERTIFICATE = """\
certificate:
  accelerometer:
    bias_counts: [33652, 33395, 32034]
    scale_counts_per_unit: [549.7, 552.7, 550.4]
"""


def write(path: Path, log: ImuLog) -> None:
    rows = np.column_stack([log.time_s, log.accelerometer])
    np.savetxt(path, rows, "%.10g", ",", header="time_s,acc_x,acc_y,acc_z", comments="")


GRAVITY = Gravity(G, 0.0, "stated")


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A session's folder with every log of a sensor mounted at 30°, 15°, yaw 40°."""
    angles = (math.radians(30), math.radians(15), math.radians(40))
    mounted = Mounted(TRIAD, vehicle_to_sensor("xyz", *angles))
    write(tmp_path / "installed.csv", mounted.still(30, 1, floor(0.02, 0.0)))
    write(tmp_path / "back.csv", mounted.still(30, 2, floor(0.02, 0.0, math.pi)))
    write(tmp_path / "drive.csv", mounted.log(drive(90, 3), 3))
    write(tmp_path / "pose.csv", mounted.still(8, 4))
    return tmp_path


def loaded(folder: Path, text: str) -> Config:
    path = folder / "config.yaml"
    path.write_text(text, encoding="utf-8")
    return load_config(path)


def test_a_still_log_gives_roll_and_pitch_and_nothing_else(folder: Path) -> None:
    found = measure_mounting(loaded(folder, CONFIG), calibration(), GRAVITY)
    assert found is not None
    said = installation_section(found).as_json()
    assert set(said) >= {"order", "roll_deg", "pitch_deg", "sd_deg", "rotation", "before", "after"}
    assert said["order"] == "xyz"
    assert said["yaw_deg"] is None
    assert said["floor_rise_deg"] is None
    # The floor rises by 1.15° ahead, which one log takes for mounting.
    assert abs(said["roll_deg"] - 30) + abs(said["pitch_deg"] - 15) > 1
    assert json.loads(json.dumps(said, allow_nan=False)) == said


def test_reverse_and_drive_logs_give_floor_and_yaw(folder: Path) -> None:
    config = loaded(folder, CONFIG + "  reverse_log: back.csv\n  drive_log: drive.csv\n")
    found = measure_mounting(config, calibration(), GRAVITY)
    assert found is not None
    said = installation_section(found).as_json()
    roll_sd, pitch_sd = said["sd_deg"]
    assert said["roll_deg"] == pytest.approx(30, abs=4 * roll_sd)
    assert said["pitch_deg"] == pytest.approx(15, abs=4 * pitch_sd)
    assert said["yaw_deg"] == pytest.approx(40, abs=4 * said["yaw_sd_deg"])
    assert said["floor_rise_deg"] == pytest.approx([math.degrees(0.02), 0], abs=0.12)
    assert mounting_text(found).startswith("roll 29.99")
    assert ", yaw 4" in mounting_text(found)


def test_the_file_s_order_overrules_eq_6_and_both_orders_are_told(folder: Path) -> None:
    """Both level the same reading: what is left is the same, the angles are the other order's."""
    by_paper = measure_mounting(loaded(folder, CONFIG), calibration(), GRAVITY)
    stated = measure_mounting(loaded(folder, CONFIG + "  order: yxz\n"), calibration(), GRAVITY)
    assert by_paper is not None
    assert stated is not None
    assert (by_paper.order, stated.order) == ("xyz", "yxz")
    trials = {trial["order"]: trial for trial in installation_section(stated).as_json()["orders"]}
    assert installation_section(by_paper).as_json()["orders"] == [*trials.values()]
    for found in (by_paper, stated):
        trial = trials[found.order]
        assert math.radians(trial["roll_deg"]) == pytest.approx(found.roll_rad)
        assert np.radians(trial["sd_deg"]) == pytest.approx(found.sd_rad)
        rest = np.linalg.norm(found.after - [0, 0, G])
        assert trial["residual_m_s2"] == pytest.approx(rest)
    assert trials["xyz"]["residual_m_s2"] == pytest.approx(trials["yxz"]["residual_m_s2"])
    assert trials["xyz"]["margin"] < trials["yxz"]["margin"]
    assert abs(trials["xyz"]["roll_deg"] - trials["yxz"]["roll_deg"]) > 0.5


def test_an_order_that_does_not_exist_is_refused_with_those_that_do(folder: Path) -> None:
    with pytest.raises(ConfigError, match=r"installation\.order.*xyz.*yxz"):
        loaded(folder, CONFIG + "  order: zyx\n")


def test_single_readings_are_upright_after_the_mounting(folder: Path) -> None:
    """Figure 5 of the paper: three level lines, of which two come to lie on zero."""
    found = measure_mounting(loaded(folder, CONFIG), calibration(), GRAVITY)
    assert found is not None
    readings = found.readings
    assert readings.before.shape == readings.after.shape == (300, 3)
    assert (np.diff(readings.time_s) > 0).all()
    assert readings.before.mean(axis=0) == pytest.approx(found.before, abs=0.02)
    assert readings.after.mean(axis=0) == pytest.approx([0, 0, G], abs=0.02)


def test_still_stretches_are_found_where_the_file_says_so(folder: Path) -> None:
    config = loaded(folder, CONFIG + "  find: still\n")
    found = measure_mounting(config, calibration(), GRAVITY)
    assert found is not None
    assert 2500 < found.samples <= 3000


def test_without_the_section_there_is_no_installation(folder: Path) -> None:
    config = loaded(folder, CONFIG.split("installation")[0])
    assert measure_mounting(config, calibration(), GRAVITY) is None


def test_the_certificate_of_the_file_stands_beside_the_triad(folder: Path) -> None:
    config = loaded(folder, CONFIG + CERTIFICATE)
    stated, triad = certificate_of(config, "accelerometer"), calibration()
    assert stated is not None
    found = compare_certificate(triad.parameters, stated, triad.spec)
    said = {name: CertificateGroup.of(group).as_json() for name, group in found.items()}
    assert set(said) == {"bias", "scale"}
    assert np.abs(said["bias"]["difference"]).max() < 3  # counts; the world has these very values
    assert np.abs(said["scale"]["per_cent"]).max() < 0.06
    lines = certificate_lines(found)
    assert len(lines) == 7
    assert lines[1].split()[:3] == ["bias", "[counts]", "x"]


def test_a_triad_without_a_certificate_has_none_beside_it(folder: Path) -> None:
    assert certificate_of(loaded(folder, CONFIG), "accelerometer") is None
