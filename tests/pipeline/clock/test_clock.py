"""`pipeline clock`: a filmed screen, the computer's clock, and the session that uses the result."""

import json
from collections.abc import Callable
from dataclasses import asdict
from datetime import date
from pathlib import Path

import numpy as np
import pytest

from pipeline.cameras import CameraClock, keep_camera, known_cameras
from pipeline.clock.screen import HAND_RPM, DrawnHand
from pipeline.config.load import load_config
from pipeline.config.session import named_files
from pipeline.errors import ConfigError
from pipeline.stages.plate_settings import clock as timebase_of
from tests import sessions
from tests.vision.rendered_clips import small_scene
from tests.world.film import Recorder, film
from tests.world.screen import ScreenHand

RATE = HAND_RPM * 2 * np.pi / 60
Typed = Callable[..., tuple[int, str, str]]


@pytest.fixture
def home(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A user without cameras."""
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path / "user"))
    return tmp_path


@pytest.fixture
def typed(capfdbinary: pytest.CaptureFixture[bytes]) -> Typed:
    """A command: its exit code, what it printed, and what it said on standard error."""
    def type_it(*words: str | Path) -> tuple[int, str, str]:
        code = sessions.pipeline(*words)
        done = capfdbinary.readouterr()
        return code, done.out.decode(), done.err.decode()

    return type_it


def c920(measured: date = date(2026, 11, 23)) -> CameraClock:
    return CameraClock("c920", 80.0, 4.0, {"frames": 1.0}, measured, "a test")


def test_a_simulated_camera_80_ppm_off_is_found_within_8_ppm(home: Path, typed: Typed) -> None:
    """The page runs 25 ppm fast, which its comparison with the computer tells."""
    hand = ScreenHand(RATE, 59.93, 1 / 100, page_ppm=25.0, missed=0.003)
    clip = home / "film.mp4"
    scene = small_scene(width_px=160, height_px=120, centre_px=(77.0, 61.0), radius_px=47.6,
                        exposure_s=1 / 100, line_time_s=4e-5, noise=2.0)
    film(clip, hand, scene, fps=10, seconds=200, start_s=1.0, recorder=Recorder(clock_ppm=80),
         seed=5)
    shown = DrawnHand(RATE, 59.93 / (1 + 25e-6), 25.0, 2.0, "a test", 0.003, 210, "2026-11-23")
    screen = home / "screen.json"
    screen.write_text(json.dumps(asdict(shown)), encoding="utf-8")
    code, out, err = typed("clock", "--camera", "c920", "--clip", clip, "--screen", screen)
    assert (code, err) == (0, "")
    found = known_cameras()["c920"]
    assert found.sd_ppm <= 8
    assert abs(found.fast_ppm - 80) < found.sd_ppm
    assert f"fast by {found.fast_ppm:.1f} ppm ± {found.sd_ppm:.1f} ppm" in out
    for part, sd in found.parts_ppm.items():
        assert f"{part:<22} {sd:5.1f} ppm" in out
    assert "write `timebase: {camera: c920}`" in out
    assert out.splitlines()[-1] == str(home / "user/turntable-imu-calibration/cameras.json")
    assert found.fast_ppm == pytest.approx(80, abs=8)


def test_a_film_of_something_else_is_refused_and_leaves_no_clock(home: Path, typed: Typed) -> None:
    (home / "screen.json").write_text('{"rate_rad_s": -1}', encoding="utf-8")
    code, _, err = typed("clock", "--camera", "c920", "--clip", "data/example/video/17rpm.mp4",
                            "--screen", home / "screen.json")
    assert code == 3
    assert "describes no drawn hand" in err
    code, _, err = typed("clock", "--camera", "c920", "--clip", "data/example/video/17rpm.mp4")
    assert code == 3
    assert "`pipeline clock --show`" in err
    assert not known_cameras()
    assert typed("clock") == (0, "no clock is known. next: pipeline clock --camera NAME\n", "")


@pytest.mark.parametrize(("options", "says"), [
    (("--show", "--camera", "a"), "--show only draws"),
    (("--clip", "film.mp4"), "--clip needs --camera NAME"),
    (("--camera", "a", "--screen", "s.json"), "--screen belongs to --clip"),
    (("--camera", "a", "--keep", "film.avi"), "--keep FILE.mkv"),
    (("--camera", " "), "--camera needs a name"),
])
def test_options_that_make_no_sense_are_refused(
    options: tuple[str, ...], says: str, typed: Typed
) -> None:
    code, _, err = typed("clock", *options)
    assert code == 2
    assert says in err


CONFIG = """\
rate:
  slow: {{video: {clip}, timebase: {{{timebase}}}}}
"""


def test_a_session_uses_the_clock_and_its_age(home: Path, typed: Typed) -> None:
    keep_camera(c920(date(2020, 1, 1)))
    clip = Path("data/example/video/17rpm.mp4").resolve()
    config = home / "config.yaml"
    config.write_text(CONFIG.format(clip=clip, timebase="camera: c920"), encoding="utf-8")
    code, _, err = typed("run", config, "--output", home / "run", "--json")
    assert (code, err) == (0, "")
    plain = home / "plain.yaml"
    plain.write_text(CONFIG.format(clip=clip, timebase="ppm: 50"), encoding="utf-8")
    assert typed("run", plain, "--output", home / "plain")[0] == 0
    with_clock, without = (json.loads((home / name / "results.json").read_text())["rate"]["slow"]
                           for name in ("run", "plain"))
    # A clock that is fast makes the plate seem slow.
    assert with_clock["rate_rad_s"] / without["rate_rad_s"] - 1 == pytest.approx(80e-6, abs=1e-9)
    relative = with_clock["sd_parts"]["timebase_rad_s"] / with_clock["rate_rad_s"]
    years = (date.fromtimestamp(clip.stat().st_mtime) - date(2020, 1, 1)).days / 365.25
    assert 1e6 * relative == pytest.approx(np.hypot(4, 3 * years))
    assert with_clock["clock"] == {"camera": "c920", "fast_ppm": 80.0,
                                   "sd_ppm": pytest.approx(1e6 * relative)}
    assert without["clock"] is None


def test_a_camera_that_is_not_known_is_refused_with_those_that_are(home: Path) -> None:
    keep_camera(c920())
    config = home / "config.yaml"
    clip = Path("data/example/video/17rpm.mp4").resolve()
    config.write_text(CONFIG.format(clip=clip, timebase="camera: c290"), encoding="utf-8")
    with pytest.raises(ConfigError, match=r"config.yaml:2: .*'c290' is not known.*'c920'"):
        load_config(config)
    config.write_text(CONFIG.format(clip=clip, timebase="camera: c920, ppm: 5"), encoding="utf-8")
    with pytest.raises(ConfigError, match="not with `camera`"):
        load_config(config)


def test_pipeline_rate_takes_the_clock_of_a_camera(home: Path, typed: Typed) -> None:
    keep_camera(c920())
    clip = "data/example/video/17rpm.mp4"
    rates = [json.loads(typed("rate", clip, "--json", *options)[1])["17rpm"]["rate_rad_s"]
             for options in (("--clock", "c920"), ())]
    assert rates[0] / rates[1] - 1 == pytest.approx(80e-6, abs=1e-9)
    code, _, err = typed("rate", clip, "--clock", "other")
    assert code == 2
    assert "c920" in err


def test_clocks_are_listed_and_a_damaged_file_is_named(home: Path, typed: Typed) -> None:
    path = keep_camera(c920())
    keep_camera(CameraClock("phone", -3.0, 5.0, {}, date(2026, 1, 1), "a test"))
    code, out, _ = typed("clock")
    assert code == 0
    assert [line.split()[:3] for line in out.splitlines()[:2]] == [
        ["clock", "c920", "fast"], ["clock", "phone", "slow"]]
    path.write_text('{"cameras": {"c920": {"fast_ppm": "80"}}}', encoding="utf-8")
    code, _, err = typed("clock")
    assert code == 3
    assert str(path) in err


def test_a_timebase_of_a_camera_is_corrected(home: Path) -> None:
    keep_camera(c920())
    config = home / "config.yaml"
    clip = Path("data/example/video/17rpm.mp4").resolve()
    config.write_text(CONFIG.format(clip=clip, timebase="camera: c920"), encoding="utf-8")
    base = timebase_of(load_config(config).rate["slow"].timebase)  # type: ignore[union-attr]
    assert (base.fast_ppm, base.ppm, base.camera) == (80.0, 4.0, "c920")


def test_the_clock_of_a_camera_is_a_file_of_the_sessions_that_name_it(home: Path) -> None:
    clocks = keep_camera(c920())
    config = home / "config.yaml"
    clip = Path("data/example/video/17rpm.mp4").resolve()
    config.write_text(CONFIG.format(clip=clip, timebase="camera: c920"), encoding="utf-8")
    assert set(named_files(load_config(config))) == {clip, clocks}
    config.write_text(CONFIG.format(clip=clip, timebase="ppm: 5"), encoding="utf-8")
    assert set(named_files(load_config(config))) == {clip}
