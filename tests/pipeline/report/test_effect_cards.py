"""The card of an effect: its drawing, its size in data-sheet units, its fingerprint."""

import math
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from calib.effects.catalogue import EFFECTS, find_effect
from calib.effects.units import display_unit
from calib.poses.imu_log import FloatArray, Triad
from pipeline.report.page_templates import page_templates
from pipeline.report.triad.effect_cards import effect_cards, formula_html
from pipeline.report.triad.fingerprint import fingerprint
from pipeline.report.triad.refit_table import refit_json, tickable
from pipeline.report.triad.refitted import Refits, size_rows
from pipeline.results.json_values import Json
from pipeline.stages.triads import TriadResult
from tests.pipeline.report.browser import needs_browser
from tests.pipeline.report.conftest import HiddenSession
from tests.pipeline.report.html_page import Page
from tests.pipeline.report.tab import PHONE, Browser

G = 9.80665


def cards_of(result: TriadResult, drawings: dict[str, object]) -> list[Json]:
    refits = Refits(result)
    boxes = refit_json(refits, Path("c.yaml"))["effects"]
    return effect_cards(refits, boxes, tuple(drawings))


@pytest.fixture(scope="module")
def drawings() -> dict[str, object]:
    return vars(page_templates().get_template("drawings.html").module)


@pytest.fixture(scope="module")
def cards(hidden_session: HiddenSession, drawings: dict[str, object]) -> dict[str, Json]:
    result = hidden_session.outcome.triad("gyroscope")
    assert result is not None
    every = cards_of(result, drawings)
    return {card["effect"].name: card for card in every}


@pytest.mark.parametrize("name", [*EFFECTS, "column", "user_defined"])
def test_every_effect_has_a_drawing_that_says_in_words_what_it_shows(
    name: str, drawings: dict[str, object]
) -> None:
    draw = drawings[name]
    assert callable(draw)
    page = Page(str(draw()))
    assert page.open == []
    (svg,) = page.all("svg")
    assert svg["role"] == "img"
    assert len(svg["aria-label"] or "") > 40
    assert {"title", "desc"} <= {tag for tag, _ in page.elements}


def test_no_two_drawings_are_the_same(drawings: dict[str, object]) -> None:
    drawn = [str(drawings[name]()) for name in EFFECTS]  # type: ignore[operator]
    without_words = {text.split("</desc>")[1] for text in drawn}
    assert len(without_words) == len(EFFECTS)


def test_every_effect_of_the_triad_has_a_card(cards: dict[str, Json]) -> None:
    assert {name for name, each in EFFECTS.items() if "gyroscope" in each.triads} <= set(cards)
    assert "lever_arm" not in cards


def test_only_the_cards_of_the_verdict_and_the_model_are_open(
    cards: dict[str, Json], hidden_session: HiddenSession
) -> None:
    wide = [name for name, card in cards.items() if card["expanded"]]
    assert wide[0] == "g_sensitivity"
    assert {cards[name]["standing"] for name in wide[1:]} <= {"offered"}
    assert cards["g_sensitivity"]["standing"] == "missing"
    assert cards["bias"]["standing"] == "model"
    page = Page(hidden_session.html)
    is_open = {tag["id"] for tag in page.all("details") if "open" in tag and tag.get("id")}
    assert {name for name in is_open if name and name.startswith("card-gyroscope")} == {
        f"card-gyroscope-{name}" for name in wide}


def test_the_matrix_of_the_card_is_the_hidden_one_in_degrees_per_second_per_g(
    cards: dict[str, Json], hidden_session: HiddenSession
) -> None:
    size = cards["g_sensitivity"]["size"]
    assert size is not None
    assert size["unit"] == "°/s per g"
    assert (size["rows"], size["columns"]) == (("x", "y", "z"), ("x", "y", "z"))
    true = np.degrees(hidden_session.size) * G
    for row, wanted in zip(size["cells"], true, strict=True):
        for (text, spread, *_), value in zip(row, wanted, strict=True):
            sd = float(spread.removeprefix("± "))
            assert float(text.replace("−", "-")) == pytest.approx(value, abs=5 * sd)
            assert 0 < sd < 0.1 * np.abs(true).max()


def test_an_effect_has_one_size_on_its_card_and_in_the_boxes(
    cards: dict[str, Json], hidden_session: HiddenSession
) -> None:
    result = hidden_session.outcome.triad("gyroscope")
    assert result is not None
    refits, told = Refits(result), {}
    for name in tickable(refits):
        alone, size = refits.flipped(name), cards[name]["size"]
        assert alone is not None
        told[name] = [" ".join(filter(None, cell[:2])) for row in size["cells"] for cell in row]
        in_boxes = [re.sub(r"[()]", "", text) for _, text, _ in size_rows(alone.calibration)]
        assert in_boxes[: len(told[name])] == told[name]
    assert len(told) > 8


