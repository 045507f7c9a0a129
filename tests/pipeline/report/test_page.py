"""``report.html``: complete, self-contained, readable without colour, and true to the results."""

import json
import re
from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path

import pytest

from calib.consistency.clock_ratio import ClockRatio
from calib.diagnosis.verdict.explanation import SIGNS
from pipeline.config.load import load_config
from pipeline.console.answers import Answer, clocks_answer, headline, rates_answer
from pipeline.console.rate_text import RateVerdict
from pipeline.drawings.charts import nice_limit, tick_text, upward
from pipeline.report.page import css_text, report_html
from pipeline.report.page_templates import TERMS, Term, with_terms
from pipeline.report.triad.charts import staircase
from pipeline.report.triad.refit_table import CONSTANTS
from pipeline.results.schema.noise import HistoryLine, HistoryTriad
from pipeline.stages.context import RunContext
from pipeline.stages.run import run_stages
from pipeline.text.formatting import DISPLAY, with_sd
from tests.paths import ROOT
from tests.pipeline.conftest import RunSession
from tests.pipeline.report.html_page import Page, carried
from tests.sessions import pipeline, results_in

LARGEST_BYTES = 2_000_000


@pytest.fixture(scope="module")
def source(finished: RunSession) -> str:
    return (finished.folder / "report.html").read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def page(source: str) -> Page:
    return Page(source)


def test_the_page_is_whole_and_small(page: Page, source: str) -> None:
    assert page.open == []
    assert len(source.encode()) < LARGEST_BYTES


def test_templates_and_scripts_are_short() -> None:
    templates = ROOT / "pipeline" / "report" / "templates"
    long = {path.name: lines for path in templates.rglob("*.*")
            if (lines := len(path.read_text(encoding="utf-8").splitlines())) > 300}
    assert long == {}


def test_the_head_says_what_when_and_with_what(page: Page, finished: RunSession) -> None:
    text = page.text
    found = results_in(finished.folder)
    for words in (found["sensor"], found["config_sha256"][:12], str(finished.config), "pipeline "):
        assert words in text
    step = json.loads((finished.folder / "history.jsonl").read_text("utf-8").splitlines()[-1])
    assert step["when"][:16].replace("T", " ") in text


def test_pages_of_one_result_differ_in_the_date_alone(finished: RunSession) -> None:
    outcome = run_stages(load_config(finished.config), RunContext())
    days = [datetime(2026, 11, day, 9, 30, tzinfo=UTC) for day in (21, 22)]
    first, second = (report_html(outcome, (), when=day) for day in days)
    assert first != second
    assert first.replace("2026-11-21 09:30", "2026-11-22 09:30") == second


def test_a_title_in_the_page_s_footer_cannot_end_its_string() -> None:
    assert css_text('a"; } b') == "a\\22 \\3b \\20 \\7d \\20 b"


def test_the_page_needs_no_network_and_no_other_file(page: Page, source: str) -> None:
    for tag, attributes in page.elements:
        for name in ("src", "href", "srcset", "action", "data"):
            value = attributes.get(name) or ""
            assert value == "" or value.startswith(("#", "data:image/png;base64,")), (tag, value)
    without_data = re.sub(r"data:image/png;base64,[A-Za-z0-9+/=]+", "", source)
    assert not re.search(r"https?://|@import|url\(|fetch\(|XMLHttpRequest", without_data)


def test_the_verdict_and_the_commands_come_before_everything_else(
    page: Page, finished: RunSession
) -> None:
    text = page.text
    verdict = text.index("The calibration is good")
    assert verdict < text.index("Is it good?") < text.index("What is wrong?")
    assert text.index("What to do next?") < text.index("Parameters")
    assert f"pipeline apply {finished.folder} LOG --output" in text


def test_every_picture_says_in_words_what_it_shows(page: Page) -> None:
    labels = [chart.get("aria-label") for chart in page.all("svg")
              if chart.get("aria-hidden") != "true"]
    labels += [picture.get("alt") for picture in page.all("img")]
    assert len(labels) >= 8
    assert all(label and len(label) > 25 for label in labels)


def test_every_plot_has_a_line_that_says_what_good_looks_like(page: Page) -> None:
    classes = [figure["class"] for figure in page.all("figure")
               if figure["class"] != "pose-frame"]  # a photograph is no plot
    panels, triads = classes.count("card panel"), 2
    assert panels >= 6
    assert len(classes) - panels >= 2 * triads
    # The panels of a triad share one line above them.
    assert page.text.count("Good looks like:") >= len(classes) - panels + triads


