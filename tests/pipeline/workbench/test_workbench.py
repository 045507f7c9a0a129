"""The workbench as a person uses it, in a real browser, against the terminal's own runs."""

import json
import re
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest

from pipeline.config.load import load_config
from pipeline.text.formatting import DISPLAY
from pipeline.workbench.chart_columns import chart_columns
from pipeline.workbench.live_refits import OpenSession
from pipeline.workbench.state import Screen, TriadScreen, changed_lines
from tests.pipeline.report.browser import needs_browser
from tests.pipeline.report.tab import PHONE, Browser, Tab
from tests.pipeline.workbench.conftest import Opened, copied, opened_workbench
from tests.sessions import magnetometer_session, pipeline, results_in
from tests.world.magnetometer import Magnetometer

pytestmark = needs_browser

GYRO = "document.querySelector('#gyroscope')"
BOX = '#gyroscope input[data-effect="{}"]'
LEAVE_OUT = "#gyroscope [data-do=leaveOut]"
SHOWN = DISPLAY["gyroscope"][1]


def figure(name: str) -> str:
    return f"{GYRO}.querySelector('[data-out={name}]').dataset.value"


def tried(tab: Tab) -> list[str]:
    rows: list[str] = tab.evaluate(
        f"[...{GYRO}.querySelectorAll('.tried tbody tr')].map((row) => row.innerText)")
    return rows


@pytest.fixture
def config(written: Path, tmp_path: Path) -> Path:
    return copied(written, tmp_path)


@contextmanager
def page_of(opened: Opened, browser: Browser) -> Iterator[Tab]:
    with browser.tab() as tab:
        tab.visit(opened.address)
        tab.wait("document.querySelectorAll('#gyroscope [data-bench-scatter] circle').length > 0")
        yield tab
        assert tab.errors == []


@pytest.fixture
def tab(config: Path, browser: Browser) -> Iterator[Tab]:
    """A page whose session is the test's own: it may be written."""
    with opened_workbench(config) as own, page_of(own, browser) as tab:
        yield tab


@pytest.fixture
def reading(opened: Opened, browser: Browser) -> Iterator[Tab]:
    """A page of the session that nobody writes."""
    with page_of(opened, browser) as tab:
        yield tab


def test_the_whole_loop_in_one_window(tab: Tab, config: Path) -> None:
    """Found, ticked, the error falls, a pose out and back, undone, written, run: one number."""
    asked = tab.evaluate("location.href")
    assert "token" not in asked
    before = float(tab.evaluate(figure("loo")))
    tab.click(BOX.format("g_sensitivity"))
    tab.wait(f"Number({figure('loo')}) < {before / 5}")
    fallen = tab.evaluate(figure("loo"))
    assert "it is there; leave-one-out falls" in tab.evaluate(
        f"{GYRO}.querySelector('[data-out=judgement]').textContent")

    tab.click("#gyroscope svg.residuals g.mark[data-i='4']")
    tab.click(LEAVE_OUT)
    tab.wait(f"{figure('loo')} !== '{fallen}'")
    without = tab.evaluate(figure("loo"))
    tab.click(LEAVE_OUT)  # and back
    tab.wait(f"{figure('loo')} === '{fallen}'")
    tab.click("[data-bench-do=undo]")
    tab.wait(f"{figure('loo')} === '{without}'")
    assert len(tried(tab)) == 3

    tab.click("[data-bench-do=write]")
    words = tab.wait("/was changed/.test(document.querySelector('[data-bench-status]')"
                     ".textContent) && document.querySelector('[data-bench-lines]').textContent")
    assert "exclude: [pose_05]" in words
    assert "misalignment, g_sensitivity]" in words
    assert "# the reference of the gyroscopes" in config.read_text(encoding="utf-8")
    tab.wait(f"Number({figure('loo')}) === {without}")
    tab.evaluate("window.before = true")
    assert pipeline("run", config) == 0
    tab.wait("window.before === undefined && document.readyState === 'complete'")
    found = results_in(config.with_suffix(".run"))["gyroscope"]
    assert found["loo_rms"] * SHOWN == float(without)  # to the last digit
    tab.wait(f"{figure('loo')} === '{without}'")  # a run in a terminal updates the page
    assert tab.evaluate(f"document.querySelector('{BOX.format('g_sensitivity')}').checked")
    history = (config.with_suffix(".run") / "history.jsonl").read_text("utf-8").splitlines()
    assert len(history) == 3  # run, written, run: opening is none, and writing is one step

    # What was tried stays; a model with the pose is out of reach until that is taken back.
    tab.wait("document.querySelector('.tried tr.now') && true")
    assert len(tried(tab)) == 3
    show = f"[...{GYRO}.querySelectorAll('.tried button')].map((b) => b.disabled)"
    assert tab.wait(show) == [True, True, False]
    can_write = "!document.querySelector('[data-bench-do=write]').disabled"
    for _ in range(2):  # nothing is written before "Write to config", and it can be undone
        tab.click("#gyroscope [data-bench-excluded] button")
        tab.wait(can_write)
        tab.click("[data-bench-do=undo]")
        tab.wait(f"!({can_write})")
    assert "exclude: [pose_05]" in config.read_text(encoding="utf-8")
    tab.click("[data-bench-do=redo]")
    tab.click("[data-bench-do=write]")
    tab.wait("/was changed/.test(document.querySelector('[data-bench-status]').textContent)"
             f" && {figure('loo')} === '{fallen}'")
    assert "exclude: []" in config.read_text(encoding="utf-8")
    assert tab.wait(show) == [False, False, False]


