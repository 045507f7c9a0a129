"""The live panel of a recording in the browser: a rehearsal is watched from beside."""

import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.paths import ROOT
from tests.pipeline.report.browser import needs_browser
from tests.pipeline.report.tab import Browser
from tests.pipeline.workbench.asked import Asked
from tests.pipeline.workbench.conftest import Opened

ENVIRONMENT = {**os.environ, "PYTHONPATH": str(ROOT), "PATH": "/nowhere"}


@pytest.fixture
def rehearsal(tmp_path: Path) -> Iterator[Opened]:
    """A rehearsal that shows itself on a page."""
    process = subprocess.Popen(
        [sys.executable, "-m", "pipeline", "record", "--demo", "--page"], cwd=tmp_path,
        env=ENVIRONMENT, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
    assert process.stdout is not None
    try:
        address = next(line.strip() for line in iter(process.stdout.readline, "")
                       if line.startswith("http://"))
        yield Opened(tmp_path, address, process)
    finally:
        process.kill()
        process.wait(10)
        process.stdout.close()


def test_the_page_of_a_recording_is_guarded(rehearsal: Opened) -> None:
    asked = Asked(rehearsal)
    assert asked.ask("/events")[0] == 403
    assert asked.ask("/", Host="evil.example", Cookie=asked.cookie)[0] == 403
    assert asked.ask("/events", Cookie=asked.cookie, Origin="http://evil.example")[0] == 403
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
        assert tab.errors == []
