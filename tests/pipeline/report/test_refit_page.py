"""The tick boxes as a person uses them: what moves, what stays, what it says, on every screen."""

import re
import shutil
from collections.abc import Iterator
from pathlib import Path

import pytest

from pipeline.config.load import load_config
from pipeline.report.page import report_html
from pipeline.stages.context import RunContext
from pipeline.stages.run import run_stages
from tests.paths import DATA
from tests.pipeline.report.browser import needs_browser
from tests.pipeline.report.conftest import HiddenSession
from tests.pipeline.report.tab import PHONE, Browser, Tab

pytestmark = needs_browser

GYRO = "#gyroscope "
BOX = GYRO + 'input[data-effect="{}"]'
MOST_PAGES = 9  #: of a printed session with two triads
SMALLEST_TEXT = 12  #: px

STATE = """
const root = document.querySelector("#gyroscope"), plot = root.querySelector(".of-poses svg");
const at = (node) => Number(/, ?(.*)px/.exec(node.style.transform)[1]);
const tile = (name) => { const each = root.querySelector(`[data-tile="${name}"]`);
  return { value: Number(each.querySelector("output").dataset.value), kind: each.className,
    text: each.innerText, bar: parseFloat(each.querySelector("i").style.width) }; };
return {
  axis: [...plot.querySelectorAll("[data-fraction]")].map((each) => each.textContent),
  marks: [...plot.querySelectorAll("g.mark")].map(at),
  ghosts: [...plot.querySelectorAll("g.ghost")].map(at),
  ghosts_seen: getComputedStyle(plot.querySelector(".ghosts")).visibility === "visible",
  rms: tile("rms"), loo: tile("loo"), chi2: tile("chi2"),
  judgements: [...root.querySelectorAll('[data-out="judgement"] p')].map((p) => p.textContent),
  commands: root.querySelector('[data-out="commands"]').textContent,
  offered: root.querySelector('[data-out="commanded"]').checkVisibility(),
  fall: [...root.querySelectorAll(".fall-row")].map((row) => [row.children[0].textContent,
    Number(row.children[2].textContent.replace("−", "-"))]),
};
"""


@pytest.fixture
def tab(browser: Browser, hidden_session: HiddenSession) -> Iterator[Tab]:
    with browser.tab() as tab:
        tab.open(hidden_session.path)
        yield tab


def test_the_error_falls_on_a_fixed_axis_and_a_ghost_of_before_stays(tab: Tab) -> None:
    before = tab.evaluate(STATE)
    assert not before["ghosts_seen"]
    tab.click(BOX.format("g_sensitivity"))
    after = tab.evaluate(STATE)
    assert after["axis"] == before["axis"]
    assert after["ghosts_seen"]
    assert after["ghosts"] == pytest.approx(before["marks"])
    moved = sum(abs(a - b) > 1 for a, b in zip(before["marks"], after["marks"], strict=True))
    assert moved > 0.8 * len(before["marks"])
    assert "better" in after["rms"]["kind"]
    assert after["rms"]["bar"] < 0.5 * before["rms"]["bar"]
    assert after["commands"].endswith("gyroscope.g_sensitivity")
    assert after["offered"]


def idle_effect(tab: Tab) -> str:
    """An effect beside the ticked one with a refit in the file, with which the error rises."""
    return str(tab.evaluate(
        "return JSON.parse(document.getElementById('refit-data').textContent).triads"
        ".find((each) => each.triad === 'gyroscope').refits"
        ".map((each) => each.judgements).find((each) => each?.length === 2"
        " && each.some((one) => one.text.startsWith('g_sens'))"
        " && each.some((one) => /: not there.* rises by/.test(one.text)))"
        ".map((one) => one.text.split(':')[0]).find((name) => name !== 'g_sensitivity')"))


