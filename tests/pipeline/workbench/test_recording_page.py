"""The live panel of a recording in the browser: a rehearsal is watched from beside."""

import os
import subprocess
import sys
import time
from collections.abc import Iterator
from itertools import islice

import cv2
import numpy as np
import pytest

from pipeline.config.template import session_folder
from tests.paths import ROOT
from tests.pipeline.report.browser import needs_browser
from tests.pipeline.report.tab import PHONE, Browser
from tests.pipeline.workbench.asked import Asked
from tests.pipeline.workbench.conftest import Opened
from vision.drawing import HAND
from vision.live_plate import LivePlate
from vision.video.reader import ClipReader

CLIP = session_folder() / "video/33rpm.mp4"
ENVIRONMENT = {**os.environ, "PYTHONPATH": str(ROOT), "PATH": "/nowhere"}


@pytest.fixture(scope="module")
def rehearsal(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Opened]:
    """A rehearsal that shows itself on a page."""
    folder = tmp_path_factory.mktemp("rehearsal")
    process = subprocess.Popen(
        [sys.executable, "-m", "pipeline", "record", "--demo", "--page"], cwd=folder,
        env=ENVIRONMENT, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
    assert process.stdout is not None
    try:
        address = next(line.strip() for line in iter(process.stdout.readline, "")
                       if line.startswith("http://"))
        yield Opened(folder, address, process, ())
    finally:
        process.kill()
        process.wait(240)
        process.stdout.close()


def test_the_page_of_a_recording_is_guarded(rehearsal: Opened) -> None:
    asked = Asked(rehearsal)
    assert asked.ask("/events")[0] == 403
    assert asked.ask("/", Host="evil.example", Cookie=asked.cookie)[0] == 403
    assert asked.ask("/events", Cookie=asked.cookie, Origin="http://evil.example")[0] == 403
    assert asked.ask("/picture")[0] == 403
    assert asked.ask("/", Cookie=asked.cookie)[0] == 200


@needs_browser
def test_the_panel_shows_the_attitude_to_lay_next_and_each_pose_taken(
    rehearsal: Opened, browser: Browser
) -> None:
    with browser.tab() as tab:
        tab.visit(rehearsal.address)
        lay = "document.querySelector('[data-lay]').textContent"
        first = tab.wait(f"/^lay next: (.+)/.exec({lay})?.[1]")
        assert tab.evaluate("document.querySelector('[data-drawing] svg')"
                            ".getAttribute('aria-label')") == first
        tab.wait(f"/^lay next: /.test({lay}) && {lay} !== 'lay next: {first}'")
        lines = tab.wait("/taken 1 of 18/.test(document.querySelector('[data-lines]').textContent)"
                         " && document.querySelector('[data-lines]').textContent")
        assert "taken 1 of 18" in lines
        assert tab.evaluate("document.querySelectorAll('[data-directions] .recorded').length") >= 1
        assert tab.evaluate("document.querySelectorAll('[data-traces] path.x').length") == 2
        tab.wait("document.querySelector('[data-picture]').naturalWidth === 480")
        words = tab.wait("/turns at ([0-9.]+) rpm/.exec("
                         "document.querySelector('[data-camera-words]').textContent)?.[1]")
        assert float(words) == pytest.approx(33.29, abs=0.05)  # of the clip that is played
        advice = "document.querySelector('[data-advice]').textContent"
        assert tab.wait(f"/accelerometer: worth most per minute is .* up, plate stopped"
                        f".*all sds fall by [0-9]+% in/.test({advice}) && true")
        tab.wait("document.querySelectorAll('[data-sds] svg').length === 2")
        tab.wait("document.querySelectorAll('[data-sds] circle').length >= 4")
        tab.wait("document.querySelector('[data-enough]').textContent"
                 ".includes('accelerometer: complete')")
        tab.send("Emulation.setDeviceMetricsOverride", **PHONE)
        tab.painted()
        tops = [tab.evaluate(f"document.querySelector('[data-{name}]').getBoundingClientRect().top")
                for name in ("lay", "message", "line", "drawing", "picture", "traces")]
        assert tops == sorted(tops)  # what to do and how it goes stand before the pictures
        assert tab.errors == []


def test_a_live_picture_follows_the_mark_between_two_measurements() -> None:
    """The hand stands on the mark of frames that were never measured."""
    plate = LivePlate()
    try:
        with ClipReader(CLIP, colours=True, full_size=True) as reader:
            frames = [*islice((frame for batch in reader for frame in batch), 170)]
        assert plate.picture() is None
        for frame in frames[:150]:
            plate.watch(frame.bgr, frame.time_s)
        end = time.monotonic() + 60
        while "rpm" not in plate.words and time.monotonic() < end:
            time.sleep(0.1)
        assert "33.29 rpm" in plate.words or "33.28 rpm" in plate.words
        for frame in frames[150:]:  # after the film that was measured
            plate.watch(frame.bgr, frame.time_s)
        drawn = plate.picture()
        assert drawn is not None
        image = cv2.imdecode(np.frombuffer(drawn, np.uint8), cv2.IMREAD_COLOR).astype(float)
        tip = np.abs(image - HAND).sum(axis=2) < 120  # the circle about the mark
        y, x = np.argwhere(tip).mean(axis=0)
        inside = frames[169].bgr[round(y) - 4:round(y) + 5, round(x) - 4:round(x) + 5]
        assert inside.mean() > 1.5 * np.median(frames[169].bgr)  # the mark is bright
    finally:
        plate.close()
