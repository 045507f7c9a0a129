"""A played device in a thread, recordings from it, and the calibration of what they hold."""

import os
import random
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from calib.fit.least_squares.solver import fit
from calib.fit.model import Model
from calib.fit.triad.calibration import TriadCalibration, calibrate_triad
from calib.poses.pose_set import pose_set
from calib.poses.runs.reference_runs import gravity_run
from pipeline.config.load import load_config
from pipeline.config.sensor import triad_spec
from pipeline.record.session import RecordingView
from pipeline.record.session import Session as RecordingSession
from pipeline.record.start import open_session
from pipeline.stages.poses import average_recordings
from pipeline.stages.session_logs import read_session
from tests.fitting import specs_of
from tests.paths import ROOT
from tests.pipeline.record.playback import Protocol
from tests.pipeline.record.playback.device import Faults, PlaybackDevice, Pose
from tests.pipeline.record.playback.pseudo_port import PseudoPort
from tests.world.designs import paper_design
from tests.world.imu import Sensor
from tests.world.session import Session, simulate

AT_ONCE = 10  #: samples that a port without a line gives together
SPEED = 20.0  #: times as fast as in life


def evening(sensor: Sensor | None = None, seed: int = 4, faces_only: bool = False) -> Session:
    """18 poses at rest and 18 on the plate, or 6 and 6, in the world of tests/world."""
    design = paper_design(sensor)
    if faces_only:
        faces = np.vstack([np.eye(3), -np.eye(3)])
        design = replace(design, runs=tuple(replace(run, directions=faces)
                                            for run in design.runs))
    return simulate(design, seed)


def poses_of(session: Session, turning: bool = True) -> list[Pose]:
    return [
        Pose(pose.label, np.hstack([pose.accelerometer, pose.gyroscope]).astype(float),
             pose.columns["temperature_c"])
        for run in session.runs if turning or run.run.motion is None for pose in run.poses
    ]


def write_config(folder: Path, session: Session, device: str, *, seconds: float = 3.0,
                 turning: bool = False, more: str = "") -> Path:
    """A configuration that asks for what ``session`` holds, with nothing recorded yet."""
    preset = "xsens-mti" if session.design.sensor.name.startswith("Xsens") else "mpu-6050"
    rate = session.rates["17rpm"]
    gyro = ("gyroscope:\n  runs:\n    - {poses: gyr/pose_*.csv, rate: slow}\n"
            "    - {poses: acc/pose_*.csv, rate: stopped}\n") if turning else ""
    path = folder / "config.yaml"
    path.write_text(
        f"sensor: {preset}\nsite: {{latitude_deg: 40.85, gravity_m_s2: 9.80267}}\n"
        f"rate:\n  slow: {{rate_rad_s: {rate.rate_rad_s:.9g}, sd_rad_s: {rate.sd_rad_s:.3g}}}\n"
        f"accelerometer: {{poses: acc/pose_*.csv}}\n{gyro}"
        f"record: {{device: {device}, seconds_per_pose: {seconds:g}{more}}}\n", encoding="utf-8")
    return path


@contextmanager
def playing(
    session: Session, protocol: Protocol, *, hold_s: float = 5.5, speed: float = SPEED,
    turning: bool = False, faults: Faults | None = None, link: Path | None = None,
    unplug_every_s: float | None = None,
) -> Iterator[str]:
    """The name of a port on which ``session`` is played."""
    rate_hz = session.design.sample_rate_hz
    device = PlaybackDevice(protocol, poses_of(session, turning), rate_hz, hold_s,
                            specs_of(session.design.sensor), faults=faults)
    port = PseudoPort(link)
    on = threading.Event()
    thread = threading.Thread(
        target=port.play, args=(device, rate_hz * speed), daemon=True,
        kwargs={"on": lambda: not on.is_set(), "unplug_every_s": unplug_every_s,
                "unplugged_s": 0.3})
    thread.start()
    try:
        yield str(link or port.name)
    finally:
        on.set()
        thread.join()
        port.unplug()


class PlayedPort:
    """A played device without a line or a clock between, read as fast as a program can.

    It starts anew after ``restart_after`` samples; see `pipeline.record`'s Port.
    """

    def __init__(
        self, session: Session, protocol: Protocol, *, hold_s: float = 5.5, turning: bool = False,
        faults: Faults | None = None, restart_after: int | None = None,
    ) -> None:
        self._begin = lambda: PlaybackDevice(
            protocol, poses_of(session, turning), session.design.sample_rate_hz, hold_s,
            specs_of(session.design.sensor), faults=faults)
        self._device, self._left = self._begin(), restart_after
        self._answers = b""

    def read(self) -> tuple[bytes, float]:
        data, self._answers = self._answers, b""
        if self._left is not None:
            self._left -= AT_ONCE
            self._device = self._begin() if self._left == 0 else self._device
        if self._device.measuring:
            data += b"".join(self._device.next_sample() for _ in range(AT_ONCE))
        return data, time.monotonic()

    def write(self, data: bytes) -> None:
        self._answers += self._device.answer(data)

    def set_baud(self, baud: int) -> None: ...

    def close(self) -> None: ...


def record_from(config: Path, port: PlayedPort) -> "Onlooker":
    """Record what the configuration asks for from a port without a line."""
    watcher = onlooker()
    RecordingSession(load_config(config, files_may_be_missing=True), lambda _: port, watcher).run()
    return watcher


@dataclass
class Onlooker:
    """Remembers what a recording says and shows."""

    said: list[str]
    phases: set[str]

    def say(self, text: str) -> None:
        self.said.append(text)

    def show(self, view: RecordingView) -> None:
        self.phases.add(view.status.phase)

    def recorded(self, text: str) -> None:
        self.said.append(text)


def onlooker() -> Onlooker:
    return Onlooker([], set())


def record(config: Path, port: str, watcher: Onlooker | None = None) -> Onlooker:
    """Record what the configuration asks for, in this process."""
    watcher = watcher or onlooker()
    open_session(load_config(config, files_may_be_missing=True), watcher, port=port).run()
    return watcher


def calibrated(config: Path) -> TriadCalibration:
    """The accelerometer by the poses that were recorded."""
    loaded = load_config(config)
    assert loaded.accelerometer is not None
    recordings = average_recordings(loaded, read_session(loaded), {})
    assert loaded.sensor.accelerometer is not None
    spec = triad_spec(loaded.sensor.accelerometer)
    run = gravity_run("stopped", recordings.of(loaded.accelerometer.at_rest[0]).means, 9.80267, 0.0)
    poses = pose_set("accelerometer", [run], recordings.origin_s)
    return calibrate_triad(fit(poses, Model.of(("bias", "scale", "misalignment"))), spec)


def record_with_kills(config: Path, port: str, kills: int, seed: int) -> int:
    """Record in a process that is killed ``kills`` times; how often it was still running then."""
    rng = random.Random(seed)
    command = [sys.executable, "-m", "pipeline", "record", str(config), "--port", port]
    done = 0
    for _ in range(kills):
        process = subprocess.Popen(command, cwd=ROOT, stderr=subprocess.DEVNULL,
                                   stdout=subprocess.DEVNULL)
        time.sleep(rng.uniform(1.0, 3.0))
        if process.poll() is None:
            os.kill(process.pid, signal.SIGKILL)
            done += 1
        process.wait()
    subprocess.run(command, cwd=ROOT, check=True, capture_output=True)
    return done
