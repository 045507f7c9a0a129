"""Excluded poses in the report: hollow marks, named, and the command that excludes more."""

import re
import shutil
from pathlib import Path

import pytest

from pipeline.config.load import load_config
from pipeline.report.page import report_html
from pipeline.stages.context import RunContext
from pipeline.stages.run import run_stages
from tests.pipeline.conftest import RunSession
from tests.pipeline.report.browser import needs_browser
from tests.pipeline.report.html_page import Page, carried
from tests.pipeline.report.tab import Browser
from tests.sessions import edit

OUT = "../accelerometer/pose_03.csv"
SHOWN = "pose_03.csv"  # of a file beside the folder of the session
POSES = "accelerometer/pose_*.csv\n"


@pytest.fixture(scope="module")
def page(finished: RunSession, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The report of a session that excludes one pose of the accelerometer."""
    folder = tmp_path_factory.mktemp("excluded")
    shutil.copytree(finished.config.parent, folder, dirs_exist_ok=True)
    config = folder / "session" / finished.config.name
    config.parent.mkdir()
    text = (folder / finished.config.name).read_text("utf-8")
    config.write_text(re.sub(r"\b(accelerometer|gyroscope|video)/", r"../\1/", text), "utf-8")
    edit(config, POSES, f"{POSES}  exclude: [pose_03]\n")
    path = config.with_name("page.html")
    path.write_text(report_html(run_stages(load_config(config), RunContext()), ()), "utf-8")
    return path


def test_an_excluded_pose_is_hollow_in_the_charts_and_named_in_the_table(page: Path) -> None:
    source = page.read_text(encoding="utf-8")
    titles = re.findall(r'<g class="excluded"[^>]*>.*?<title>(.*?)</title>', source, re.DOTALL)
    assert len(titles) == 1
    assert titles[0].startswith(f"{SHOWN}: excluded; ")
    assert f"Excluded by the configuration: {SHOWN}." in Page(source).text
    assert not re.search(r"<title>[^<]*\.\./", source)
    poses = next(t for t in carried(source)["triads"] if t["triad"] == "accelerometer")
    assert OUT not in poses["labels"]
    (hollow,) = poses["poses"]["excluded"]
    assert (hollow["label"], hollow["shown"]) == (OUT, SHOWN)
    assert all("/" not in name for name in poses["shown"])
    assert len(hollow["up"]) == 3


@needs_browser
def test_leaving_poses_out_offers_the_command(
    browser: Browser, page: Path
) -> None:
    with browser.tab() as tab:
        tab.open(page)
        section = "document.querySelector('#accelerometer')"
        assert tab.evaluate(f"{section}.querySelectorAll('.ball .excluded').length") == 1
        tab.evaluate(f"{section}.querySelector('tr[data-i=\"6\"] button').click()")
        tab.evaluate(f"{section}.querySelector('[data-do=leaveOut]').click()")
        offered = tab.evaluate(f"{section}.querySelector('[data-out-command]').textContent")
        assert offered == f"pipeline exclude {page.parent / 'config.yaml'} accelerometer.pose_08"
        assert tab.errors == []
