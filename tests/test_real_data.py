"""The command on measured logs from public sources, which are not part of the project.

Peers' figures on the same logs stand beside ours; sets on which every known program returns
nonsense with a tiny residual must be refused, and say which directions are missing.
"""

import gzip
import re
from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import least_squares

from calib.errors import Undetermined
from calib.poses.data_sheet import TriadSpec
from calib.poses.imu_log import FloatArray, ImuLog
from calib.poses.static_intervals import find_still
from tests.paths import SHARED
from tests.sessions import pipeline, results_in

REAL = SHARED / "real"
pytestmark = pytest.mark.skipif(not REAL.is_dir(), reason=f"no measured logs in {REAL}")

XSENS = f"""
    log: [{REAL}/imu_tk_xsens/xsens_acc.mat.gz, {REAL}/imu_tk_xsens/xsens_gyro.mat.gz]
    columns: [[time_s, acc_x, acc_y, acc_z], [time_s, gyr_x, gyr_y, gyr_z]]
    find: still
"""


def write(folder: Path, text: str) -> Path:
    (folder / "config.yaml").write_text(text, encoding="utf-8")
    return folder / "config.yaml"


# --- Xsens MTi: 38 still poses in 512 s ---------------------------------------------------------


@pytest.fixture(scope="module")
def xsens(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Results of the real MTi log; the gyro's scale is that of its certificate (±394 °/s)."""
    folder = tmp_path_factory.mktemp("xsens")
    config = write(folder, f"""
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
    assert pipeline("run", config) == 0
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
    """Its repeated z-up pose goes up between 138 and 175 s: a step leaves less than any drift."""
    found = results_in(xsens)["accelerometer"]["diagnosis"]
    assert found["verdict"] == "unknown"
    assert found["name"] in ("jump", "time_s")
    assert found["names"] == []
    assert not {"bias_drift", "warm_up"} & {m for i in found["inclusion"] for m in i["members"]}
    step = re.search(r"step.* at ([0-9.]+) s", found["says"])
    assert step is not None
    assert 135 < float(step.group(1)) < 176
    loo = {c["name"]: c["loo_after"] for c in found["ranking"]}
    assert loo["jump"] < 0.9 * min(loo["warm_up"], loo["bias_drift"])


def test_the_same_preset_runs_without_the_gyroscope_s_columns(tmp_path: Path) -> None:
    config = write(tmp_path, f"""
sensor: xsens-mti
site: {{gravity_m_s2: 9.81744}}
accelerometer:
  poses:
    log: {REAL}/imu_tk_xsens/xsens_acc.mat.gz
    columns: [time_s, acc_x, acc_y, acc_z]
    find: still
""")
    assert pipeline("run", config) == 0
    found = results_in(tmp_path / "config.run")["accelerometer"]
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


# --- MPU-9150: five logs, headerless, without time ----------------------------------------------

MIKOFF = {
    "imu0": [0.1023, 0.0970, 0.3445],
    "imu1": [0.0895, 0.0702, 0.3389],
    "imu2": [0.0957, 0.0071, -0.0458],
    "imu3": [0.0658, 0.0902, -0.0091],
    "imu4": [0.0701, 0.0362, 0.1836],
}


@pytest.mark.parametrize("name", MIKOFF)
def test_five_mpu_9150_agree_in_bias_and_hide_nothing(tmp_path: Path, name: str) -> None:
    config = write(tmp_path, f"""
sensor: {{accelerometer: {{unit: m_s2}}, gyroscope: {{unit: rad_s}}}}
site: {{gravity_m_s2: 9.81}}
accelerometer:
  poses:
    log: {REAL}/mpu9150_mikoff/{name}.log.gz
    columns: [acc_x, acc_y, acc_z, gyr_x, gyr_y, gyr_z]
    sample_rate_hz: 100
    find: still
""")
    assert pipeline("run", config) == 0
    found = results_in(tmp_path / "config.run")["accelerometer"]
    assert found["parameters"]["bias_counts"] == pytest.approx(MIKOFF[name], abs=0.002)
    assert found["n_poses"] >= 18
    assert found["diagnosis"]["verdict"] != "effect"


# --- logs with stops that other people made ---------------------------------------------------


def found_in(log: ImuLog, *specs: TriadSpec | None, rate_rad_s: float = 0.0) -> FloatArray:
    """Mean nominal readings (n, 3) of the static intervals, and nothing else of the program."""
    intervals = find_still(log, *specs, rate_rad_s=rate_rad_s)
    spec = specs[intervals.triad == "gyroscope"]
    assert spec is not None
    return np.array([spec.nominal(getattr(rest, intervals.triad)).mean(axis=0)
                     for rest in intervals.logs])


def fitted_by_scipy(vectors: FloatArray, magnitude: float) -> FloatArray:
    """M (its six elements) and b of ``|M (v - b)| = magnitude`` by an independent fit, (9,)."""
    return np.asarray(least_squares(
        lambda x: magnitudes(x, vectors) - magnitude, [1, 0, 0, 1, 0, 1, 0, 0, 0]).x)


def magnitudes(x: FloatArray, vectors: FloatArray) -> FloatArray:
    matrix = np.zeros((3, 3))
    matrix[np.triu_indices(3)] = x[:6]
    return np.asarray(np.linalg.norm((vectors - x[6:]) @ matrix.T, axis=1))


def rows_of(path: Path, columns: int, delimiter: str | None = None) -> FloatArray:
    """The first ``columns`` numbers of every whole row, in the order of time."""
    lines = gzip.decompress(path.read_bytes()).decode().splitlines()
    rows = [line.split(delimiter)[:columns] for line in lines if not line.startswith("#")]
    table = np.array([row for row in rows if len(row) == columns], dtype=float)
    later = np.append(True, table[1:, 0] > np.maximum.accumulate(table[:-1, 0]))
    return np.asarray(table[later])


def timed(table: FloatArray) -> ImuLog:
    """Time and the accelerometer in SI units."""
    return ImuLog("log", table[:, 0] - table[0, 0], table[:, 1:4], np.full((len(table), 3), np.nan))


SI = TriadSpec(np.inf, 0, "si")


@pytest.mark.parametrize(("one", "other", "poses", "rms"), [
    (("sundevil/IMU_Rev2_Data_Long.txt.gz", "\t", 9.7949),
     "sundevil/IMU_Rev2_Data_Short.txt.gz", (27, 33), 5e-3),
    (("snu/imu_good3.txt.gz", None, 9.79871), "snu/imu_good2.txt.gz", (15, 15), 1.1e-3),
    (("snu/imu_good3.txt.gz", None, 9.79871), "snu/imu_good1.txt.gz", (15, 15), 1.9e-3),
])
def test_the_stops_of_one_log_predict_those_of_the_sensor_s_next(
    one: tuple[str, str | None, float], other: str, poses: tuple[int, int], rms: float
) -> None:
    """Stops of a second in a hand, and in a gimbal; an independent fit in between."""
    name, delimiter, gravity = one
    first = found_in(timed(rows_of(REAL / name, 4, delimiter)), SI, None)
    assert poses[0] <= len(first) <= poses[1]
    x = fitted_by_scipy(first, gravity)
    second = found_in(timed(rows_of(REAL / other, 4, delimiter)), SI, None)
    assert np.sqrt(np.mean((magnitudes(x, second) - gravity) ** 2)) < rms


def untimed(name: str, rate_hz: float) -> ImuLog:
    """Three columns without time: an accelerometer, or a gyroscope where the name says so."""
    values = np.loadtxt(REAL / name)
    blank, gyroscope = np.full_like(values, np.nan), "gyr" in name
    return ImuLog("log", np.arange(len(values)) / rate_hz, blank if gyroscope else values,
                  values if gyroscope else blank)


def test_stops_in_a_hand_are_poses_and_a_log_in_a_hand_that_never_stops_has_none() -> None:
    """At 4 times the quietest variance 24 of 70 stops were left, whose scale y was 1.5 % off."""
    stops = found_in(untimed("freeimucal/Officeacc.txt.gz", 69.0), SI, None)
    assert 60 <= len(stops) <= 80
    scale = 1 / fitted_by_scipy(stops, 9.80665)[[0, 3, 5]]
    assert scale == pytest.approx([1.0066, 1.0100, 0.9990], abs=0.004)
    with pytest.raises(Undetermined, match="the sensor never rests"):
        found_in(untimed("freeimucal/acc_data.txt.gz", 69.0), SI, None)


@pytest.mark.parametrize(("name", "rpm", "least"), [
    ("33RPMgyr", 100 / 3, 20), ("45RPMgyr", 45.0, 36),
])  # fmt: skip
def test_stops_between_the_poses_on_somebody_s_record_player_are_left_out(
    tmp_path: Path, name: str, rpm: float, least: int, capsys: pytest.CaptureFixture[str]
) -> None:
    rate = rpm * np.pi / 30
    config = write(tmp_path, f"""
sensor: {{gyroscope: {{unit: rad_s}}}}
rate: {{player: {{rate_rad_s: {rate:.6f}, sd_rad_s: 0.001}}}}
gyroscope:
  runs:
  - rate: player
    poses:
      log: {REAL}/freeimucal/{name}.txt.gz
      columns: [gyr_x, gyr_y, gyr_z]
      sample_rate_hz: 69
      find: still
""")
    assert pipeline("run", config) == 0
    found = results_in(tmp_path / "config.run")["gyroscope"]
    assert found["n_poses"] >= least
    scale = found["parameters"]["scale_counts_per_unit"]
    assert scale == pytest.approx([0.987, 1.012, 1.002], abs=0.004)
    assert "the plate stood still" in capsys.readouterr().err


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
    config = write(tmp_path, """
sensor: {accelerometer: {unit: g}, gyroscope: {unit: deg_s}}
gyroscope:
  model: [bias]
  runs:
  - {poses: {log: log.csv, find: still}, rate: stopped}
""")
    assert pipeline("run", config) == 0
    assert "the plate or the hand turned it" in capsys.readouterr().err
    bias = results_in(tmp_path / "config.run")["gyroscope"]["parameters"]["bias_counts"]
    assert bias == pytest.approx(bias_deg_s, abs=0.05)


# --- sets that determine nothing ----------------------------------------------------------------

GEOMETRY = {
    "mpu6050_tomisuarez": ("""
sensor: mpu-6050
site: {{gravity_m_s2: 9.80665}}
accelerometer:
  poses:
    log: {real}/mpu6050_tomisuarez/example_data_calibration.csv.gz
    sample_rate_hz: 100
    find: still
""", "edge between -x and -y up"),
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
""", "edge between -x and -y up"),
}


@pytest.mark.parametrize("solver", ["default", "paper"])
@pytest.mark.parametrize("name", GEOMETRY)
def test_poses_that_determine_nothing_are_refused_with_what_is_missing(
    tmp_path: Path, name: str, solver: str, capsys: pytest.CaptureFixture[str]
) -> None:
    text, missing = GEOMETRY[name]
    config = write(tmp_path, text.format(real=REAL) + f"  solver: {solver}\n")
    assert pipeline("run", config) == 4
    paragraphs = [line for line in capsys.readouterr().err.splitlines()
                  if not line.startswith("warning: ")]
    assert len(paragraphs) == 1
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
    config = write(tmp_path, """
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
    assert "edge between -x and -y up" in message


LEG_HZ = 16.0  #: rows arrive by radio about that often; the file has no time
LEG_ROWS = 600  #: 37 s of each leg's 45 s


def legs(path: Path) -> list[np.ndarray]:
    """The six legs about one axis each: the LEG_ROWS steadiest rows on either side of each axis."""
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
            found.append(spinning[:LEG_ROWS])
    return found
