"""The poses in the browser: rotated, picked, marked everywhere, left out."""

import base64
import re
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from calib.poses.attitudes import natural_directions
from pipeline.config.load import load_config
from pipeline.logs.read import read_log
from pipeline.report.page import report_html
from pipeline.report.triad.pose_sphere import coverage_of, sphere_json, up_directions
from pipeline.stages.context import RunContext
from pipeline.stages.run import run_stages
from tests.pipeline.report.browser import needs_browser
from tests.pipeline.report.conftest import HiddenSession
from tests.pipeline.report.tab import DESKTOP, PHONE, Browser, Tab
from tests.sessions import edit, quick_session

GYRO = "section[data-triad=gyroscope]"
STAGE = f"{GYRO} [data-stage]"
WHERE = f"return document.querySelector('{GYRO} .pose[data-i=\"7\"]').getAttribute('transform');"


def number(tab: Tab, name: str, triad: str = "gyroscope") -> float:
    path = f'section[data-triad={triad}] [data-out="{name}"]'
    return float(tab.evaluate(f"document.querySelector('{path}').dataset.value"))


def pick(tab: Tab, k: int, triad: str = "gyroscope") -> None:
    tab.evaluate(f"document.querySelectorAll('section[data-triad={triad}] tr[data-i] button')"
                 f"[{k}].click()")


@pytest.fixture
def tab(browser: Browser, hidden_session: HiddenSession) -> Iterator[Tab]:
    with browser.tab() as opened:
        opened.open(hidden_session.path)
        opened.unfold()
        yield opened
        assert opened.errors == []
        assert set(opened.requests) == {hidden_session.path.as_uri()}


# --- coverage ----------------------------------------------------------------------------------


def test_a_design_without_some_directions_names_them() -> None:
    natural = natural_directions(corners=False)
    expected, caption = coverage_of(np.repeat(natural[1:], 3, axis=0))
    assert len(expected) == 26
    assert "51 poses cover 17 of the 18" in caption
    assert "missing" in caption


def test_poses_by_hand_miss_no_direction() -> None:
    rng = np.random.default_rng(4)
    anywhere = rng.normal(size=(60, 3))
    again = np.repeat(natural_directions()[:12], [9, 5, 4, 7, 3, 1, 1, 3, 1, 2, 2, 1], axis=0)
    for vectors in (anywhere, again):
        expected, caption = coverage_of(vectors / np.linalg.norm(vectors, axis=1, keepdims=True))
        assert expected == []
        assert "no direction is marked as missing" in caption


def test_the_vertical_of_a_pose_is_the_same_at_rest_and_in_both_directions(
    hidden_session: HiddenSession
) -> None:
    result = hidden_session.outcome.triad("gyroscope")
    assert result is not None
    up, run = up_directions(result), np.array(result.calibration.fit.poses.run)
    assert np.linalg.norm(up, axis=1) == pytest.approx(1)
    first, *others = dict.fromkeys(run)
    natural = natural_directions(corners=False)
    laid = {name: set((natural @ up[run == name].T).argmax(axis=0)) for name in (first, *others)}
    assert all(laid[name] == laid[first] for name in others)


def test_the_stored_trace_holds_the_extremes_of_the_log(hidden_session: HiddenSession) -> None:
    outcome = hidden_session.outcome
    result = outcome.triad("accelerometer")
    assert result is not None
    shown = sphere_json(outcome, result)
    for k in (0, 11):
        label = result.calibration.fit.poses.label[k]
        log = read_log(outcome.config.source.path.parent / label)
        values = result.calibration.spec.nominal(log.accelerometer)
        about = (values - values.mean(axis=0)) * 1000  # mm/s²
        trace = shown["traces"][k]
        assert trace["low"] == pytest.approx(about.min(axis=0), rel=1e-3)
        assert trace["high"] == pytest.approx(about.max(axis=0), rel=1e-3)
        levels = np.frombuffer(base64.b64decode(trace["values"]), np.uint8).reshape(3, 2, -1)
        assert (levels[:, 0].min(axis=1) == 0).all()
        assert (levels[:, 1].max(axis=1) == 255).all()
        assert (levels[:, 0] <= levels[:, 1]).all()


