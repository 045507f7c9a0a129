"""A guided recording over a real pseudo-terminal and pyserial, with every trouble of the line."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from calib.fit.triad.calibration import TriadCalibration
from calib.poses.averaging.average_pose import average_pose
from calib.poses.imu_log import TRIADS
from calib.poses.runs.ring import tilt_of_run
from pipeline.config.load import load_config
from pipeline.errors import ConfigError, DeviceError
from pipeline.logs.read import read_log
from pipeline.record.blocks import recording_blocks
from tests.fitting import specs_of
from tests.pipeline.record.play import (
    PlayedPort,
    calibrated,
    evening,
    playing,
    record,
    record_from,
    record_with_kills,
    write_config,
)
from tests.pipeline.record.playback import Protocol
from tests.pipeline.record.playback.device import Faults
from tests.sessions import edit
from tests.world.designs import SLOW, tilted_design
from tests.world.imu import mpu6050
from tests.world.make_data import WOW
from tests.world.plate import PlateMotion
from tests.world.session import Session, simulate


@pytest.fixture(scope="module")
def mti_evening() -> Session:
    return evening()


@pytest.fixture(scope="module")
def mpu_evening() -> Session:
    return evening(mpu6050())


@pytest.fixture(scope="module")
def six_faces() -> Session:
    return evening(faces_only=True)


def assert_true(found: TriadCalibration, session: Session) -> None:
    """Every parameter within 4.5 of its sds of the truth."""
    truth = session.accelerometer
    misalignment, bias, scale = found.parameters.sd
    for value, true, sd in (
        (found.parameters.misalignment_rad, truth.misalignment_rad, misalignment),
        (found.parameters.bias_counts, truth.bias_counts, bias),
        (found.parameters.scale_counts_per_unit, truth.scale_counts_per_unit, scale),
    ):
        assert np.abs((value - true) / sd).max() < 4.5


@pytest.mark.parametrize(("protocol", "device"), [
    ("xsens-mti", "xsens-mti"), ("sketch", "mpu-6050"),
])
def test_eighteen_poses_are_recorded_and_calibrate_to_the_truth(
    tmp_path: Path, mti_evening: Session, mpu_evening: Session, protocol: Protocol, device: str
) -> None:
    session = mti_evening if protocol == "xsens-mti" else mpu_evening
    more = ", sample_rate_hz: 100" if protocol != "sketch" else ""
    config = write_config(tmp_path, session, device, more=more)
    watcher = record_from(config, PlayedPort(session, protocol))
    assert sum(message.startswith("taken ") for message in watcher.said) == 18
    assert "taken 18 of 18" in watcher.said[-1]
    assert len(list((tmp_path / "acc").glob("pose_*.csv"))) == 18
    assert_true(calibrated(config), session)


def test_all_bytes_and_both_clocks_are_kept(tmp_path: Path, six_faces: Session) -> None:
    config = write_config(tmp_path, six_faces, "xsens-mti", more=", poses: 6")
    with playing(six_faces, "xsens-mti") as port:
        record(config, port)
    from pipeline.devices.xsens import XsensParser

    parser = XsensParser()
    raw = (tmp_path / "config.record" / "raw" / "001.bin").read_bytes()
    samples = parser.feed(raw)
    pose = read_log(tmp_path / "acc" / "pose_01.csv")
    times = np.genfromtxt(tmp_path / "config.record" / "times" / "acc_pose_01.csv", delimiter=",",
                          names=True)
    heard = [samples[int(i)].accelerometer for i in times["sample"]]
    assert len(heard) == 300
    np.testing.assert_array_equal(pose.accelerometer, heard)
    np.testing.assert_allclose(np.diff(times["time_s"]), 0.01, atol=2e-6)
    assert (np.diff(times["heard_s"]) >= 0).all()
    arrivals = np.loadtxt(tmp_path / "config.record" / "raw" / "001.arrivals.csv", delimiter=",",
                          skiprows=1)
    assert arrivals[-1, 0] == len(raw)


def test_a_line_full_of_damage_still_calibrates_to_the_truth(
    tmp_path: Path, mpu_evening: Session
) -> None:
    config = write_config(tmp_path, mpu_evening, "mpu-6050")
    faults = Faults(lost=0.01, flipped=0.01, garbage=0.01)
    record_from(config, PlayedPort(mpu_evening, "sketch", faults=faults))
    assert_true(calibrated(config), mpu_evening)


def test_an_unplugged_device_is_waited_for(tmp_path: Path, mpu_evening: Session) -> None:
    config = write_config(tmp_path, mpu_evening, "mpu-6050", more=", poses: 6")
    with playing(mpu_evening, "sketch", link=tmp_path / "port", unplug_every_s=2.0) as port:
        watcher = record(config, port)
    assert any("the device is gone" in message for message in watcher.said)
    assert "the device is back" in watcher.said
    assert len(list((tmp_path / "acc").glob("pose_*.csv"))) == 6


def test_on_the_plate_poses_hold_three_turns(tmp_path: Path, six_faces: Session) -> None:
    config = write_config(tmp_path, six_faces, "xsens-mti", turning=True, more=", poses: 6")
    record_from(config, PlayedPort(six_faces, "xsens-mti", hold_s=14.0, turning=True))
    for path in (tmp_path / "gyr").glob("pose_*.csv"):
        assert np.ptp(read_log(path).time_s) > 3 * 2 * np.pi / 1.7454 - 0.02
    assert len(list((tmp_path / "gyr").glob("pose_*.csv"))) == 6


def test_on_a_leaning_plate_both_triads_are_recorded_at_once(tmp_path: Path) -> None:
    design = tilted_design(20.0, motion=PlateMotion(SLOW, wow=WOW))
    run = replace(design.runs[0], directions=np.vstack([np.eye(3), -np.eye(3)]))
    session = simulate(replace(design, runs=(run,)), 6)
    config = write_config(tmp_path, session, "mpu-6050", turning=True, more=", poses: 6")
    run_text = "{poses: gyr/pose_*.csv, rate: slow}"
    config.write_text(config.read_text()
                      .replace("accelerometer: {poses: acc/pose_*.csv}",
                               f"accelerometer: {{runs: [{run_text}]}}")
                      .replace("    - {poses: acc/pose_*.csv, rate: stopped}\n", ""))
    said = record_from(config, PlayedPort(session, "sketch", hold_s=14.0, turning=True)).said
    assert any("with 5 cm under one side of the record player" in line for line in said)
    paths = list((tmp_path / "gyr").glob("pose_*.csv"))
    assert len(paths) == 6
    specs = dict(zip(TRIADS, specs_of(session.design.sensor), strict=True))
    means = [average_pose(read_log(path), specs, SLOW) for path in paths]
    assert np.degrees(tilt_of_run(means) or 0.0) == pytest.approx(20.0, abs=0.5)


def test_a_pose_during_which_the_device_starts_anew_is_taken_again(
    tmp_path: Path, mpu_evening: Session
) -> None:
    config = write_config(tmp_path, mpu_evening, "mpu-6050", more=", poses: 6")
    watcher = record_from(config, PlayedPort(mpu_evening, "sketch", hold_s=6.0, restart_after=400))
    assert sum("started anew" in text for text in watcher.said) == 1
    assert not any("It moved" in text for text in watcher.said)
    for path in (tmp_path / "acc").glob("pose_*.csv"):
        np.testing.assert_allclose(np.diff(read_log(path).time_s), 0.01, atol=2e-6)
    assert len(list((tmp_path / "acc").glob("pose_*.csv"))) == 6


def test_a_plate_that_turns_the_other_way_is_recorded_alike(
    tmp_path: Path, six_faces: Session
) -> None:
    config = write_config(tmp_path, six_faces, "xsens-mti", turning=True, more=", poses: 6")
    as_usual = recording_blocks(load_config(config, files_may_be_missing=True))
    edit(config, "{rate_rad_s: ", "{rate_rad_s: -")
    assert recording_blocks(load_config(config, files_may_be_missing=True)) == as_usual
    (turning,) = [block for block in as_usual if block.turns]
    assert turning.seconds == pytest.approx(3 * 2 * np.pi / 1.7454, rel=1e-3)


def test_the_pattern_of_digits_that_import_writes_is_recorded_on(
    tmp_path: Path, six_faces: Session
) -> None:
    config = write_config(tmp_path, six_faces, "xsens-mti")
    as_usual = recording_blocks(load_config(config, files_may_be_missing=True))
    edit(config, "acc/pose_*.csv", '"acc/pose_[0-9][0-9].csv"')
    assert recording_blocks(load_config(config, files_may_be_missing=True)) == as_usual


def test_what_is_taken_is_not_asked_for_again(tmp_path: Path, six_faces: Session) -> None:
    config = write_config(tmp_path, six_faces, "xsens-mti", more=", poses: 6")
    record_from(config, PlayedPort(six_faces, "xsens-mti"))
    before = {path: path.read_bytes() for path in (tmp_path / "acc").iterdir()}
    (tmp_path / "acc" / "pose_03.csv").unlink()
    watcher = record_from(config, PlayedPort(six_faces, "xsens-mti"))
    assert any(text.startswith("1 pose of 3 s") and "5 are recorded" in text
               for text in watcher.said)
    assert set((tmp_path / "acc").iterdir()) == set(before)
    changed = [path.name for path, data in before.items() if path.read_bytes() != data]
    assert changed == ["pose_03.csv"]


def test_a_recording_killed_again_and_again_ends_like_an_undisturbed_one(
    tmp_path: Path, mti_evening: Session
) -> None:
    (tmp_path / "a").mkdir()
    (tmp_path / "b").mkdir()
    undisturbed = write_config(tmp_path / "a", mti_evening, "xsens-mti")
    killed = write_config(tmp_path / "b", mti_evening, "xsens-mti")
    record_from(undisturbed, PlayedPort(mti_evening, "xsens-mti"))
    with playing(mti_evening, "xsens-mti") as port:
        assert record_with_kills(killed, port, kills=2, seed=1) == 2
    assert not list((tmp_path / "b" / "acc").glob(".*"))
    once, again = (np.array([np.mean(read_log(path).accelerometer, axis=0)
                             for path in sorted((tmp_path / name / "acc").glob("*.csv"))])
                   for name in "ab")
    apart = np.linalg.norm(once[:, None] - again, axis=2)
    assert apart.shape == (18, 18)
    np.testing.assert_array_less(apart.min(axis=0), 3.0)  # counts: samples differ by the beginning
    np.testing.assert_array_less(apart.min(axis=1), 3.0)


@pytest.mark.parametrize(("protocol", "device", "more", "message"), [
    ("xsens-mti", "mpu-6050", ", baud: 9600", "The port is open, but nothing comes|Bytes come"),
    ("binary", "lines", ", baud: 9600, pattern: '{acc_x},{acc_y},{acc_z}'", "Bytes come|none fits"),
    ("sketch", "xsens-mti", ", baud: 9600", "does not answer message 0x30"),
])
def test_another_device_than_named_is_told(
    tmp_path: Path, mpu_evening: Session, mti_evening: Session, protocol: Protocol, device: str,
    more: str, message: str,
) -> None:
    session = mti_evening if protocol == "xsens-mti" else mpu_evening
    config = write_config(tmp_path, session, device, more=more)
    with (playing(session, protocol) as port, pytest.raises(DeviceError, match=message)):
        record(config, port)


def test_an_absent_port_is_told_with_those_there_are(tmp_path: Path, mti_evening: Session) -> None:
    config = write_config(tmp_path, mti_evening, "xsens-mti")
    with pytest.raises(DeviceError, match="there is no such port"):
        record(config, str(tmp_path / "nothing"))


def test_a_port_in_use_is_told(tmp_path: Path, mti_evening: Session) -> None:
    from pipeline.record.serial_port import SerialPort

    config = write_config(tmp_path, mti_evening, "xsens-mti")
    with playing(mti_evening, "xsens-mti") as port:
        other = SerialPort(port, 115200)
        with pytest.raises(DeviceError, match="another program uses it"):
            record(config, port)
        other.close()


def test_a_configuration_without_places_for_poses_is_refused(
    tmp_path: Path, mti_evening: Session
) -> None:
    config = write_config(tmp_path, mti_evening, "xsens-mti")
    text = config.read_text()
    config.write_text(text.replace("acc/pose_*.csv", "[acc/a.csv, acc/b.csv]"))
    with pytest.raises(ConfigError, match="no names of new files follow"):
        record(config, "unused")
    config.write_text(text.split("record:")[0])
    with pytest.raises(ConfigError, match="has no section `record`"):
        record(config, "unused")


def test_another_unit_or_range_than_the_data_sheet_is_refused(
    tmp_path: Path, mpu_evening: Session
) -> None:
    config = write_config(tmp_path, mpu_evening, "mpu-6050")
    config.write_text(config.read_text().replace(
        "sensor: mpu-6050", "sensor: {accelerometer: {unit: m_s2}, gyroscope: {unit: rad_s}}"))
    with (playing(mpu_evening, "sketch") as port,
          pytest.raises(ConfigError, match="sends readings in counts")):
        record(config, port)
