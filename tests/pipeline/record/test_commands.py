"""``pipeline ports``, ``record`` and ``playback`` as a user types them."""

import os
import re
import shlex
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from pipeline.playback import PROTOCOLS
from pipeline.record import serial_port as line
from pipeline.record.serial_port import SerialPortInfo, only_port, permission_advice
from tests.paths import ROOT

GUIDE = (ROOT / "data/docs/recording.md").read_text(encoding="utf-8")
REHEARSAL = GUIDE.split("## Rehearse without a sensor")[1]
MINE = REHEARSAL.split("```yaml\n")[1].split("```")[0]
#: What the guide tells to type: the simulated device, and the recording from it.
PLAYBACK, RECORD = (shlex.split(line)[1:]
                    for line in re.findall(r"^    (pipeline .*)$", REHEARSAL, re.MULTILINE))


def pipeline(*arguments: str, folder: Path = ROOT) -> subprocess.CompletedProcess[str]:
    return subprocess.run([sys.executable, "-m", "pipeline", *arguments], cwd=folder, text=True,
                          capture_output=True, check=False, env=ENVIRONMENT)


ENVIRONMENT = {**os.environ, "PYTHONPATH": str(ROOT)}


@pytest.fixture
def port(tmp_path: Path) -> Iterator[str]:
    """The simulated device as the guide starts it, in a folder that has the shipped session."""
    (tmp_path / "data").symlink_to(ROOT / "data")
    process = subprocess.Popen(
        [sys.executable, "-m", "pipeline", *PLAYBACK], cwd=tmp_path, env=ENVIRONMENT,
        stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
    assert process.stdout is not None
    yield process.stdout.readline().strip()
    process.send_signal(signal.SIGINT)
    process.wait(timeout=10)
    process.stdout.close()


def test_a_user_without_hardware_can_rehearse_as_the_guide_says(
    tmp_path: Path, port: str
) -> None:
    assert port == RECORD[RECORD.index("--port") + 1]
    (tmp_path / RECORD[1]).write_text(MINE)
    done = pipeline(*RECORD, folder=tmp_path)
    assert done.returncode == 0, done.stderr
    assert done.stdout.startswith("stopped: 6 of 6 poses\n")
    assert len(re.findall(r"^taken \d of 6: ", done.stderr, re.MULTILINE)) == 6
    again = pipeline(*RECORD, folder=tmp_path)
    assert (again.returncode, "taken" in again.stderr) == (0, False)


def test_ctrl_c_keeps_what_is_taken_and_says_how_to_go_on(tmp_path: Path, port: str) -> None:
    config = tmp_path / "mine.yaml"
    config.write_text(MINE)
    process = subprocess.Popen(
        [sys.executable, "-m", "pipeline", "record", str(config), "--port", port],
        cwd=tmp_path, env=ENVIRONMENT, stderr=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
    until = time.monotonic() + 30
    while not list(tmp_path.glob("rehearsal/pose_*.csv")) and time.monotonic() < until:
        time.sleep(0.05)
    os.kill(process.pid, signal.SIGINT)
    _, errors = process.communicate(timeout=20)
    assert process.returncode == 130
    assert f"Continue with: pipeline record {config}" in errors
    assert "Traceback" not in errors
    assert list(tmp_path.glob("rehearsal/pose_*.csv"))


def test_a_device_that_is_not_there_exits_with_6(tmp_path: Path) -> None:
    config = tmp_path / "mine.yaml"
    config.write_text(MINE)
    done = pipeline("record", str(config), "--port", str(tmp_path / "none"))
    assert (done.returncode, done.stdout) == (6, "")
    assert "there is no such port" in done.stderr


def test_a_configuration_without_record_is_refused(tmp_path: Path) -> None:
    config = tmp_path / "mine.yaml"
    config.write_text(MINE.split("record:")[0])
    done = pipeline("record", str(config))
    assert done.returncode == 2
    assert done.stderr.count("\n") == 1


def test_every_protocol_of_the_simulated_device_is_offered() -> None:
    offered = pipeline("playback", "--help").stdout
    assert all(protocol in offered for protocol in PROTOCOLS)


def test_ports_says_what_to_do_where_none_is(monkeypatch: pytest.MonkeyPatch) -> None:
    done = pipeline("ports")
    assert done.returncode == 0
    assert "No serial port was detected" in done.stdout or "next: set `port:" in done.stdout


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
    done = pipeline("record", str(config), "--port", str(tmp_path / "none"))
    assert done.returncode == 4
    assert "6 poses give 6 equations for 9 parameters" in done.stderr
    done = pipeline("record", str(config), "--port", str(tmp_path / "none"),
                    "--although-undetermined")
    assert done.returncode == 6  # on to the port