def test_the_model_is_drawn_where_a_pose_without_its_residual_would_have_read(
    hidden_session: HiddenSession
) -> None:
    result = hidden_session.outcome.triad("accelerometer")
    assert result is not None
    poses = result.calibration.fit.poses
    trace = sphere_json(hidden_session.outcome, result)["traces"]
    residual = np.array([pose.residual for pose in result.comparison.poses])
    along = np.array([each["along"] for each in trace])
    at = poses.conditions(poses.reading - residual[:, None] * along)
    length = np.linalg.norm(result.calibration.correction.correct(at), axis=1)
    assert length == pytest.approx(poses.reference.magnitude, rel=1e-6)
    scatter = np.array([each["sd"] for each in trace])
    assert (scatter > 3 * poses.sd * 1000).all()  # of a sample, in mm/s², not of the mean


# --- the sphere --------------------------------------------------------------------------------


@needs_browser
def test_the_sphere_is_rotated_by_mouse_and_by_arrow_keys(tab: Tab) -> None:
    seen = [tab.evaluate(WHERE)]
    tab.drag(f"{STAGE} .globe", 90, 40)
    seen.append(tab.evaluate(WHERE))
    tab.evaluate(f"document.querySelector('{STAGE}').focus()")
    for key in ("ArrowLeft", "ArrowUp"):
        tab.key(key)
        seen.append(tab.evaluate(WHERE))
    assert len(set(seen)) == 4
    tab.key("ArrowDown")
    tab.key("ArrowRight")
    assert tab.evaluate(WHERE) == seen[1]


@needs_browser
def test_a_finger_rotates_the_sphere_and_picks_a_pose_on_a_phone(
    browser: Browser, hidden_session: HiddenSession
) -> None:
    with browser.tab() as tab:
        tab.open(hidden_session.path, PHONE)
        tab.unfold()
        before = tab.evaluate(WHERE)
        tab.drag(f"{STAGE} .globe", 70, 0, touch=True)
        assert tab.evaluate(WHERE) != before
        front = f"{STAGE} svg > g:last-of-type .pose:last-of-type"
        k = tab.evaluate(f"return document.querySelector('{front}').dataset.i;")
        tab.tap(f"{front} .reach")
        label = tab.evaluate(
            f"return document.querySelector('{GYRO} [data-pose=label]').textContent;")
        result = hidden_session.outcome.triad("gyroscope")
        assert result is not None
        assert label == result.calibration.fit.poses.label[int(k)]
        wide = tab.evaluate("return [document.documentElement.scrollWidth, window.innerWidth];")
        assert wide[0] <= wide[1]


@needs_browser
def test_enter_picks_the_pose_in_front_and_marks_it_in_every_chart_and_table(tab: Tab) -> None:
    tab.evaluate(f"document.querySelector('{STAGE}').focus()")
    tab.key("Enter")
    picked = tab.evaluate(
        f"const all = [...document.querySelectorAll('{GYRO} .picked')];"
        "return all.map((e) => [e.dataset.i, e.closest('svg, table').getAttribute('class')]);")
    assert len({k for k, _ in picked}) == 1
    (k,) = {k for k, _ in picked}
    shown = tab.evaluate(f"return document.querySelectorAll('{GYRO} [data-i=\"{k}\"]').length;")
    assert len(picked) == shown >= 6
    assert tab.evaluate(f"document.querySelectorAll('{GYRO} .trace path.range').length") == 3


@needs_browser
def test_a_touched_mark_of_a_chart_picks_its_pose(tab: Tab) -> None:
    is_picked = "document.querySelector('{} .pose[data-i=\"{}\"]').classList.contains('picked')"
    tab.click(f"{GYRO} svg.residuals g.mark[data-i='4']")
    assert tab.evaluate(is_picked.format(STAGE, 4))
    tab.evaluate(  # a finger beside the dot of the last pose, and one beside all
        f"const svg = document.querySelector('{GYRO} svg.residuals');"
        "const dot = [...svg.querySelectorAll('g.mark')].at(-1).getBoundingClientRect();"
        "for (const away of [15, 90]) svg.dispatchEvent(new MouseEvent('click', {bubbles: true,"
        " clientX: dot.x + away, clientY: dot.y}));")
    last = tab.evaluate(f"document.querySelectorAll('{STAGE} .pose').length") - 1
    assert tab.evaluate(is_picked.format(STAGE, last))
    assert tab.evaluate(
        f"const panel = document.querySelector('{GYRO} [data-pose-panel]').getBoundingClientRect();"
        "return panel.top >= 0 && panel.top < innerHeight;")