def test_standings_have_a_sign_and_not_only_a_colour() -> None:
    signs = SIGNS
    assert len(set(signs.values())) == len(signs) == 3


def test_the_tables_hold_what_the_results_hold(page: Page, finished: RunSession) -> None:
    found = results_in(finished.folder)
    for triad in ("accelerometer", "gyroscope"):
        values, sds = found[triad]["parameters"], found[triad]["sd"]
        for key in ("misalignment_rad", "bias_counts", "scale_counts_per_unit"):
            for value, sd in zip(values[key], sds[key], strict=True):
                assert with_sd(value, sd).replace("-", "−") in page.text, key
        unit, factor = DISPLAY[triad]
        assert f"residual {found[triad]['residual_rms'] * factor:.3g} {unit}" in page.text


def test_the_page_is_the_same_for_light_dark_print_and_phone(source: str) -> None:
    for asked in ("prefers-color-scheme: dark", "@media print", "prefers-reduced-motion",
                  'name="viewport"', "max-width: 34rem"):
        assert asked in source


def test_the_rows_in_the_page_are_those_of_the_results(source: str, finished: RunSession) -> None:
    triads = {each["triad"]: each for each in carried(source)["triads"]}
    found = results_in(finished.folder)
    for name, triad in triads.items():
        assert triad["labels"] == [pose["label"] for pose in found[name]["poses"]]
        (own,) = [each for each in triad["refits"] if each["ticked"] == [
            i for i, effect in enumerate(triad["effects"]) if effect["in_model"]]]
        assert (own["chi2"], own["dof"]) == (found[name]["chi2"], found[name]["dof"])
        blind = {e["name"] for e in triad["effects"] if e["reason"]}
        assert set(found[name]["diagnosis"]["blind"]) <= blind


def test_a_title_cannot_smuggle_a_script_into_the_page(
    finished: RunSession, tmp_path: Path
) -> None:
    text = finished.config.read_text(encoding="utf-8")
    config = finished.config.with_name("odd.yaml")
    nasty = "</script><script>alert(1)</script>"
    config.write_text(re.sub(r"title: .*", f"title: '{nasty}'", text), encoding="utf-8")
    try:
        assert pipeline("run", config, "--output", tmp_path / "out") == 0
    finally:
        config.unlink()
    made = (tmp_path / "out" / "report.html").read_text(encoding="utf-8")
    assert "alert(1)" in made
    assert "<script>alert" not in made


# --- the staircase -----------------------------------------------------------------------------


def step(model: tuple[str, ...], rms: float, chi2: float) -> HistoryLine:
    fitted = HistoryTriad(
        model=["bias", "scale", "misalignment", *model], residual_rms=rms, loo_rms=1.2 * rms,
        chi2=chi2, dof=100, verdict="effect")
    return HistoryLine(when="2026-11-21T12:00:00+00:00", config_sha256="0", accelerometer=None,
                       gyroscope=fitted)


def test_the_staircase_falls_step_by_step_and_repeats_count_once() -> None:
    steps = [step((), 1e-3, 5e4), step((), 1e-3, 5e4), step(("g_sensitivity",), 1e-4, 110.0)]
    found = staircase("gyroscope", steps)
    assert [stair[1] for stair in found["stairs"]] == ["base", "+ g_sensitivity"]
    assert [stair[4] for stair in found["stairs"]] == ["500", "1.1"]
    assert "from 0.0573 to 0.00573 °/s" in found["figure"].caption


def test_one_step_is_no_staircase() -> None:
    assert staircase("gyroscope", [step((), 1e-3, 5e4)])["figure"] is None


# --- pieces ------------------------------------------------------------------------------------


@pytest.mark.parametrize(("value", "limit"), [(0.9, 1.0), (1.0, 1.0), (1.01, 1.5), (37.0, 40.0)])
def test_a_limit_is_round_and_not_exceeded(value: float, limit: float) -> None:
    assert nice_limit(value) == pytest.approx(limit)


@pytest.mark.parametrize(
    ("low", "high", "logarithmic"), [(-0.03, 0.03, False), (0.4, 91.0, True), (1e-6, 1e3, True)]
)
def test_ticks_are_few_round_and_inside(low: float, high: float, logarithmic: bool) -> None:
    ticks = upward(low, high, logarithmic=logarithmic).ticks()
    assert 3 <= len(ticks) <= 11
    assert all(low <= tick <= high for tick in ticks)
    assert all(len(tick_text(tick)) <= 6 for tick in ticks)


def test_a_session_without_a_triad_is_said_to_be_unfinished() -> None:
    assert "no triad" in headline([]).text


