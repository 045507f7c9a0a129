"""A clip plays picture by picture beside the gyroscope, in the session and before there is one."""

import base64
import json
import shutil
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from calib.numbers import RPM
from pipeline.errors import PipelineError
from pipeline.workbench.clip_player import ClipPlayer, ClipToPlay
from pipeline.workbench.live_refits import OpenSession
from pipeline.workbench.session_files import session_clips
from tests.paths import DATA
from tests.pipeline.report.browser import needs_browser
from tests.pipeline.report.tab import Browser
from tests.pipeline.workbench.conftest import Opened, opened_workbench

HIDDEN = DATA / "hidden_effect"
CONFIG = """\
sensor:
  name: InvenSense MPU-6050
  gyroscope: {full_scale_deg_s: 250, bits: 16, encoding: twos-complement}
site: {latitude_deg: 40.85}
rate: {33rpm: {video: 33rpm.mkv, nominal_rpm: 33.333}}
gyroscope:
  runs: [{poses: 33rpm/pose_*.csv.gz, rate: 33rpm}]
  model: [bias, scale, misalignment]
"""


@pytest.fixture(scope="module")
def session(tmp_path_factory: pytest.TempPathFactory) -> OpenSession:
    """Eighteen poses on a plate of one speed with its clip; never run."""
    folder = tmp_path_factory.mktemp("filmed")
    shutil.copytree(HIDDEN / "gyroscope/33rpm", folder / "33rpm")
    shutil.copy(HIDDEN / "video/33rpm.mp4", folder / "33rpm.mkv")
    (folder / "config.yaml").write_text(CONFIG, encoding="utf-8")
    return OpenSession(folder / "config.yaml", folder / "cache", False)


@pytest.fixture(scope="module")
def clips(session: OpenSession) -> Sequence[ClipToPlay]:
    """Its clip, which is followed once for all tests."""
    return session_clips(session, session.config.source.path.parent)


def test_clip_and_gyroscope_stand_on_one_axis(
    session: OpenSession, clips: Sequence[ClipToPlay]
) -> None:
    folder = session.config.source.path.parent
    (clip,) = clips
    player = ClipPlayer(lambda: clips)
    course = player.course({"number": 0, "log": 3})
    assert clip.logs[3] == "33rpm/pose_04.csv.gz"
    assert len(course["pictures"]) == 900
    assert course["pictures"][-1] == pytest.approx(899 / 15, abs=0.01)
    assert course["so_far"]["rpm"][-1] == pytest.approx(course["rpm"], rel=1e-4)
    assert course["so_far"]["time_s"][0] > 60 / 34  # after the first turn
    beside = course["gyroscope"]
    assert beside["how"] == "by its data sheet"  # there are no results yet
    assert np.mean(beside["rpm"]) == pytest.approx(course["rpm"], rel=0.02)
    assert (beside["time_s"][0] < 0.1, beside["one_clock"]) == (True, False)
    clip.path.with_suffix(".times.csv").write_text(
        "frame,time_s,session_s\n0,0.0,2200.0\n", encoding="utf-8")
    shared = player.course({"number": 0, "log": 0})["gyroscope"]
    assert shared["one_clock"]
    assert 2200 + shared["time_s"][0] == pytest.approx(
        np.loadtxt(folder / "33rpm/pose_01.csv.gz", delimiter=",", skiprows=1)[0, 0], abs=0.1)


def test_what_is_no_clip_is_refused(clips: Sequence[ClipToPlay]) -> None:
    player = ClipPlayer(lambda: clips)
    for question in ({}, {"number": 1}, {"number": "0"}, {"number": -1},
                     {"number": 0, "log": 18}, {"number": 0, "log": "x"}):
        with pytest.raises(PipelineError, match="load the page again"):
            player.course(question)


def test_a_gap_in_the_log_and_a_clip_that_is_gone_are_no_failures(
    clips: Sequence[ClipToPlay]
) -> None:
    (clip,) = clips
    reading = clip.turning(0)
    gap = np.where(np.arange(len(reading.time_s)) < 40, np.nan, reading.rate_rad_s)
    holed = replace(clip, turning=lambda _: replace(reading, rate_rad_s=gap))
    beside = ClipPlayer(lambda: [holed]).course({"number": 0, "log": 0})["gyroscope"]
    assert np.isfinite(beside["rpm"]).all()
    gone = replace(clip, path=clip.path.with_name("gone.mp4"))
    with pytest.raises(PipelineError, match=r"gone\.mp4: cannot be read"):
        ClipPlayer(lambda: [gone]).course({"number": 0})


@pytest.fixture
def started(tmp_path: Path) -> Iterator[Opened]:
    (tmp_path / "lab").mkdir()
    with opened_workbench(tmp_path / "lab") as opened:
        yield opened


@needs_browser
def test_a_clip_that_is_dropped_plays_beside_the_logs_that_follow(
    started: Opened, browser: Browser
) -> None:
    words = "document.querySelector('[data-player-words]').textContent"
    with browser.tab() as tab:
        tab.visit(started.address)
        tab.wait("document.querySelector('[data-sessions-words]').textContent.includes('none yet')")
        for files in ([HIDDEN / "video/33rpm.mp4"], sorted((HIDDEN / "gyroscope/33rpm").iterdir())):
            dropped = {path.name: base64.b64encode(path.read_bytes()).decode() for path in files}
            tab.evaluate(f"""
                const data = new DataTransfer();
                for (const [name, text] of Object.entries({json.dumps(dropped)}))
                    data.items.add(new File(
                        [Uint8Array.from(atob(text), (each) => each.charCodeAt(0))], name));
                document.querySelector('[data-drop]').dispatchEvent(
                    new DragEvent('drop', {{dataTransfer: data, bubbles: true}})); return true;""")
            tab.wait(f"document.querySelector('[data-lines]').textContent.includes("
                     f"'{'18 tables' if len(files) > 1 else 'turns at +33.28'}') && true")
        tab.wait("document.querySelectorAll('.player').length === 1")
        tab.evaluate("document.querySelector('[data-player-show]').focus()")
        tab.key("Enter")
        tab.wait("!document.querySelector('[data-player-stage]').hidden")
        tab.evaluate("document.querySelector('[data-player-at]').focus()")
        for _ in range(3):
            tab.key("ArrowRight")
        assert tab.evaluate(words).startswith("0.20 s: no whole turn yet")
        assert tab.evaluate("document.querySelector('[data-player-at]').ariaValueText") == "0.20 s"
        tab.evaluate("document.querySelector('[data-player-play]').focus()")
        tab.key("Enter")
        shown = tab.wait(f"/([0-9.]+) rpm so far/.exec({words})?.[1]")
        assert float(shown) == pytest.approx(33.29, rel=1e-3)
        assert "Clip and log each count from their own beginning" in tab.evaluate(words)
        tab.wait("document.querySelector('[data-player-picture]').naturalWidth === 480")
        assert tab.errors == []


def test_a_rate_is_known_before_the_clip_ends(session: OpenSession) -> None:
    history = session.rates["33rpm"].clips[0].history
    angle = history.angle
    for k in (100, 500, len(angle.time_s) - 1):
        slope = np.polyfit(angle.repaired_time_s[:k + 1], angle.angle_rad[:k + 1], 1)[0]
        assert history.rate_so_far_rad_s[k] == pytest.approx(abs(slope), rel=1e-9)
    assert np.isnan(history.rate_so_far_rad_s[0])
    assert history.rate_so_far_rad_s[-1] / RPM == pytest.approx(33.2896, abs=1e-3)
