"""The card of an effect: its standing, and its size in data-sheet units."""

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from calib.effects.catalogue import EFFECTS, find_effect
from calib.effects.effect import Effect
from calib.effects.units import display_unit
from calib.poses.imu_log import FloatArray, Triad
from pipeline.report.triad.effect_cards import Card, effect_cards, formula_html
from pipeline.report.triad.refit_table import refit_json
from pipeline.report.triad.refitted import Refits
from pipeline.stages.triads import TriadResult
from tests.pipeline.report.browser import needs_browser
from tests.pipeline.report.conftest import HiddenSession
from tests.pipeline.report.html_page import Page
from tests.pipeline.report.tab import PHONE, Browser

G = 9.80665


def cards_of(result: TriadResult, defined: dict[str, Effect]) -> tuple[Card, ...]:
    return effect_cards(
        result, refit_json(result, Refits(result, defined), Path("c.yaml")), defined)


@pytest.fixture(scope="module")
def cards(hidden_session: HiddenSession) -> dict[str, Card]:
    result = hidden_session.outcome.triad("gyroscope")
    assert result is not None
    return {card.name: card for card in cards_of(result, {})}


def test_every_effect_of_the_triad_has_a_card(cards: dict[str, Card]) -> None:
    assert {name for name, each in EFFECTS.items() if "gyroscope" in each.triads} <= set(cards)
    assert "lever_arm" not in cards


def test_only_the_cards_of_the_verdict_and_the_model_are_open(
    cards: dict[str, Card], hidden_session: HiddenSession
) -> None:
    wide = [name for name, card in cards.items() if card.expanded]
    assert wide[0] == "g_sensitivity"
    assert {cards[name].standing for name in wide[1:]} <= {"offered"}
    assert cards["g_sensitivity"].standing == "missing"
    assert cards["bias"].standing == "model"
    page = Page(hidden_session.html)
    is_open = {tag["id"] for tag in page.all("details") if "open" in tag and tag.get("id")}
    assert {name for name in is_open if name and name.startswith("card-gyroscope")} == {
        f"card-gyroscope-{name}" for name in wide}


def test_the_matrix_of_the_card_is_the_hidden_one_in_degrees_per_second_per_g(
    cards: dict[str, Card], hidden_session: HiddenSession
) -> None:
    size = cards["g_sensitivity"].size
    assert size is not None
    assert size.unit == "°/s per g"
    assert (size.rows, size.columns) == (("x", "y", "z"), ("x", "y", "z"))
    true = np.degrees(hidden_session.size) * G
    for row, wanted in zip(size.cells, true, strict=True):
        for cell, value in zip(row, wanted, strict=True):
            sd = float(cell.sd.removeprefix("± "))
            assert float(cell.value.replace("−", "-")) == pytest.approx(value, abs=5 * sd)
            assert 0 < sd < 0.1 * np.abs(true).max()


def test_a_blind_effect_says_why(cards: dict[str, Card]) -> None:
    card = cards["reference_scale"]
    assert card.standing == "unseen"
    assert "cannot determine it" in card.confused_here


def test_a_user_s_effect_has_a_card_by_its_name(hidden_session: HiddenSession) -> None:
    result = hidden_session.outcome.triad("gyroscope")
    assert result is not None
    mine = replace(find_effect("bias_drift"), name="fan_heat")
    assert mine.name in {card.name for card in cards_of(result, {mine.name: mine})}


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
