"""A pose on the page shows the frame of its clip."""

import base64
import shutil
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest

from pipeline.config.load import load_config
from pipeline.report.page import report_html
from pipeline.report.triad.pose_sphere import pose_frames
from pipeline.stages.context import RunContext
from pipeline.stages.run import Outcome, run_stages
from tests.paths import DATA
from tests.pipeline.report.browser import needs_browser
from tests.pipeline.report.tab import Browser

GYRO = "section[data-triad=gyroscope]"


@pytest.fixture(scope="module")
def outcome(tmp_path_factory: pytest.TempPathFactory) -> Outcome:
    """The example session, whose one clip is of the whole run."""
    folder = tmp_path_factory.mktemp("filmed") / "example"
    shutil.copytree(DATA / "example", folder, ignore=shutil.ignore_patterns("*.run"))
    return run_stages(load_config(folder / "config.yaml"), RunContext())


@needs_browser
def test_a_dot_that_is_clicked_shows_the_plate_as_it_was_filmed(
    outcome: Outcome, browser: Browser, tmp_path: Path
) -> None:
    page = tmp_path / "report.html"
    page.write_text(report_html(outcome, ()), encoding="utf-8")
    with browser.tab() as tab:
        tab.open(page)
        tab.unfold()
        tab.click(f"{GYRO} svg.residuals g.mark[data-i='4']")
        shown = tab.evaluate(
            f"const figure = document.querySelector('{GYRO} [data-pose=frame]');"
            "return [figure.checkVisibility(), figure.querySelector('img').naturalWidth,"
            " figure.innerText];")
        assert shown[0]
        assert shown[1] > 100
        assert "clip of 17rpm" in shown[2]
        tab.click("section[data-triad=accelerometer] svg.residuals g.mark[data-i='4']")
        assert tab.evaluate(
            "document.querySelector('section[data-triad=accelerometer] [data-pose=frame]').hidden")


def test_a_clip_of_a_pose_is_that_pose_s_small_picture(outcome: Outcome) -> None:
    result = outcome.triad("gyroscope")
    assert result is not None
    (rate,) = outcome.rates.values()
    n = len(result.calibration.fit.poses)
    shades = [cv2.imencode(".png", np.full((300, 400, 3), 10 * i, np.uint8))[1] for i in range(n)]
    filmed = replace(rate, annotated=tuple(shades), sources=tuple(f"clip{i}.mp4" for i in range(n)))
    frames = pose_frames(replace(outcome, rates={rate.name: filmed}), result)
    assert len(frames) == n
    for i, frame in enumerate(frames):
        assert frame is not None
        assert frame["clip"] == f"clip{i}.mp4"
        jpeg = base64.b64decode(frame["src"].split(",")[1])
        picture = cv2.imdecode(np.frombuffer(jpeg, np.uint8), cv2.IMREAD_COLOR)
        assert picture is not None
        assert picture.shape == (180, 240, 3)
        assert picture.mean() == pytest.approx(10 * i, abs=3)
