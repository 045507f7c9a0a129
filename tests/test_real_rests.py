"""Static intervals in other people's logs: stops in a hand, in a gimbal, on a plate."""

import gzip
from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import least_squares

from calib.errors import Undetermined
from calib.poses.data_sheet import TriadSpec
from calib.poses.imu_log import TRIADS, FloatArray, ImuLog
from calib.poses.rests.static_intervals import find_still
from tests.paths import REAL
from tests.sessions import configured, pipeline, results_in

pytestmark = pytest.mark.skipif(not REAL.is_dir(), reason=f"no measured logs in {REAL}")


def found_in(log: ImuLog, *specs: TriadSpec | None, rate_rad_s: float = 0.0) -> FloatArray:
    """Mean nominal readings (n, 3) of the static intervals, and nothing else of the program."""
    stated = {triad: spec for triad, spec in zip(TRIADS, specs, strict=False) if spec is not None}
    intervals = find_still(log, stated, rate_rad_s=rate_rad_s)
    spec = stated[intervals.triad]
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
    ("33RPMgyr", 100 / 3, 20), ("45RPMgyr", 45.0, 33),
])  # fmt: skip
def test_stops_between_the_poses_on_somebody_s_record_player_are_left_out(
    tmp_path: Path, name: str, rpm: float, least: int, capsys: pytest.CaptureFixture[str]
) -> None:
    rate = rpm * np.pi / 30
    # Six of the 39 rests at 45 rpm hold blocks that the link repeated, and are left out.
    config = configured(tmp_path, f"""
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