def test_a_tick_that_does_not_help_says_so_in_red_and_offers_no_command(tab: Tab) -> None:
    tab.click(BOX.format("g_sensitivity"))
    good = tab.evaluate(STATE)
    name = idle_effect(tab)
    tab.click(BOX.format(name))
    worse = tab.evaluate(STATE)
    assert worse["loo"]["value"] > good["loo"]["value"]
    (_, judgement) = worse["judgements"]
    assert re.fullmatch(rf"{name}: \d\.\d sd: not there; leave-one-out rises by .* %\.",
                        judgement)
    assert name not in worse["commands"]
    tab.click(BOX.format("g_sensitivity"))
    alone = tab.evaluate(STATE)
    assert alone["commands"] == ""
    assert not alone["offered"]
    assert "worse" in alone["loo"]["kind"]
    assert "worse" in alone["loo"]["text"]
    assert alone["loo"]["bar"] > 62.5  # beyond the notch of the value before


def test_the_waterfall_adds_up(tab: Tab) -> None:
    tab.click(BOX.format("g_sensitivity"))
    name = idle_effect(tab)
    tab.click(BOX.format(name))
    fall = tab.evaluate(STATE)["fall"]
    assert [name for name, _ in fall] == [
        "base model", "g_sensitivity", name, "remains"]
    whole, first, second, rest = (number for _, number in fall)
    assert whole + first + second == pytest.approx(rest, abs=0.006 * whole)
    assert first < -0.9 * whole


def test_the_axis_grows_for_residuals_that_it_could_not_show(
    browser: Browser, hidden_session: HiddenSession, tmp_path: Path
) -> None:
    folder = tmp_path / "session"
    shutil.copytree(hidden_session.outcome.config.source.path.parent, folder)
    config = folder / "config.yaml"
    head, _, tail = config.read_text(encoding="utf-8").rpartition("misalignment]")
    config.write_text(f"{head}misalignment, g_sensitivity]{tail}", encoding="utf-8")
    page = folder / "report.html"
    page.write_text(report_html(run_stages(load_config(config), RunContext()), ()), "utf-8")
    with browser.tab() as tab:
        tab.open(page)
        tab.evaluate("document.querySelectorAll('details').forEach((each) => { each.open = true })")
        before = tab.evaluate(STATE)
        tab.click(BOX.format("g_sensitivity"))
        without = tab.evaluate(STATE)
    assert float(without["axis"][-1]) > 2 * float(before["axis"][-1])
    assert "worse" in without["rms"]["kind"]
    (judgement,) = without["judgements"]
    assert "it is there" in judgement
    assert "keep it" in judgement
    assert without["commands"].startswith("pipeline remove")  # the way back stays open


def test_a_dot_of_an_axis_picks_its_pose_everywhere(tab: Tab) -> None:
    tab.click(GYRO + ".axes .pose-dots path")
    label, picked, rows = tab.evaluate(
        "const root = document.querySelector('#gyroscope');"
        "const of = (selector) => root.querySelectorAll(selector).length;"
        "return [root.querySelector('[data-pose=label]').textContent, of('.pose-dots .picked'),"
        " of('.residuals .mark.picked')]")
    assert label.startswith("gyroscope/") or label.startswith("accelerometer/")
    assert picked >= 3
    assert rows == 1


def test_boxes_are_ticked_by_keyboard(tab: Tab) -> None:
    box = BOX.format("g_sensitivity")
    tab.evaluate(f"document.querySelector('{box}').focus()")
    tab.key(" ")
    assert tab.evaluate(f"document.querySelector('{box}').checked")
    assert tab.evaluate(STATE)["ghosts_seen"]
    tab.key("Tab")
    assert tab.evaluate("document.activeElement !== document.body")