# --- the headline ------------------------------------------------------------------------------


def verdict_on(name: str, complete: bool, *lacks: str) -> RateVerdict:
    targets = tuple(f"rate.{name}.{term}" for term in lacks)
    return RateVerdict(name, complete, "", lacks, targets)


GOOD = Answer("gyroscope", "good", "nothing is missing", "", "", "", "apply", ())


def test_the_headline_names_every_rate_model_that_its_section_calls_incomplete() -> None:
    rates = rates_answer([
        verdict_on("slow", False, "once_per_rev", "rate_drift"), verdict_on("fast", False),
        verdict_on("back", False, "once_per_rev", "rate_drift"), verdict_on("stated", True),
        replace(verdict_on("old", False), one_of=("once_per_rev", "rolling_shutter"))],
        Path("c.yaml"))
    assert rates is not None
    top = headline([GOOD, rates])
    assert top.standing == "open"
    assert "noise explains the residuals of the gyroscope" in top.text
    assert "rate models of slow and back lack once_per_rev and rate_drift" in top.text
    assert rates.commands == (  # one for all that is open
        "pipeline add c.yaml rate.slow.once_per_rev rate.slow.rate_drift rate.back.once_per_rev "
        "rate.back.rate_drift",)
    assert "rate model of fast lacks a term" in top.text
    assert "rate model of old lacks once_per_rev or rolling_shutter, which its" in top.text
    assert "stated" not in top.text


def test_a_rate_that_gravity_contradicts_is_no_good_calibration() -> None:
    told = clocks_answer({"slow": ClockRatio(-0.021, 1e-4, 1e-4, filmed=False),
                          "fast": ClockRatio(0.001, 1e-4, 1e-4, filmed=True)}, Path("c.yaml"))
    assert told is not None
    top = headline([GOOD, told])
    assert top.standing == "open"
    assert top.text.startswith("Noise explains the residuals of the gyroscope. The rate of slow "
                               "contradicts the logs by 2.1 %, and the scale")
    assert clocks_answer({"fast": ClockRatio(0.001, 1e-4, 1e-4, filmed=True)}, Path("c")) is None


def test_what_all_clips_decide_together_is_told_once() -> None:
    lacking = [replace(verdict_on(name, False, "rolling_shutter"), together="The clips decide it.")
               for name in ("slow", "fast", "back")]
    rates = rates_answer(lacking, Path("c.yaml"))
    assert rates is not None
    assert rates.wrong.count("The clips decide it.") == 1
    assert "decide" not in rates.short


def test_the_headline_is_good_only_if_everything_is() -> None:
    assert rates_answer([verdict_on("slow", True)], Path("c.yaml")) is None
    assert headline([GOOD]).standing == "good"
    act = replace(GOOD, subject="accelerometer", standing="act", short="its model lacks 'cubic'")
    top = headline([GOOD, act])
    assert top.standing == "act"
    assert "The calibration of the gyroscope is good." in top.text
    assert "accelerometer is not complete: its model lacks 'cubic'" in top.text


# --- terms -------------------------------------------------------------------------------------


def test_every_linked_term_has_its_entry_and_every_entry_a_meaning(page: Page) -> None:
    links = {link["href"] for link in page.all("a") if link.get("class") == "term"}
    entries = {f"#{entry.get('id')}" for entry in page.all("div")}
    assert {"#term-chi2-dof", "#term-dof", "#term-loo", "#term-sd", "#term-ppm"} <= links
    assert links <= entries
    assert all(term.meaning in page.text for term in TERMS)


@pytest.mark.parametrize("term", TERMS, ids=lambda term: term.key)
def test_a_term_is_linked_once_where_it_stands_and_not_inside_other_words(term: Term) -> None:
    word = {"dof": "degrees of freedom", "p": "p = 0.1", "loo": "leave-one-out"}.get(
        term.key, term.name)
    linked = with_terms(f"<b> {word}, {word}")
    assert linked.count(f'href="#term-{term.key}"') == 1
    assert linked.startswith("&lt;b&gt; ")
    assert "href" not in with_terms("asdf sdx RMSE ppmx chi")


def test_names_stand_as_they_are_written(source: str) -> None:
    assert "::first-letter" not in source
    assert "text-transform" not in source


def test_the_script_takes_its_levels_from_the_program(source: str) -> None:
    assert carried(source)["constants"] == json.loads(json.dumps(CONSTANTS))
    script = source.split("<script>")[-1]
    for name in CONSTANTS:
        assert re.search(rf"\b{name}: [A-Z_]+", script), name
