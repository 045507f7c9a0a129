"""The report in a real browser: what a box does is what `pipeline add` does."""

import re
import shutil
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from calib.effects.catalogue import find_effect
from calib.errors import CalibrationError
from calib.fit.least_squares.result import Fit
from calib.fit.least_squares.solver import fit
from calib.fit.validation.leave_one_out import compare
from pipeline.config.load import load_config
from pipeline.report.page import report_html
from pipeline.stages.context import RunContext
from pipeline.stages.run import Outcome, run_stages
from tests.pipeline.report.browser import needs_browser
from tests.pipeline.report.conftest import HiddenSession
from tests.pipeline.report.tab import PHONE, Browser
from tests.sessions import pipeline, quick_session, results_in

pytestmark = needs_browser

TICKED_WITHIN = 1e-9  #: of the exact refit: the page looks it up
SHOWN = {"accelerometer": 1000.0, "gyroscope": np.degrees(1.0)}  #: of one SI unit, as shown

#: Ticks every box of a triad on its own and notes what the page then says.
TICK_EACH = """
const found = {};
for (const section of document.querySelectorAll("section[data-triad]")) {
  const seen = found[section.dataset.triad] = {};
  const read = () => ({
    rms: Number(section.querySelector('[data-out="rms"]').dataset.value),
    loo: Number(section.querySelector('[data-out="loo"]').dataset.value),
    chi2_dof: Number(section.querySelector('[data-out="chi2"]').dataset.value),
    sizes: [...section.querySelectorAll('[data-out="sizes"] tr')].map((r) => r.innerText),
    judgements: [...section.querySelectorAll('[data-out="judgement"] p')].map((p) => p.textContent),
    words: section.querySelector('[data-out="words"]').textContent,
    commands: section.querySelector('[data-out="commands"]').textContent,
    disabled: [...section.querySelectorAll("input:disabled")].map((b) => b.dataset.effect),
    notes: Object.fromEntries([...section.querySelectorAll("[data-note]")].map(
      (n) => [n.dataset.note, n.textContent])),
    marks: [...section.querySelectorAll("svg.residuals g.mark")].map(
      (m) => m.style.transform),
  });
  seen[""] = read();
  for (const box of section.querySelectorAll("input[data-effect]")) {
    if (box.disabled) continue;
    box.click();
    seen[box.dataset.effect] = read();
    box.click();
  }
}
return found;
"""
WIDTH = "return [document.documentElement.scrollWidth, window.innerWidth];"
READ = TICK_EACH.replace("box.click();", "")


@dataclass(frozen=True, eq=False)
class Opened:
    """A session with something hidden in both triads, run, and each of its boxes ticked once."""

    config: Path
    outcome: Outcome
    page: str
    seen: dict[str, dict[str, Any]]

    def fit_of(self, triad: str) -> Fit:
        result = next(each for each in self.outcome.triads if each.triad == triad)
        return result.calibration.fit


@pytest.fixture(scope="module")
def opened(
    both_missing: Outcome, browser: Browser, tmp_path_factory: pytest.TempPathFactory
) -> Opened:
    page = report_html(both_missing, ())
    return Opened(both_missing.config.source.path, both_missing, page,
                  browser.ask(page, tmp_path_factory.mktemp("opened"), TICK_EACH))


@pytest.mark.parametrize("triad", ["accelerometer", "gyroscope"])
def test_without_a_tick_the_page_shows_the_fit_itself(opened: Opened, triad: str) -> None:
    shown, result = opened.seen[triad][""], next(
        each for each in opened.outcome.triads if each.triad == triad)
    own = result.calibration.fit
    assert shown["rms"] == pytest.approx(own.residual_rms * SHOWN[triad], rel=1e-12)
    assert shown["loo"] == pytest.approx(result.comparison.loo_rms * SHOWN[triad], rel=1e-12)
    assert shown["chi2_dof"] == pytest.approx(own.chi2 / own.dof, rel=1e-12)


