"""The axes of the chart: every pose's columns, and the phase of the plate within the poses."""

import shutil
from pathlib import Path

import numpy as np
import pytest

from calib.poses.conditions import Conditions
from pipeline.config.sensor import sensor_specs
from pipeline.text.formatting import DISPLAY
from pipeline.workbench.chart_columns import PARTS, chart_columns
from pipeline.workbench.live_refits import OpenSession
from pipeline.workbench.own_effect import tried_expression
from tests.paths import DATA

HIDDEN = DATA / "hidden_effect"
CONFIG = """\
sensor:
  name: InvenSense MPU-6050
  accelerometer: {full_scale_g: 2, bits: 16, encoding: twos-complement}
  gyroscope: {full_scale_deg_s: 250, bits: 16, encoding: twos-complement}
site: {latitude_deg: 40.85}
rate: {33rpm: {rate_rad_s: 3.48608, sd_rad_s: 0.0002}}
gyroscope:
  runs: [{poses: 33rpm/pose_*.csv.gz, rate: 33rpm}]
  model: [bias, scale, misalignment]
"""


@pytest.fixture(scope="module")
def session(tmp_path_factory: pytest.TempPathFactory) -> OpenSession:
    folder = tmp_path_factory.mktemp("turning")
    shutil.copytree(HIDDEN / "gyroscope/33rpm", folder / "33rpm")
    (folder / "config.yaml").write_text(CONFIG, encoding="utf-8")
    return OpenSession(folder / "config.yaml", folder / "cache", False)


def test_a_name_that_is_none_is_told_with_those_that_are(session: OpenSession) -> None:
    problem = tried_expression(session, session.as_run(), "gyroscope", "acc_x", "axis")["problem"]
    assert "The logs have: temperature_c; names are " in problem
    assert {"fx", "time_s"} <= set(problem.replace(",", "").split())


def test_time_order_the_other_triad_and_any_logged_column_stand_on_an_axis(
    session: OpenSession
) -> None:
    columns = chart_columns(session, "gyroscope")["columns"]
    assert {"order of the poses", "time [min]", "accelerometer x [m/s²]", "reading z [°/s]",
            "temperature_c"} <= set(columns)
    assert all(len(values) == 18 for values in columns.values())


def test_the_residual_by_the_phase_is_that_of_the_corrected_samples(session: OpenSession) -> None:
    """Against the correction of every sample, folded at the rate that is stated."""
    phase = chart_columns(session, "gyroscope")["phase"]
    assert phase["angle_deg"] == [15 + 30 * j for j in range(PARTS)]
    calibration = session.refitted(session.as_run(), "gyroscope").calibration
    spec = sensor_specs(session.config.sensor)["gyroscope"]
    waves = []
    for k, log in enumerate(session.turning_logs("gyroscope", "33rpm")):
        length = np.linalg.norm(calibration.correct(Conditions.of_vectors(
            spec.nominal(log.gyroscope))), axis=1) * DISPLAY["gyroscope"][1]
        turned = 3.48608 * (log.time_s - log.time_s[0])
        part = (turned / (2 * np.pi) % 1 * PARTS).astype(int)
        folded = np.array([length[part == j].mean() for j in range(PARTS)]) - length.mean()
        noise = length.std() / np.sqrt(len(length) / PARTS)
        assert phase["beside"][k] == pytest.approx(folded, abs=noise)
        waves.append(np.abs(np.exp(1j * np.radians(phase["angle_deg"])) @ folded) * 2 / PARTS)
    assert min(waves) > 0.05  # the plate of this session leans a little: a wave in every pose


def test_poses_at_rest_and_means_have_no_phase(tmp_path: Path) -> None:
    shutil.copytree(DATA / "example", tmp_path / "example")
    config = tmp_path / "example/config.yaml"
    rest = chart_columns(OpenSession(config, tmp_path / "cache", False), "accelerometer")
    assert not any(rest["phase"]["beside"])