def test_the_fingerprint_of_what_is_there_is_the_residual_and_no_other_is(
    hidden_session: HiddenSession
) -> None:
    result = hidden_session.outcome.triad("gyroscope")
    assert result is not None
    refits = Refits(result)
    shapes = {name: fingerprint(refits, name) for name in tickable(refits)}
    there = shapes.pop("g_sensitivity")
    assert there is not None
    assert there.explained > 0.95
    assert np.corrcoef(there.measured, there.pattern)[0, 1] > 0.97
    for name, other in shapes.items():
        effect = refits.effect(name)
        assert effect is not None
        assert (other is None) == (effect.acts_on == "noise"), name
        assert other is None or other.explained < 0.7, name
    fit = result.calibration.fit
    # Nothing else is in the model: what is measured is the residual of the fit itself.
    assert there.measured == pytest.approx(fit.rows.residual[: len(there.measured)], abs=1e-4)


def test_a_blind_effect_has_no_fingerprint_and_says_why(cards: dict[str, Json]) -> None:
    card = cards["reference_scale"]
    assert (card["standing"], card["fingerprint"]) == ("unseen", "")
    assert "cannot determine it" in card["confused_here"]


def test_no_card_separates_what_another_card_cannot(cards: dict[str, Json]) -> None:
    words = {name: card["confused_here"] for name, card in cards.items()}
    confused = {name: text for name, text in words.items() if "cannot separate it from" in text}
    assert confused
    for text in confused.values():
        for other in words.keys() & set(re.findall(r"\w+", text)):
            assert "from every other listed effect" not in words[other]


def test_an_effect_without_a_drawing_has_that_of_a_user_s_effect(
    hidden_session: HiddenSession, drawings: dict[str, object]
) -> None:
    result = hidden_session.outcome.triad("gyroscope")
    assert result is not None
    mine = replace(find_effect("bias_drift"), name="fan <b>heat</b>")
    with_mine = replace(result, made_from=replace(
        result.made_from, defined={mine.name: mine}))
    cards = cards_of(with_mine, drawings)
    (card,) = (each for each in cards if each["effect"].name == mine.name)
    assert card["drawing"] == "user_defined"
    assert "<b>" not in card["fingerprint"]


@pytest.mark.parametrize(("name", "triad", "size", "unit", "shown"), [
    ("g_sensitivity", "gyroscope", 2e-4, "°/s per g", math.degrees(2e-4) * G),
    ("temperature_bias", "accelerometer", 5e-3, "mm/s² per K", 5.0),
    ("g_sensitivity", "gyroscope", 2e-6, "°/s per g", math.degrees(2e-6) * G),
    ("scale", "gyroscope", 3e-2, "%", 3.0),
    ("temperature_scale", "gyroscope", 2e-5, "ppm per K", 20.0),
    ("earth_rate", "gyroscope", 5e-5, "°/h", math.degrees(5e-5) * 3600),
    ("lever_arm", "accelerometer", 0.013, "mm", 13.0),
    ("quadratic", "gyroscope", 1e-4, "ppm per °/s", 1e-4 * math.radians(1) * 1e6),
])
def test_sizes_have_one_unit_in_front_of_every_per(
    name: str, triad: Triad, size: float, unit: str, shown: float
) -> None:
    sizes: FloatArray = np.array([size])
    assert display_unit(find_effect(name).unit_for(triad), sizes) == (
        unit, pytest.approx(shown / size))


def test_a_unit_that_is_not_known_stays_as_it_is() -> None:
    assert display_unit("furlong/W²", np.array([1.0])) == ("furlong/W²", 1.0)
    assert display_unit("(rad/s)/W²", np.array([1.0])) == (
        "°/s per W²", pytest.approx(math.degrees(1)))


def test_indices_of_a_formula_are_set_low_and_names_stay() -> None:
    assert formula_html("e_k = K3_k · s_k³") == (
        "e<sub>k</sub> = K3<sub>k</sub> · s<sub>k</sub>³")
    assert formula_html("c_k · fan_rpm < 3") == "c<sub>k</sub> · fan_rpm &lt; 3"


@needs_browser
def test_cards_open_and_close_by_keyboard_and_by_touch(
    browser: Browser, hidden_session: HiddenSession
) -> None:
    summary = "#card-gyroscope-cubic > summary"
    is_open = "document.getElementById('card-gyroscope-cubic').open"
    with browser.tab() as tab:
        tab.open(hidden_session.path)
        tab.unfold()
        assert tab.evaluate(is_open) is False
        tab.evaluate(f"document.querySelector('{summary}').focus()")
        tab.key("Enter")
        assert tab.evaluate(is_open) is True
        tab.key(" ")
        assert tab.evaluate(is_open) is False
        tab.open(hidden_session.path, PHONE)
        tab.unfold()
        tab.tap(summary)
        assert tab.evaluate(is_open) is True
        wide = tab.evaluate("return [document.documentElement.scrollWidth, window.innerWidth];")
        assert wide[0] <= wide[1]
        assert tab.requests == [hidden_session.path.as_uri()] * 2
        assert tab.errors == []
