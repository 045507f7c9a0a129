"""Filming: true time stamps in the container, clips that belong to their poses."""

import time
from pathlib import Path

import cv2
import numpy as np
import pytest

from pipeline.config.load import load_config
from pipeline.errors import ConfigError, DeviceError
from pipeline.logs.read import read_log
from pipeline.record.start import open_session
from pipeline.stages.live_clip import opened_camera
from tests.pipeline.record.play import evening, onlooker, playing, write_config
from tests.world.film import Recorder, film
from tests.world.plate import PlateMotion
from vision.camera import Camera, CameraFailed, _Stamp
from vision.rate.measure import measure_rate
from vision.rate.timebase import Timebase
from vision.tracking.track import track_phase

RATE = 3.4907  # 33 1/3 rpm


@pytest.fixture(scope="module")
def uneven_film(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A film whose pictures come unevenly, as a webcam's do."""
    path = tmp_path_factory.mktemp("film") / "plate.mp4"
    film(path, PlateMotion(RATE), fps=15.0, seconds=9.0,
         recorder=Recorder(jitter_s=0.01, dropped=0.1))
    return path


def stamps(path: Path) -> np.ndarray:
    capture, found = cv2.VideoCapture(str(path)), []
    while capture.read()[0]:
        found.append(capture.get(cv2.CAP_PROP_POS_MSEC) / 1e3)
    return np.array(found)


def test_a_clip_keeps_the_times_of_its_pictures_and_so_the_rate(
    uneven_film: Path, tmp_path: Path
) -> None:
    camera = Camera(uneven_film)
    time.sleep(0.4)
    camera.start(tmp_path / "clip_01.mkv")
    time.sleep(7.5)
    clip = camera.stop(keep=True)
    camera.close()
    assert clip is not None
    table = np.genfromtxt(tmp_path / "clip_01.times.csv", delimiter=",", names=True)
    assert len(table) == clip.frames == len(stamps(clip.path))
    np.testing.assert_allclose(stamps(clip.path), table["time_s"], atol=6e-4)
    source = stamps(uneven_film)
    steps = np.diff(table["time_s"])
    windows = [np.diff(source)[i : i + len(steps)] for i in range(len(source) - len(steps))]
    assert min(np.abs(w - steps).max() for w in windows) < 1e-4
    rate = measure_rate(track_phase(clip.path), timebase=Timebase(ppm=0.0), nominal_rpm=33.3)
    assert rate.rate_rad_s == pytest.approx(RATE, abs=4 * rate.sd_rad_s)
    assert rate.sd_rad_s < 5e-4 * RATE


def test_a_clip_that_is_not_kept_leaves_nothing(uneven_film: Path, tmp_path: Path) -> None:
    camera = Camera(uneven_film)
    camera.start(tmp_path / "clip_01.mkv")
    time.sleep(0.5)
    assert camera.stop(keep=False) is None
    camera.close()
    assert list(tmp_path.iterdir()) == []


def test_what_was_filmed_before_a_crash_can_be_read(uneven_film: Path, tmp_path: Path) -> None:
    camera = Camera(uneven_film)
    camera.start(tmp_path / "clip_01.mkv")
    time.sleep(3.0)
    (hidden,) = tmp_path.glob(".filming-*")
    survives = tmp_path / "survives.mkv"
    survives.write_bytes(hidden.read_bytes())  # as the disk has it when the process is killed
    camera.close()
    assert len(stamps(survives)) > 10


def test_a_driver_s_stamps_are_taken_only_if_they_keep_pace() -> None:
    now = [100.0]
    good, frozen, slow = (_Stamp(lambda: now[0]) for _ in range(3))
    late = np.random.default_rng(1).exponential(0.01, 60)
    for i in range(60):
        recorded = i / 30
        now[0] = 100.0 + recorded + late[i]
        a, b, c = good(recorded), frozen(0.0), slow(recorded / 2)
        if i > 30:
            assert a - 100.0 == pytest.approx(recorded + late[: i + 1].min(), abs=1e-3)
            assert b == pytest.approx(now[0], abs=0.05)
            assert c == pytest.approx(now[0], abs=0.05)


def test_an_absent_camera_is_told() -> None:
    with pytest.raises(CameraFailed, match="camera 97 cannot be opened"):
        Camera(97)
    with pytest.raises(DeviceError, match="0 is the first"):
        opened_camera(97, time.monotonic)


@pytest.fixture
def played_camera(uneven_film: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A clip in the place of the first camera."""
    monkeypatch.setattr("pipeline.stages.live_clip.Camera",
                        lambda _number, clock, watch: Camera(uneven_film, clock, watch))


@pytest.mark.usefixtures("played_camera")
def test_each_pose_on_the_plate_has_its_clip_on_the_same_clock(tmp_path: Path) -> None:
    session = evening(faces_only=True)
    config = write_config(tmp_path, session, "xsens-mti", turning=True, more=", poses: 6")
    rate = "{video: video/slow_*.mkv, nominal_rpm: 16.667}"
    lines = [f"  slow: {rate}" if line.startswith("  slow:") else line
             for line in config.read_text().splitlines()]
    config.write_text("\n".join(lines) + "\n")
    watcher = onlooker()
    with playing(session, "xsens-mti", hold_s=14.0, turning=True) as port:
        open_session(load_config(config, files_may_be_missing=True), watcher, port=port,
                     camera=0).run()
    poses = sorted((tmp_path / "gyr").glob("pose_*.csv"))
    clips = sorted((tmp_path / "video").glob("slow_*.mkv"))
    assert [path.stem[-2:] for path in poses] == [path.stem[-2:] for path in clips]
    assert len(clips) == 6
    # Both times are the session's: the clip runs while the pose is heard; the next is 14 s later.
    for clip, pose in zip(clips, poses, strict=True):
        filmed = np.genfromtxt(clip.with_suffix(".times.csv"), delimiter=",", names=True)
        times = tmp_path / "config.record" / "times" / f"gyr_{pose.name}"
        heard = np.genfromtxt(times, delimiter=",", names=True)["heard_s"]
        assert filmed["session_s"][0] == pytest.approx(heard[0], abs=2)
        assert filmed["session_s"][-1] == pytest.approx(heard[-1], abs=2)
    assert load_config(config).rate["slow"] is not None  # clips pair with poses
    assert read_log(poses[0]).has("gyroscope")


@pytest.mark.usefixtures("played_camera")
def test_filming_needs_a_name_for_the_clip_of_every_pose(tmp_path: Path) -> None:
    config = write_config(tmp_path, evening(), "xsens-mti", turning=True)
    with pytest.raises(ConfigError, match=r"Write `video: video/slow_\*.mkv`"):
        open_session(load_config(config, files_may_be_missing=True), onlooker(), port="unused",
                     camera=0)