def test_a_write_is_undone_step_by_step_and_the_file_changes_only_by_the_next_write(
    tab: Tab, config: Path
) -> None:
    before = config.read_text(encoding="utf-8")
    box, bar = f"document.querySelector('{BOX.format('g_sensitivity')}').checked", {
        name: f"document.querySelector('[data-bench-do={name}]').disabled"
        for name in ("undo", "redo", "write")}
    status = "document.querySelector('[data-bench-status]').textContent"
    rows = f"{GYRO}.querySelectorAll('.tried tbody tr').length"
    tab.click(BOX.format("g_sensitivity"))
    tab.wait(f"{rows} === 2")
    tab.click("#gyroscope svg.residuals g.mark[data-i='4']")
    tab.click(LEAVE_OUT)
    tab.wait(f"{rows} === 3")
    for step in ("write", "undo", "undo"):
        tab.wait(f"!{bar[step]}")
        tab.click(f"[data-bench-do={step}]")
        tab.wait(f"/was changed/.test({status})" if step == "write" else f"/Undone/.test({status})")
    assert 'until "Write to config"' in tab.evaluate(status)
    assert tab.evaluate(f"[{box}, {bar['undo']}, {bar['redo']}, {bar['write']}]") == [
        False, True, False, False]
    written = config.read_text(encoding="utf-8")
    assert "g_sensitivity" in written
    assert "exclude: [pose_05]" in written  # undo changes the screen
    tab.click("[data-bench-do=write]")
    tab.wait(f"/was changed/.test({status})")
    assert config.read_text(encoding="utf-8").replace(", exclude: []", "") == before
    tab.wait(f"!{bar['redo']} && true")  # leads forth again, beyond the write


def test_the_step_of_a_card_and_the_run_of_an_edited_file_need_no_terminal(
    tab: Tab, config: Path
) -> None:
    tab.click(".answer pre + button")
    tab.wait(f"document.querySelector('{BOX.format('g_sensitivity')}').checked")
    run = "document.querySelector('[data-bench-do=run]')"
    assert tab.evaluate(f"{run}.hidden")
    text = config.read_text(encoding="utf-8")
    config.write_text(text.replace("misalignment]", "misalignment, quadratic]"), "utf-8")
    tab.wait(f"!{run}.hidden")
    tab.evaluate("window.before = true")
    tab.click("[data-bench-do=run]")
    tab.wait("window.before === undefined && document.readyState === 'complete'")
    tab.wait(f"document.querySelector('{BOX.format('quadratic')}').checked")
    assert "quadratic" in results_in(config.with_suffix(".run"))["gyroscope"]["model"]


def test_models_tried_are_kept_compared_and_returned_to(reading: Tab) -> None:
    tab = reading
    tab.unfold()
    before = tab.evaluate(figure("rms"))
    for name in ("g_sensitivity", "bias_drift", "quadratic"):  # more than a file holds
        tab.click(BOX.format(name))
        tab.wait(f"{GYRO}.querySelector('.tried tr.now')?.innerText.includes('{name}')")
    assert "g_sensitivity + bias_drift + quadratic" in tried(tab)[3]
    words = tab.evaluate(f"{GYRO}.querySelector('[data-bench-gain-words]').textContent")
    match = re.match(r"(\d+) of 36 poses are predicted better", words)
    assert match is not None
    assert int(match[1]) > 26
    tab.evaluate(f"{GYRO}.querySelector('.tried tbody button').focus()")
    tab.key("Enter")
    tab.wait(f"{figure('rms')} === '{before}'")
    assert not tab.evaluate(f"document.querySelector('{BOX.format('quadratic')}').checked")


def test_axes_are_chosen_and_a_dot_picks_its_pose(reading: Tab) -> None:
    tab = reading
    tab.evaluate(
        f"const select = {GYRO}.querySelector('[data-bench-x]'); select.value = 'temperature_c';"
        "select.dispatchEvent(new Event('change', {bubbles: true})); return true;")
    words = f"{GYRO}.querySelector('[data-bench-scatter] svg').getAttribute('aria-label')"
    assert "against temperature_c" in tab.evaluate(words)
    tab.click("#gyroscope [data-bench-scatter] circle[data-i='7']")
    assert tab.evaluate(f"{GYRO}.querySelector('[data-pose=label]').textContent").endswith(
        "pose_08.csv")
    inside = tab.evaluate(f"{GYRO}.querySelectorAll('[data-bench-normal] circle').length")
    assert inside == 18  # the poses that turn