@pytest.fixture(scope="module")
def quiet(browser: Browser, tmp_path_factory: pytest.TempPathFactory) -> Opened:
    """A session of the paper's size in which nothing is missing."""
    folder = tmp_path_factory.mktemp("quiet")
    config, _ = quick_session(folder, seed=2)
    outcome = run_stages(load_config(config), RunContext())
    page = report_html(outcome, ())
    return Opened(config, outcome, page, browser.ask(page, folder, TICK_EACH))


@pytest.mark.parametrize("triad", ["accelerometer", "gyroscope"])
@pytest.mark.parametrize("session", ["opened", "quiet"])
def test_every_box_gives_what_the_exact_refit_gives(
    session: str, triad: str, request: pytest.FixtureRequest
) -> None:
    opened: Opened = request.getfixturevalue(session)
    base, compared = opened.fit_of(triad), 0
    for name, shown in opened.seen[triad].items():
        if not name:
            continue
        try:
            exact = fit(base.poses, base.model + find_effect(name))
        except CalibrationError:
            continue
        compared += 1
        assert shown["rms"] == pytest.approx(exact.residual_rms * SHOWN[triad],
                                             rel=TICKED_WITHIN), name
        assert shown["loo"] == pytest.approx(compare(exact).loo_rms * SHOWN[triad],
                                             rel=TICKED_WITHIN), name
        assert shown["chi2_dof"] == pytest.approx(exact.chi2 / exact.dof, rel=TICKED_WITHIN), name
        assert len(shown["sizes"]) == exact.model.size - 9 + len(exact.shapes), name
    assert compared >= 8


def test_ticking_both_boxes_is_the_fit_with_both(
    browser: Browser, opened: Opened, tmp_path: Path
) -> None:
    result = opened.outcome.triad("gyroscope")
    assert result is not None
    # The page keeps the moment of a step where it is best by itself.
    other = [c.name for c in result.diagnosis.ranking
             if c.kind == "listed" and c.name != "bias_step"][1]
    asked = f"#tick=gyroscope.g_sensitivity,gyroscope.{other}"
    shown = browser.ask(opened.page, tmp_path, READ, asked)["gyroscope"][""]
    base = opened.fit_of("gyroscope")
    both = base.model + find_effect("g_sensitivity") + find_effect(other)
    exact = fit(base.poses, both)
    assert shown["rms"] == pytest.approx(exact.residual_rms * SHOWN["gyroscope"], rel=1e-4)
    # The other is not there, and the page offers no command for it.
    assert shown["commands"] == f"pipeline add {opened.config} gyroscope.g_sensitivity"
    there, not_there = shown["judgements"]
    assert there.startswith("g_sensitivity: ")
    assert "it is there; leave-one-out falls" in there
    assert re.match(rf"{other}: [0-3]\.\d sd: not (there|seen)", not_there)


def test_what_pipeline_add_makes_is_what_the_box_promised_and_back(
    browser: Browser, opened: Opened, tmp_path: Path
) -> None:
    folder = tmp_path / "session"
    shutil.copytree(opened.config.parent, folder)
    config = folder / opened.config.name
    assert pipeline("add", config, "gyroscope.g_sensitivity") == 0
    results = config.with_suffix(".run")
    after = results_in(results)["gyroscope"]
    promised = opened.seen["gyroscope"]["g_sensitivity"]
    assert promised["rms"] == pytest.approx(
        after["residual_rms"] * SHOWN["gyroscope"], rel=TICKED_WITHIN)
    assert promised["loo"] == pytest.approx(
        after["loo_rms"] * SHOWN["gyroscope"], rel=TICKED_WITHIN)
    # The report of the larger model: its box is ticked, and taking it out leads back.
    seen = browser.ask((results / "report.html").read_text(encoding="utf-8"), tmp_path, TICK_EACH)
    assert seen["gyroscope"][""]["rms"] == pytest.approx(
        after["residual_rms"] * SHOWN["gyroscope"], rel=TICKED_WITHIN)
    without = seen["gyroscope"]["g_sensitivity"]
    assert without["rms"] == pytest.approx(
        opened.seen["gyroscope"][""]["rms"], rel=TICKED_WITHIN)
    assert without["commands"] == f"pipeline remove {config} gyroscope.g_sensitivity"


