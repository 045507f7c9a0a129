"""A second session is predicted and never fitted: on the screen as on the console."""

import json
from pathlib import Path

import pytest

from pipeline.errors import PipelineError
from pipeline.results.read import load_results
from pipeline.text.formatting import DISPLAY
from pipeline.workbench.held_out import HeldOut
from pipeline.workbench.live_refits import OpenSession
from pipeline.workbench.state import Screen, TriadScreen
from tests.pipeline.report.browser import needs_browser
from tests.pipeline.report.tab import Browser
from tests.pipeline.workbench.conftest import copied, opened_workbench, written_session
from tests.sessions import pipeline, results_in

SHOWN = DISPLAY["gyroscope"][1]
WORDS = "document.querySelector('#gyroscope [data-bench-held-words]').textContent"


@pytest.fixture(scope="module")
def evenings(written: Path, tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    """Two evenings of one sensor, the second one run."""
    folder = tmp_path_factory.mktemp("evenings")
    monday = copied(written, folder / "monday")
    tuesday = written_session(folder / "tuesday", 4)
    assert pipeline("run", tuesday) == 0
    return monday, tuesday


@pytest.mark.usefixtures("bare_page")
def test_the_held_out_error_is_that_of_compare_before_and_after_the_tick(
    evenings: tuple[Path, Path], capsys: pytest.CaptureFixture[str]
) -> None:
    monday, tuesday = evenings
    session = OpenSession(monday, monday.parent / "cache", False)
    session.held_out = HeldOut.of(load_results(tuesday.with_suffix(".run")))
    shown, printed = [], []
    for model in ((), ("g_sensitivity",)):
        state = Screen({"accelerometer": TriadScreen(()), "gyroscope": TriadScreen(model)}, {})
        shown.append(session.answer(state, "gyroscope", ())["held_out"])
        monday.write_text(session.source(state).text, encoding="utf-8")
        assert pipeline("run", monday) == 0
        capsys.readouterr()
        assert pipeline("compare", monday, tuesday, "--json") == 0
        compared = json.loads(capsys.readouterr().out)
        printed.append(compared["gyroscope"]["error_on_poses"][1][0] * SHOWN)
    assert [each["rms"] for each in shown] == pytest.approx(printed, rel=1e-12)
    assert shown[1]["rms"] < shown[0]["rms"] / 1.5  # it falls on poses that no fit has seen
    assert len(shown[0]["labels"]) == 18  # those that turn
    own = results_in(monday.with_suffix(".run"))["gyroscope"]["loo_rms"] * SHOWN
    by_tuesday = compared["gyroscope"]["error_on_poses"][1][1] * SHOWN
    assert shown[1]["own_rms"] == pytest.approx(by_tuesday)
    assert shown[1]["rms"] < 2 * own  # two cameras' clocks differ, which is no noise of a pose


def test_what_is_no_session_of_the_sensor_is_said(evenings: tuple[Path, Path]) -> None:
    results = evenings[1].with_suffix(".run") / "results.json"
    contents = json.loads(results.read_text(encoding="utf-8"))
    of_file = OpenSession(evenings[1], evenings[1].parent / "cache", False).refitted(
        Screen({"accelerometer": TriadScreen(()), "gyroscope": TriadScreen(())}, {}),
        "gyroscope").calibration
    contents["gyroscope"] = None
    alone = HeldOut.of_bytes(json.dumps(contents).encode())
    assert "has no gyroscope" in alone.predicted(
        "gyroscope", of_file.correction, of_file)["problem"]
    itself = HeldOut.of_bytes(results.read_bytes()).predicted(
        "gyroscope", of_file.correction, of_file)
    assert "the very measurements of this session" in itself["problem"]
    for wrong in (b"", b"{", b"[1]", b"\xff\xfe", b'{"format": 1}', b"[" * 100_000):
        with pytest.raises(PipelineError, match="the file"):
            HeldOut.of_bytes(wrong)


@needs_browser
def test_a_session_named_or_dropped_stands_beside_every_tick(
    evenings: tuple[Path, Path], browser: Browser, written: Path, tmp_path: Path
) -> None:
    config = copied(written, tmp_path)
    results = evenings[1].with_suffix(".run") / "results.json"
    assert results_in(results.parent)["gyroscope"]["n_poses"] == 36
    with opened_workbench(config, "--held-out", str(evenings[1])) as opened, browser.tab() as tab:
        tab.visit(opened.address)
        before = float(tab.wait(f"/model of the file by (\\S+)/.exec({WORDS})?.[1]"))
        tab.click("#gyroscope input[data-effect=g_sensitivity]")
        tab.wait(f"Number(/errs by (\\S+)/.exec({WORDS})?.[1]) < {before / 1.5}")
        marks = tab.evaluate("document.querySelectorAll('#gyroscope .held').length")
        assert marks == 18
        tab.evaluate("""
            const file = new File(['{"format": 7}'], 'other.json');
            const data = new DataTransfer(); data.items.add(file);
            document.querySelector('#gyroscope [data-bench-drop]').dispatchEvent(
                new DragEvent('drop', {dataTransfer: data, bubbles: true})); return true;""")
        tab.wait(f"/format 7 found/.test({WORDS})")
        assert tab.evaluate("document.querySelectorAll('#gyroscope .held').length") == 0
        assert tab.errors == []