def test_an_expression_is_tried_while_it_is_typed_and_errors_point_at_the_character(
    tab: Tab, config: Path
) -> None:
    def type_in(text: str) -> None:
        tab.evaluate(
            f"const input = {GYRO}.querySelector('[data-bench-expression]');"
            f"input.value = {json.dumps(text)};"
            "input.dispatchEvent(new Event('input', {bubbles: true})); return true;")

    words = f"{GYRO}.querySelector('[data-bench-expression-words]').textContent"
    type_in("f * 1")
    before, after = map(float, tab.wait(
        f"/chi² (\\S+) → (\\S+);/.exec({words})?.slice(1)"))
    assert after < 0.7 * before  # along the own axis: part of the g-sensitivity
    assert tab.evaluate(f"{GYRO}.querySelectorAll('[data-bench-fingerprint] circle').length") == 36
    assert 'expression: "f * 1", per: axis' in tab.evaluate(
        f"{GYRO}.querySelector('[data-bench-expression-lines]').textContent")
    tab.click("#gyroscope [data-bench-own] button")
    tab.wait("/was changed/.test(document.querySelector('[data-bench-status]').textContent)")
    assert "misalignment, own_effect]" in config.read_text(encoding="utf-8")
    assert results_in(config.with_suffix(".run"))["gyroscope"]["chi2"] == pytest.approx(
        after, rel=5e-3)  # three digits are shown
    type_in("f + temperatur_c")
    assert "did you mean 'temperature_c'" in tab.wait(
        f"/At character 5: f \\+ ▸temperatur_c/.test({words}) && {words}")


def test_it_works_at_the_width_of_a_phone_and_says_its_verdict_aloud(reading: Tab) -> None:
    tab = reading
    tab.send("Emulation.setDeviceMetricsOverride", **PHONE)
    tab.painted()
    needed, there = tab.evaluate(
        "return [document.documentElement.scrollWidth, window.innerWidth];")
    assert needed <= there
    for selector in ("[data-out=judgement]", "[data-bench-status]"):
        assert tab.evaluate(f"return document.querySelector('{selector}').matches("
                            "'[role=status], [aria-live]');")


@pytest.mark.usefixtures("bare_page")
def test_the_figures_on_the_screen_are_those_of_a_run_with_the_same_effects(
    config: Path
) -> None:
    session = OpenSession(config, config.with_suffix(".run") / "cache", False)
    labels = [*session.sections["gyroscope"]]
    out = (labels[2], labels[7], labels[35])  # the last one rests: of the accelerometer too
    state = Screen({"accelerometer": TriadScreen(("temperature_bias",)),
                   "gyroscope": TriadScreen(("g_sensitivity", "scale_drift"), out)}, {})
    shown = session.answer(state, "gyroscope", ())
    text = session.source(state).text
    changed = [change["after"].strip() for change in changed_lines(
        load_config(config).source.text, text)]
    assert changed[0] == "model: [bias, scale, misalignment, temperature_bias]"
    assert "33rpm, exclude: [pose_03, pose_08]}" in changed[1]
    assert "stopped, exclude: [pose_18]}" in changed[1]
    assert len(changed) == 2
    config.write_text(text, encoding="utf-8")
    assert pipeline("run", config) == 0
    found = results_in(config.with_suffix(".run"))["gyroscope"]
    assert (shown["chi2"], shown["dof"]) == (found["chi2"], found["dof"])
    assert shown["loo"] == found["loo_rms"] * SHOWN
    assert len(shown["residual"]) == 36  # those left out are predicted
    json.dumps(shown, allow_nan=False)


def test_a_third_triad_is_ticked_and_without_its_poses(tmp_path: Path) -> None:
    config = magnetometer_session(
        tmp_path, 4, Magnetometer(per_kelvin=np.array([0.12, -0.08, 0.10])))
    session = OpenSession(config, config.with_suffix(".run") / "cache", False)
    base = {triad: TriadScreen(()) for triad in session.sections}
    ticked = TriadScreen(("temperature_bias",), ("accelerometer/pose_02.csv",))
    before, after = (session.answer(Screen(base | {"magnetometer": each}, {}), "magnetometer", ())
                     for each in (TriadScreen(()), ticked))
    assert after["loo"] < 0.5 * before["loo"]
    assert len(after["residual"]) == 18
    assert {"specific force x [m/s²]"} <= chart_columns(session, "magnetometer")["columns"].keys()
