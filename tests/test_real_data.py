"""The command on measured logs from public sources, which are not part of the project.

Peers' figures on the same logs stand beside ours; sets on which every known program returns
nonsense with a tiny residual must be refused, and say which directions are missing.
"""

import gzip
import re
from pathlib import Path

import numpy as np
import pytest

from tests.paths import REAL
from tests.sessions import configured, pipeline, results_in, run_without_page

pytestmark = pytest.mark.skipif(not REAL.is_dir(), reason=f"no measured logs in {REAL}")

XSENS = f"""
    log: [{REAL}/imu_tk_xsens/xsens_acc.mat.gz, {REAL}/imu_tk_xsens/xsens_gyro.mat.gz]
    columns: [[time_s, acc_x, acc_y, acc_z], [time_s, gyr_x, gyr_y, gyr_z]]
    find: still
"""


@pytest.fixture(scope="module")
def xsens(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Results of the real MTi log; the gyro's scale is that of its certificate (±394 °/s)."""
    folder = tmp_path_factory.mktemp("xsens")
    config = configured(folder, f"""
sensor:
  accelerometer: {{full_scale_m_s2: 50, bits: 16, encoding: offset-binary}}
  gyroscope: {{full_scale_deg_s: 394, bits: 16, encoding: offset-binary}}
site: {{gravity_m_s2: 9.81744}}
accelerometer:
  poses: {XSENS.replace("    ", "      ")}
gyroscope:
  model: [bias]
  runs:
  - rate: stopped
    poses: {XSENS.replace("    ", "      ")}
""")
    run_without_page(config)
    return folder / "config.run"


def test_the_mti_agrees_with_two_peers_and_leaves_less_than_they_do(xsens: Path) -> None:
    found = results_in(xsens)["accelerometer"]
    parameters = found["parameters"]
    assert parameters["bias_counts"] == pytest.approx([33123.8, 33275.2, 32364.5], abs=1.0)
    assert parameters["scale_counts_per_unit"] == pytest.approx([414.42, 412.03, 414.62], abs=0.1)
    assert parameters["misalignment_rad"] == pytest.approx([-0.0214, -0.0092, -0.0034], abs=6e-4)
    assert found["n_poses"] >= 35
    assert found["residual_rms"] <= 1.1e-3  # imu_tk and imu_tk2: 7.95e-3 for each sample


def test_the_mti_s_sds_are_those_of_autocorrelated_noise(xsens: Path) -> None:
    """White noise over sqrt(n) would make them 3.4 times smaller (chi²/dof 11)."""
    found = results_in(xsens)["accelerometer"]
    assert found["chi2"] / found["dof"] < 6
    assert found["sd"]["bias_counts"] == pytest.approx([0.3, 0.15, 0.2], rel=0.6)


def test_the_mti_s_accelerometer_steps_and_neither_drifts_nor_warms_up(xsens: Path) -> None:
    """Its repeated z-up pose goes up between 138 and 175 s: a step leaves less than any drift,
    and a bias that wanders is as likely."""
    found = results_in(xsens)["accelerometer"]["diagnosis"]
    assert (found["verdict"], found["name"]) == ("unknown", "time_s")
    believed = {m: i["probability"] for i in found["inclusion"] for m in i["members"]}
    assert believed["bias_step"] > 0.3
    assert max(believed.get("bias_drift", 0), believed.get("warm_up", 0)) < 0.02
    step = re.search(r"step.* at ([0-9.]+) s", found["says"])
    assert step is not None
    assert 135 < float(step.group(1)) < 176
    loo = {c["name"]: c["loo_after"] for c in found["ranking"]}
    assert loo["bias_step"] < 0.95 * min(loo["warm_up"], loo["bias_drift"])


def test_the_same_preset_runs_without_the_gyroscope_s_columns(tmp_path: Path) -> None:
    config = configured(tmp_path, f"""
sensor: xsens-mti
site: {{gravity_m_s2: 9.81744}}
accelerometer:
  poses:
    log: {REAL}/imu_tk_xsens/xsens_acc.mat.gz
    columns: [time_s, acc_x, acc_y, acc_z]
    find: still
""")
    found = run_without_page(config)["accelerometer"]
    assert found["parameters"]["bias_counts"] == pytest.approx([33123.8, 33275.2, 32364.5], abs=1)


def test_the_mti_s_gyroscope_hides_a_g_sensitivity_as_its_peers_found_it(xsens: Path) -> None:
    found = results_in(xsens)["gyroscope"]
    assert np.degrees(found["residual_rms"]) == pytest.approx(0.0717, abs=0.01)
    assert found["diagnosis"]["verdict"] == "effect"
    assert found["diagnosis"]["name"] == "g_sensitivity"
    (own,) = (c for c in found["diagnosis"]["ranking"] if c["name"] == "g_sensitivity")
    per_g = np.degrees(np.array(own["size"])) * 9.80665
    peers = [0.0138, 0.0354, 0.0748, -0.1537, 0.0033, 0.0975, -0.0826, -0.0958, 0.0265]
    assert per_g == pytest.approx(peers, abs=0.02)
    assert np.degrees(own["rms_after"]) == pytest.approx(0.015, abs=0.003)


MIKOFF = {
    "imu0": [0.1023, 0.0970, 0.3445],
    "imu1": [0.0895, 0.0702, 0.3389],
    "imu2": [0.0957, 0.0071, -0.0458],
    "imu3": [0.0658, 0.0902, -0.0091],
    "imu4": [0.0701, 0.0362, 0.1836],
}


@pytest.mark.parametrize("name", MIKOFF)
def test_five_mpu_9150_agree_in_bias_and_hide_nothing(tmp_path: Path, name: str) -> None:
    config = configured(tmp_path, f"""
sensor: {{accelerometer: {{unit: m_s2}}, gyroscope: {{unit: rad_s}}}}
site: {{gravity_m_s2: 9.81}}
accelerometer:
  poses:
    log: {REAL}/mpu9150_mikoff/{name}.log.gz
    columns: [acc_x, acc_y, acc_z, gyr_x, gyr_y, gyr_z]
    sample_rate_hz: 100
    find: still
""")
    found = run_without_page(config)["accelerometer"]
    assert found["parameters"]["bias_counts"] == pytest.approx(MIKOFF[name], abs=0.002)
    assert found["n_poses"] >= 18
    assert found["diagnosis"]["verdict"] != "effect"


@pytest.mark.parametrize(("board", "bias_deg_s"), [("Boost1", [-1.27, 0.37, -1.15])])
def test_a_rate_table_that_turns_between_its_rests_leaves_the_bias(
    tmp_path: Path, board: str, bias_deg_s: list[float], capsys: pytest.CaptureFixture[str]
) -> None:
    """The table turns about the vertical, which the accelerometer does not feel. The log begins at
    rest: the means of its first 100 rows are the reference."""
    lines = gzip.decompress((REAL / f"ouranos_rate_table/GSDataLog2{board}.csv.gz").read_bytes())
    rows = []
    for line in lines.decode("utf-8", "replace").splitlines()[2:]:
        try:
            rows.append([float(cell) for cell in line.split(",")[5:11]])
        except ValueError:  # blank and truncated rows of the radio link
            continue
    table = np.array([row for row in rows if len(row) == 6])
    table = table[np.isfinite(table).all(axis=1)]
    time_s = np.arange(len(table)) / LEG_HZ
    np.savetxt(tmp_path / "log.csv", np.column_stack([time_s, table]), delimiter=",", fmt="%.6f",
               header="time_s,acc_x,acc_y,acc_z,gyr_x,gyr_y,gyr_z", comments="")
    config = configured(tmp_path, """
sensor: {accelerometer: {unit: g}, gyroscope: {unit: deg_s}}
gyroscope:
  model: [bias]
  runs:
  - {poses: {log: log.csv, find: still}, rate: stopped}
""")
    assert pipeline("run", config) == 0
    assert "the plate or the hand turned it" in capsys.readouterr().err
    bias = results_in(tmp_path / "config.run")["gyroscope"]["parameters"]["bias_counts"]
    assert bias == pytest.approx(bias_deg_s, abs=0.06)


GEOMETRY = {
    "mpu6050_tomisuarez": ("""
sensor: mpu-6050
site: {{gravity_m_s2: 9.80665}}
accelerometer:
  poses:
    log: {real}/mpu6050_tomisuarez/example_data_calibration.csv.gz
    sample_rate_hz: 100
    find: still
""", "edge -x -y up"),
    "nexus5_d1": ("""
sensor: {{accelerometer: {{unit: m_s2}}}}
site: {{gravity_m_s2: 9.81}}
accelerometer:
  poses:
    log: {real}/nexus5_tyrex/calib_acc_d1_accelerometer.txt.gz
    columns: [time_s, acc_x, acc_y, acc_z]
    find: still
""", "-x up"),
    "nexus5_d3": ("""
sensor: {{accelerometer: {{unit: m_s2}}}}
site: {{gravity_m_s2: 9.81}}
accelerometer:
  poses:
    log: {real}/nexus5_tyrex/calib_acc_d3_accelerometer.txt.gz
    columns: [time_s, acc_x, acc_y, acc_z]
    find: still
""", "-x up"),
    "imucal_ferraris": ("""
sensor: {{accelerometer: {{unit: m_s2}}, gyroscope: {{unit: deg_s}}}}
site: {{gravity_m_s2: 9.81}}
accelerometer:
  poses:
    log: {real}/imucal_ferraris/example_ferraris_session.csv.gz
    sample_rate_hz: 102.4
    find: still
""", "edge -x -y up"),
}


@pytest.mark.parametrize("solver", ["default", "paper"])
@pytest.mark.parametrize("name", GEOMETRY)
def test_poses_that_determine_nothing_are_refused_with_what_is_missing(
    tmp_path: Path, name: str, solver: str, capsys: pytest.CaptureFixture[str]
) -> None:
    text, missing = GEOMETRY[name]
    config = configured(tmp_path, text.format(real=REAL) + f"  solver: {solver}\n")
    assert pipeline("run", config) == 4
    paragraphs = [line for line in capsys.readouterr().err.splitlines()
                  if not line.startswith("warning: ")]
    assert len(paragraphs) == 1
    if near := re.search("faces and edges, poses lie within 25° of (.*) alone", paragraphs[0]):
        assert missing not in near[1].split(", ")
    else:
        assert "Directions with no pose within 25°" in paragraphs[0]
        assert missing in paragraphs[0]
    assert not (tmp_path / "config.run").exists()


@pytest.mark.parametrize("board", ["Boost1", "Boost2", "Boost3"])
def test_six_legs_on_a_rate_table_do_not_determine_nine_parameters(
    tmp_path: Path, board: str, capsys: pytest.CaptureFixture[str]
) -> None:
    for i, leg in enumerate(legs(REAL / f"ouranos_rate_table/GSDataLog2{board}.csv.gz")):
        time_s = np.arange(len(leg)) / LEG_HZ
        np.savetxt(tmp_path / f"leg_{i}.csv", np.column_stack([time_s, leg]), delimiter=",",
                   header="time_s,gyr_x,gyr_y,gyr_z", comments="", fmt="%.6f")
    config = configured(tmp_path, """
sensor: {gyroscope: {unit: deg_s}}
rate:
  table: {rate_rad_s: 0.436332, sd_rad_s: 0.0005}   # 25 °/s, as set
gyroscope:
  runs:
    - {poses: leg_*.csv, rate: table}
""")
    assert len(list(tmp_path.glob("leg_*.csv"))) == 6
    assert pipeline("run", config) == 4
    message = capsys.readouterr().err
    assert "gyroscope: 6 poses give 6 equations for 9 parameters" in message
    assert "poses lie within 25° of -x up, -y up, -z up, +z up, +y up, +x up alone" in message


LEG_HZ = 16.0  #: rows arrive by radio about that often; the file has no time
LEG_ROWS = 600  #: 37 s of each leg's 45 s


def legs(path: Path) -> list[np.ndarray]:
    """The six legs about one axis each: LEG_ROWS rows of each, without ramps and moves."""
    rows = []
    for line in gzip.decompress(path.read_bytes()).decode("utf-8", "replace").splitlines()[2:]:
        cells = line.split(",")
        try:
            rows.append([float(cell) for cell in cells[8:11]])
        except ValueError:  # blank and truncated rows of the radio link
            continue
    gyro = np.array([row for row in rows if len(row) == 3])
    gyro = gyro[np.isfinite(gyro).all(axis=1)]
    found = []
    for axis in range(3):
        for sign in (1, -1):
            spinning = gyro[np.abs(sign * gyro[:, axis] - 25) < 3]
            steady = np.abs(spinning - np.median(spinning, axis=0)).max(axis=1) < 2
            found.append(spinning[steady][:LEG_ROWS])
    return found
