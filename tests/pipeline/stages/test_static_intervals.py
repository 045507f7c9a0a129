"""``find: still`` through the command: one long log in, poses and words about what was left out."""

from pathlib import Path

import numpy as np
import pytest

from tests.sessions import pipeline, results_in
from tests.world.hand_turned import MIXING, OFFSET_M_S2, HandTurned, Stop, by_hand, turn_through

pytestmark = pytest.mark.usefixtures("bare_page")

CONFIG = """
sensor: {accelerometer: {unit: m_s2}, gyroscope: {unit: rad_s}}
site: {gravity_m_s2: 9.80665}
accelerometer:
  poses: {log: log.csv, find: still}
"""


def write(folder: Path, log: HandTurned, text: str = CONFIG) -> Path:
    table = np.column_stack([log.time_s, log.force_m_s2, log.rate_rad_s])
    np.savetxt(folder / "log.csv", table, delimiter=",", comments="", fmt="%.6f",
               header="time_s,acc_x,acc_y,acc_z,gyr_x,gyr_y,gyr_z")
    config = folder / "config.yaml"
    config.write_text(text, encoding="utf-8")
    return config


def test_a_hand_turned_log_gives_the_sensor_s_errors(tmp_path: Path) -> None:
    config = write(tmp_path, turn_through(by_hand(41, tremor_m_s2=0.02), 41))
    assert pipeline("run", config) == 0
    found = results_in(tmp_path / "config.run")["accelerometer"]
    assert found["n_poses"] >= 22
    inverse = np.linalg.inv(MIXING)
    scale = found["parameters"]["scale_counts_per_unit"]
    assert scale == pytest.approx(1 / np.diag(inverse), abs=2e-3)
    assert found["parameters"]["bias_counts"] == pytest.approx(OFFSET_M_S2, abs=0.02)


def test_what_is_left_out_is_said_with_how_to_overrule_it(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    stops = [*[Stop(3.0, 0.01)] * 20, Stop(2.0, 0.1), Stop(3.0)]
    strict = CONFIG.replace("find: still", "find: still, still: {threshold: 3}")
    config = write(tmp_path, turn_through(stops, 42), strict)
    assert pipeline("run", config) == 0
    error = capsys.readouterr().err
    assert "21 stops are poses; left out: " in error
    assert ": noisier than " in error
    assert "`still: {threshold: ...}` beside `find: still` overrules that" in error
    generous = CONFIG.replace("find: still", "find: still, still: {threshold: 8, seconds: 1}")
    config = write(tmp_path, turn_through(stops, 42), generous)
    assert pipeline("run", config) == 0
    assert results_in(tmp_path / "config.run")["accelerometer"]["n_poses"] == 22


def test_poses_in_which_a_log_at_rest_turned_are_left_out(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """The same log for both triads; in two of its stops the sensor stands on a turning plate."""
    log = turn_through([Stop(4.0, 0.01)] * 22, 43)
    for start, end in log.rests[10:12]:
        inside = (log.time_s >= start) & (log.time_s < end)
        log.rate_rad_s[inside] += log.force_m_s2[inside] / 9.8 * 1.7
    config = write(tmp_path, log, CONFIG + """
gyroscope:
  model: [bias]
  runs:
  - {poses: {log: log.csv, find: still}, rate: stopped}
""")
    assert pipeline("run", config) == 0
    assert "the plate or the hand turned it" in capsys.readouterr().err
    assert results_in(tmp_path / "config.run")["gyroscope"]["n_poses"] == 20


def test_a_log_that_never_rests_says_so(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    config = write(tmp_path, turn_through([Stop(0.02)] * 60, 44))
    assert pipeline("run", config) == 4
    assert "log.csv: the sensor never rests" in capsys.readouterr().err


@pytest.mark.parametrize(("old", "new", "says"), [
    ("log: log.csv, find: still", "files: log.csv, still: {seconds: 1}", "only with `find: still`"),
    ("find: still", "find: still, still: {second: 1}", "did you mean 'seconds'"),
    ("find: still", "find: still, still: {threshold: 0.5}", "expected a number of at least 1"),
])
def test_a_wrong_still_section_is_refused_with_its_line(
    tmp_path: Path, old: str, new: str, says: str, capsys: pytest.CaptureFixture[str]
) -> None:
    config = write(tmp_path, turn_through([Stop(1.0)] * 2, 45), CONFIG.replace(old, new))
    assert pipeline("check", config) == 2
    error = capsys.readouterr().err
    assert says in error
    assert "config.yaml:5" in error