def test_on_a_phone_the_plot_stays_in_sight_of_every_box_and_text_can_be_read(
    browser: Browser, hidden_session: HiddenSession
) -> None:
    with browser.tab() as tab:
        tab.open(hidden_session.path, PHONE)
        boxes = tab.evaluate(
            "return [...document.querySelectorAll('#gyroscope input[data-effect]:enabled')]"
            ".map((box) => box.dataset.effect)")
        for name in (boxes[0], boxes[-1]):
            tab.tap(BOX.format(name))
            top, bottom, height = tab.evaluate(
                "const b = document.querySelector('#gyroscope .of-poses svg')"
                ".getBoundingClientRect(); return [b.top, b.bottom, window.innerHeight]")
            assert top >= 0, name
            assert bottom <= height, name
        smallest = tab.evaluate(
            "return Math.min(...[...document.querySelectorAll('svg.chart text')]"
            ".filter((t) => t.checkVisibility())"
            ".map((t) => parseFloat(getComputedStyle(t).fontSize)"
            " * t.ownerSVGElement.getBoundingClientRect().width"
            " / t.ownerSVGElement.viewBox.baseVal.width))")
        assert smallest >= SMALLEST_TEXT
        wide = tab.evaluate("return document.documentElement.scrollWidth - window.innerWidth")
        assert wide <= 0


def test_the_page_prints_few_pages(tab: Tab) -> None:
    printed = tab.printed()
    assert printed.startswith(b"%PDF")
    assert 2 <= len(re.findall(rb"/Type\s*/Page\b", printed)) <= MOST_PAGES


def test_the_page_asks_for_nothing_but_itself(tab: Tab, hidden_session: HiddenSession) -> None:
    for name in ("g_sensitivity", "bias_drift"):
        tab.click(BOX.format(name))
    assert set(tab.requests) <= {hidden_session.path.as_uri()}
    assert tab.errors == []


def heights(path: str) -> list[float]:
    """The y of every dot of a path."""
    return [float(y) for y in re.findall(r"M[\d.]+ ([\d.]+)h0", path)]


def test_a_term_of_the_plate_is_tested_by_its_box(browser: Browser, tmp_path: Path) -> None:
    folder = tmp_path / "example"
    shutil.copytree(DATA / "example", folder)
    config = folder / "config.yaml"
    text = re.sub(r"model: \[constant_rate.*\]", "model: [constant_rate]",
                  config.read_text(encoding="utf-8"))
    config.write_text(text, encoding="utf-8")
    outcome = run_stages(load_config(config), RunContext())
    (setting,) = outcome.rates.values()
    page = folder / "report.html"
    page.write_text(report_html(outcome, ()), encoding="utf-8")
    look = """
      const root = document.querySelector('[data-rate="17rpm"]');
      return { rms: Number(root.querySelector('[data-out="phase"]').dataset.value),
        judgement: root.querySelector('[data-out="judgement"]').textContent,
        commands: root.querySelector('[data-out="commands"]').textContent,
        dots: root.querySelector("path.phase").getAttribute("d"),
        ghost: root.querySelector("path.ghost").getAttribute("d") };"""
    with browser.tab() as tab:
        tab.open(page)
        before = tab.evaluate(look)
        tab.click("details.rate > summary")
        tab.click('[data-rate="17rpm"] input[data-term="once_per_rev"]')
        after = tab.evaluate(look)
        tab.click('[data-rate="17rpm"] input[data-term="once_per_rev"]')
        tab.click('[data-rate="17rpm"] input[data-term="rate_drift"]')
        drift = tab.evaluate(look)
    clip = setting.clips[0]
    assert before["rms"] == pytest.approx(57.29578 * clip.fit.rms_rad, rel=1e-4)
    candidate = next(c for c in clip.diagnosis.ranking if c.name == "once_per_rev")
    assert after["rms"] == pytest.approx(57.29578 * candidate.rms_after_rad, rel=0.01)
    assert "it is there" in after["judgement"]
    assert after["commands"] == f"pipeline add {config} rate.17rpm.once_per_rev"
    assert heights(after["ghost"]) == pytest.approx(heights(before["dots"]), abs=0.2)
    assert heights(after["dots"]) != pytest.approx(heights(before["dots"]), abs=5.0)
    assert "not there" in drift["judgement"]
    assert drift["commands"] == ""