@needs_browser
def test_a_dot_that_is_clicked_opens_what_it_is_beside_the_chart(
    browser: Browser, hidden_session: HiddenSession
) -> None:
    with browser.tab() as tab:
        tab.open(hidden_session.path)
        for mark, place in (("svg.residuals g.mark[data-i='4']", ".outcome"),
                            (".axes .pose-dots path", ".axes")):
            tab.click(f"{GYRO} {mark}")
            assert tab.evaluate(
                f"const panel = document.querySelector('{GYRO} [data-pose-panel]');"
                f"return panel.closest('{place}') !== null && panel.checkVisibility()"
                " && panel.querySelectorAll('.trace path.range').length === 3;")


@needs_browser
def test_the_first_layer_is_short_and_a_command_is_copied(
    browser: Browser, hidden_session: HiddenSession
) -> None:
    with browser.tab() as tab:
        tab.open(hidden_session.path, DESKTOP)
        words, height = tab.evaluate(
            "return [document.body.innerText.split(/\\s+/).length,"
            " document.documentElement.scrollHeight];")
        assert words < 1500
        assert height < 5000
        tab.click(".copied button")
        tab.wait("document.querySelector('.copied button').textContent !== 'Copy'")
        assert tab.evaluate("document.querySelectorAll('main pre').length"
                            " === document.querySelectorAll('.copied').length")


# --- leaving out -------------------------------------------------------------------------------


@needs_browser
def test_a_pose_shows_what_a_fit_without_it_predicts_and_the_lines_that_leave_it_out(
    tab: Tab, hidden_session: HiddenSession
) -> None:
    result = hidden_session.outcome.triad("accelerometer")
    assert result is not None
    pick(tab, 2, "accelerometer")
    left_out = result.comparison.poses[2]
    root = "document.querySelector('section[data-triad=accelerometer]')"
    words = tab.evaluate(f"{root}.querySelector('[data-pose=without]').textContent")
    shown = re.search(r", (\S+) sd\.$", words)
    assert shown is not None
    assert float(shown[1].replace("−", "-")) == pytest.approx(
        left_out.left_out / left_out.sd, rel=0.005)
    before = number(tab, "rms", "accelerometer")
    tab.click("section[data-triad=accelerometer] [data-do=leaveOut]")
    assert tab.evaluate(f"{root}.querySelector('[data-out-command]').textContent").endswith(
        f"exclude {hidden_session.outcome.config.source.path} accelerometer.pose_03")
    assert number(tab, "rms", "accelerometer") == before  # a file refits nothing
    tab.click("section[data-triad=accelerometer] [data-do=takeBack]")
    assert tab.evaluate(f"{root}.querySelector('[data-out-note]').hidden")


# --- names -------------------------------------------------------------------------------------


@needs_browser
def test_no_name_in_a_configuration_or_a_log_becomes_a_script(
    browser: Browser, tmp_path: Path
) -> None:
    evil = "<img src=x onerror=window.hacked=1>"
    config, _ = quick_session(tmp_path)
    edit(config, "title: ", f"title: '{evil}' # ")
    for path in sorted((tmp_path / "accelerometer").glob("pose_*")):
        lines = path.read_text(encoding="utf-8").splitlines()
        lines = [f"{lines[0]},{evil}"] + [f"{line},{i % 7}" for i, line in enumerate(lines[1:])]
        path.write_text("\n".join(lines) + "\n", encoding="utf-8")
        path.rename(path.with_name(f"pose_{evil}{path.name}"))
    page = tmp_path / "report.html"
    page.write_text(report_html(run_stages(load_config(config), RunContext()), ()), "utf-8")
    assert "onerror" in page.read_text(encoding="utf-8")
    with browser.tab() as tab:
        tab.open(page)
        tab.unfold()
        for k in range(18):
            pick(tab, k, "accelerometer")
        tab.evaluate("document.querySelectorAll('details').forEach((e) => { e.open = true; })")
        tab.evaluate("document.querySelectorAll('input[data-effect]:enabled')"
                     ".forEach((each) => each.click())")
        tab.click("section[data-triad=accelerometer] [data-do=leaveOut]")
        label = tab.evaluate("return document.querySelector('section[data-triad=accelerometer] "
                             "[data-pose=label]').textContent;")
        assert evil in label
        assert tab.evaluate("return typeof window.hacked;") == "undefined"
        assert tab.evaluate("return document.querySelectorAll('img[src=x]').length;") == 0
        assert tab.errors == []
        assert tab.requests == [page.as_uri()]