def test_a_tick_under_a_robust_loss_gives_what_the_robust_refit_gives(
    browser: Browser, opened: Opened, tmp_path: Path
) -> None:
    text = opened.config.read_text(encoding="utf-8")
    head, _, tail = text.rpartition("model: [bias, scale, misalignment]")
    config = opened.config.with_name("huber.yaml")
    config.write_text(f"covariates: [humidity_pct]\n{head}loss: huber\n  "
                      f"model: [bias, scale, misalignment]{tail}", "utf-8")
    outcome = run_stages(load_config(config), RunContext())
    result = outcome.triad("gyroscope")
    assert result is not None
    own = result.calibration.fit
    assert own.weight.min() < 0.5
    ticked = ("g_sensitivity", "column:humidity_pct")
    seen = browser.ask(report_html(outcome, ()), tmp_path, TICK_EACH.replace(
        "box.disabled", f"box.disabled || !{list(ticked)}.includes(box.dataset.effect)"))
    seen = seen["gyroscope"]
    assert "column:supply_v" not in {each.name for each in result.diagnosis.ranking}
    for name in ticked:
        exact = fit(own.poses, own.model + find_effect(name), robust=True)
        assert seen[name]["rms"] == pytest.approx(
            exact.residual_rms * SHOWN["gyroscope"], rel=TICKED_WITHIN), name
    shown = seen[""]
    assert shown["rms"] == pytest.approx(own.residual_rms * SHOWN["gyroscope"], rel=TICKED_WITHIN)
    assert shown["loo"] == pytest.approx(
        result.comparison.loo_rms * SHOWN["gyroscope"], rel=TICKED_WITHIN)
    assert shown["chi2_dof"] == pytest.approx(own.chi2 / own.dof, rel=TICKED_WITHIN)


def test_the_residuals_move_with_a_tick(opened: Opened) -> None:
    seen = opened.seen["gyroscope"]
    moved = sum(a != b for a, b in zip(seen[""]["marks"], seen["g_sensitivity"]["marks"],
                                       strict=True))
    assert moved > 0.9 * len(seen[""]["marks"])


def test_an_alias_of_a_ticked_effect_cannot_be_ticked_and_says_why(opened: Opened) -> None:
    result = opened.outcome.triad("accelerometer")
    assert result is not None
    tied = {c.name: c.aliases for c in result.diagnosis.ranking if c.kind == "listed"}
    name, (alias, *_) = next((n, a) for n, a in tied.items() if a)
    shown = opened.seen["accelerometer"][name]
    assert alias in shown["disabled"]
    assert f"These poses cannot separate it from {name}." in shown["notes"][alias]
    # A guess is overruled by the user; a member of a class that is named is none.
    assert shown["commands"].endswith("--anyway") != bool(result.diagnosis.named_class(name))


def test_what_the_poses_cannot_see_is_grey_from_the_start(opened: Opened) -> None:
    for result in opened.outcome.triads:
        assert set(result.diagnosis.blind) <= set(opened.seen[result.triad][""]["disabled"])


def test_nothing_reaches_beyond_the_width_of_a_phone(
    browser: Browser, opened: Opened, tmp_path: Path
) -> None:
    needed, there = browser.ask(opened.page, tmp_path, WIDTH, "", PHONE)
    assert needed <= there


def test_a_page_that_was_copied_says_that_its_commands_are_for_the_place_where_it_was_made(
    browser: Browser, hidden_session: HiddenSession, tmp_path: Path
) -> None:
    folder = tmp_path / "Jörg's evening (1) #2"
    other = tmp_path / "other"
    for each in (folder, other):
        each.mkdir()
        (each / "report.html").write_text(
            report_html(hidden_session.outcome, (), folder), encoding="utf-8")
    with browser.tab() as tab:
        for each, is_copy in ((folder, False), (other, True)):
            tab.open(each / "report.html")
            assert tab.evaluate("!document.querySelector('[data-moved]').hidden") == is_copy
            assert str(folder) in tab.evaluate("document.querySelector('.identity').textContent")
