"""``pipeline record`` as a user types it: with a port, without, and without hardware."""

import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from calib.numbers import RPM
from calib.poses.imu_log import TRIADS
from pipeline.cli import main
from pipeline.plan import so_far
from pipeline.record import demo
from pipeline.record import serial_port as line
from pipeline.record.serial_port import SerialPortInfo, only_port, permission_advice
from tests.paths import ROOT
from tests.sessions import results_in, typed

MINE = """sensor: xsens-mti
site: {latitude_deg: 40.85, height_m: 20}
accelerometer: {poses: rehearsal/pose_*.csv, model: [bias]}
record: {device: xsens-mti, poses: 6, seconds_per_pose: 3, order: random}
"""


ENVIRONMENT = {**os.environ, "PYTHONPATH": str(ROOT)}


def test_a_user_without_hardware_rehearses_in_one_terminal(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(demo, "SPEED", 2000.0)
    monkeypatch.setattr(demo, "READ_S", 0.0)
    assert main(["record", "--demo"]) == 0
    out, err = capsys.readouterr()
    assert out.startswith("stopped: 18 of 18 poses\n33rpm: 18 of 18 poses\n")
    assert len(re.findall(r"^taken \d+ of 18: ", err, re.MULTILINE)) == 36
    assert "scale to" in err
    assert "complete" in err
    assert main(["record", "--demo"]) == 0  # nothing is asked for again
    assert "taken" not in capsys.readouterr().err
    assert main(["run", "pipeline-rehearsal"]) == 0
    results = results_in(tmp_path / "pipeline-rehearsal/config.run")
    filmed = f"33rpm      {results['rate']['33rpm']['rate_rad_s'] / RPM:.4f} rpm"
    assert f"rate {filmed}" in (ROOT / "README.md").read_text("utf-8")  # measured in its clip
    for triad, gain, unit in (("accelerometer", demo.GAIN[0], 2 * 9.80665),
                              ("gyroscope", demo.GAIN[1], np.radians(250.0))):
        np.testing.assert_allclose(results[triad]["parameters"]["scale_counts_per_unit"],
                                   gain * 32768 / unit, rtol=2e-3)


def test_simulated_poses_do_not_come_among_measured_ones(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "pipeline-rehearsal").mkdir()
    (tmp_path / "pipeline-rehearsal/config.yaml").write_text(MINE)
    assert main(["record", "--demo"]) == 2
    assert "is no rehearsal" in capsys.readouterr().err


def test_ctrl_c_keeps_what_is_taken_and_says_how_to_go_on(tmp_path: Path) -> None:
    process = subprocess.Popen(
        [sys.executable, "-m", "pipeline", "record", "--demo"], cwd=tmp_path, env=ENVIRONMENT,
        stderr=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
    until = time.monotonic() + 30
    poses = tmp_path / "pipeline-rehearsal/accelerometer"
    while not list(poses.glob("pose_*.csv")) and time.monotonic() < until:
        time.sleep(0.05)
    os.kill(process.pid, signal.SIGINT)
    _, errors = process.communicate(timeout=240)
    assert process.returncode == 130
    assert "Continue with: pipeline record --demo" in errors
    assert "Traceback" not in errors
    assert list(poses.glob("pose_*.csv"))


def test_a_device_that_is_not_there_exits_with_6(tmp_path: Path) -> None:
    config = tmp_path / "mine.yaml"
    config.write_text(MINE)
    code, printed, errors = typed("record", config, "--port", tmp_path / "none")
    assert (code, printed) == (6, "")
    assert "there is no such port" in errors


def test_a_configuration_without_record_is_refused(tmp_path: Path) -> None:
    config = tmp_path / "mine.yaml"
    config.write_text(MINE.split("record:")[0])
    code, _, errors = typed("record", config)
    assert code == 2
    assert errors.count("\n") == 1


@pytest.mark.parametrize("asked", [("record", "--ports"), ("ports",)])
def test_ports_says_what_to_do_where_none_is(
    asked: tuple[str, ...], monkeypatch: pytest.MonkeyPatch
) -> None:
    code, printed, _ = typed(*asked)
    assert code == 0
    assert "No serial port was detected" in printed or "next: set `port:" in printed


def test_permissions_are_explained(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "platform", "linux")
    assert "sudo usermod -aG dialout $USER" in permission_advice("/dev/nothing")


@pytest.mark.parametrize(("ports", "message"), [
    ([], "no USB serial port is there"),
    ([SerialPortInfo("COM3", "", "Arduino", True), SerialPortInfo("COM4", "", "Xsens", True)],
     r"there are 2 USB serial ports: COM3 \(Arduino\), COM4 \(Xsens\)"),
])
def test_the_port_is_asked_for_where_it_is_not_clear(
    monkeypatch: pytest.MonkeyPatch, ports: list[SerialPortInfo], message: str
) -> None:
    monkeypatch.setattr(line, "find_ports", lambda: ports)
    with pytest.raises(line.DeviceError, match=message):
        only_port()
    monkeypatch.setattr(line, "find_ports", lambda: [SerialPortInfo("COM3", "", "Arduino", True)])
    assert only_port() == "COM3"


def test_poses_that_determine_nothing_are_refused_before_the_first(tmp_path: Path) -> None:
    config = tmp_path / "mine.yaml"
    config.write_text(MINE.replace(", model: [bias]", ""))
    port = ("--port", tmp_path / "none")
    code, _, errors = typed("record", config, *port)
    assert code == 4
    assert "6 poses give 6 equations for 9 parameters" in errors
    assert typed("record", config, *port, "--anyway")[0] == 6  # on to the port


def test_a_line_about_a_triad_is_said_where_it_has_changed(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    sds = iter([[(18, 7e-5)], [(18, 7e-5)], [(18, 7e-5), (30, 6e-5)], [(19, 7e-5), (30, 6e-5)]])
    monkeypatch.setattr(so_far, "outlook_so_far", lambda _: [
        so_far.SoFar(triad, poses, sd, 1.0, None, "")
        for triad, (poses, sd) in zip(TRIADS, next(sds), strict=False)])
    outlook = so_far.Outlook(Path())
    told = [outlook.lines_after(f"taken {i}") for i in range(4)]
    assert [len(lines) for lines in told] == [2, 1, 2, 2]
    assert ["accelerometer" in line for line in (told[0][1], told[2][1], told[3][1])] == [
        True, False, True]
    assert outlook.lines_after("taken 3") == told[3]  # another display asks for the same
