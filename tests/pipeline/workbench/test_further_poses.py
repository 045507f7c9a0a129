"""Further poses are dropped on the page of an open session, looked at, and written with it."""

import json
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.pipeline.report.browser import needs_browser
from tests.pipeline.report.tab import PHONE, Browser, Tab
from tests.pipeline.workbench.asked import Asked
from tests.pipeline.workbench.conftest import Opened, copied, opened_workbench
from tests.sessions import results_in

STATUS = "document.querySelector('[data-bench-status]').textContent"
WRITE = "document.querySelector('[data-bench-do=write]').disabled"


@pytest.fixture
def later(written: Path, tmp_path: Path) -> Iterator[tuple[Opened, dict[str, str]]]:
    """An open session that lacks a pose at rest and one on the plate, and their logs."""
    config = copied(written, tmp_path)
    texts = {}
    for place in ("accelerometer/pose_03.csv", "gyroscope/33rpm/pose_07.csv"):
        path = tmp_path / place
        texts[path.name] = path.read_text(encoding="utf-8")
        path.unlink()
    with opened_workbench(config) as opened:
        yield opened, texts


def dropped(tab: Tab, texts: dict[str, str]) -> None:
    tab.evaluate(f"""
        const data = new DataTransfer();
        for (const [name, text] of Object.entries({json.dumps(texts)}))
            data.items.add(new File([text], name));
        document.querySelector('[data-further-drop]').dispatchEvent(
            new DragEvent('drop', {{dataTransfer: data, bubbles: true}})); return true;""")


@needs_browser
def test_new_poses_are_shown_fitted_and_kept_by_the_write_alone(
    later: tuple[Opened, dict[str, str]], browser: Browser
) -> None:
    opened, texts = later
    config, before = opened.config, opened.config.read_text(encoding="utf-8")
    with browser.tab() as tab:
        tab.visit(opened.address)
        tab.wait("document.querySelectorAll('#gyroscope [data-bench-scatter] circle').length > 0")
        assert tab.evaluate(WRITE)
        tab.click("[data-bench-do=further]")
        dropped(tab, texts | {"notes.docx": "x"})
        tab.wait(f"!{WRITE}")
        rows = tab.evaluate("[...document.querySelectorAll('[data-further-rows] tr')]"
                            ".map((row) => row.innerText)")
        assert [row.split("\t")[0] for row in rows] == list(texts)
        assert "stopped" in rows[0]
        assert "33rpm" in rows[1]
        assert "°/s" in rows[1]
        words = tab.evaluate("document.querySelector('[data-further-words]').textContent")
        assert words.startswith("notes.docx: is neither a log nor a clip")
        figures = tab.evaluate("document.querySelector('[data-further-figures]').textContent")
        assert "gyroscope, 34 → 36 poses" in figures
        assert "next: pipeline" in figures
        assert config.read_text(encoding="utf-8") == before
        tab.send("Emulation.setDeviceMetricsOverride", **PHONE)
        tab.painted()
        assert tab.evaluate("document.documentElement.scrollWidth <= window.innerWidth")
        tab.click("[data-bench-do=write]")
        tab.wait(f"/was changed/.test({STATUS})")
        assert tab.errors == []
    now = config.read_text(encoding="utf-8")
    assert now.count("further_1/pose_03.csv") == 2  # at rest it serves both triads
    assert "further_1/pose_07.csv], rate: 33rpm" in now
    assert (config.parent / "further_1/pose_03.csv").read_text("utf-8") == texts["pose_03.csv"]
    results = results_in(config.with_suffix(".run"))
    assert [results[triad]["n_poses"] for triad in ("accelerometer", "gyroscope")] == [18, 36]
    assert not [*config.parent.glob(".brought-*/*")]


def test_logs_that_the_session_refuses_leave_all_as_it_was(
    later: tuple[Opened, dict[str, str]]
) -> None:
    opened, texts = later
    asked, before = Asked(opened), opened.config.read_text(encoding="utf-8")
    state = {"triads": {triad: {"ticked": [], "out": []}
                        for triad in ("accelerometer", "gyroscope")}, "terms": {}}
    question = {"state": state, "left_out": []}
    assert asked.post("/further", question)[0] == 422  # nothing is there yet
    head, *rows = texts["pose_03.csv"].splitlines()
    halved = "\n".join(",".join([cells[0], *(f"{float(cell) / 2:.0f}" for cell in cells[1:])])
                       for cells in (row.split(",") for row in rows))
    assert asked.ask("/bring/half.csv", "POST", f"{head}\n{halved}\n".encode(),
                     Cookie=asked.cookie, Origin=f"http://{asked.host}")[0] == 200
    written = {"state": state, "further": []}
    assert asked.post("/write", written)[0] == 422
    assert opened.config.read_text(encoding="utf-8") == before
    assert not (opened.config.parent / "further_1").exists()
    assert asked.post("/forget", {})[0] == 200
    assert asked.post("/further", question)[0] == 422
