"""The cards of the plate's terms: what was put into an angle is what its card shows."""

import math
import re

import numpy as np
import pytest

from pipeline.console.effect_pages import page_lines
from pipeline.report.plate.term_cards import term_cards
from pipeline.report.triad.effect_cards import Card
from pipeline.stages.rate import measure_setting
from tests.vision.phase_tracks import phase_track, steady
from vision.rate.term_pages import TERM_PAGES
from vision.rate.terms import CONSTANT_RATE, MEANING, TERMS
from vision.rate.timebase import Timebase

AMPLITUDE_RAD, PHASE_RAD = 0.012, 0.4
DRIFT_PER_MIN = 400e-6


def cards_of(angle_rad: np.ndarray, *model: str) -> dict[str, Card]:
    track = phase_track(steady()[0], angle_rad, noise_rad=2e-4, seed=3)
    rate = measure_setting("slow", [track], Timebase(),
                           model=(CONSTANT_RATE, *model))
    return {card.name: card for card in term_cards(rate, 0)}


@pytest.fixture(scope="module")
def wave() -> np.ndarray:
    """A plate whose mark circles about a centre that is off."""
    angle = steady()[1]
    return np.asarray(angle + AMPLITUDE_RAD * np.cos(angle - PHASE_RAD))


@pytest.fixture(scope="module")
def cards(wave: np.ndarray) -> dict[str, Card]:
    return cards_of(wave)


def number(text: str) -> tuple[float, float]:
    value, sd = re.findall(r"−?[\d.]+", text)[:2]
    return float(value.replace("−", "-")), float(sd)


def test_the_missing_term_comes_first_and_open_with_its_size(cards: dict[str, Card]) -> None:
    first = next(iter(cards.values()))
    assert (first.name, first.standing, first.expanded) == ("once_per_rev", "missing", True)
    amplitude, sd = number(first.size)
    assert abs(amplitude - math.degrees(AMPLITUDE_RAD)) < 4 * sd < 0.01
    assert float(re.findall(r"explains ([\d.e+]+) %", first.caption)[0]) > 99


def test_the_fingerprint_is_the_same_when_the_term_is_in_the_model(
    wave: np.ndarray, cards: dict[str, Card]
) -> None:
    added = cards_of(wave, "once_per_rev")["once_per_rev"]
    assert added.standing == "model"
    drawn = (re.findall(r'd="([^"]+)"', card.fingerprint)
             for card in (added, cards["once_per_rev"]))
    assert next(drawn)[-1][:40] == next(drawn)[-1][:40]
    assert number(added.size)[0] == pytest.approx(number(cards["once_per_rev"].size)[0], rel=1e-3)


def test_a_term_that_is_not_there_explains_nothing(cards: dict[str, Card]) -> None:
    card = cards["twice_per_rev"]
    assert card.standing == "idle"
    assert float(re.findall(r"explains ([\d.e-]+) %", card.caption)[0]) < 1


def test_without_dropped_frames_there_is_no_fingerprint_of_them(
    cards: dict[str, Card]
) -> None:
    card = cards["frame_steps"]
    assert (card.standing, card.fingerprint, card.size) == ("unavailable", "", "")
    assert card.status == "no frame was dropped"


def test_a_drift_is_stated_in_parts_of_the_rate_per_minute() -> None:
    time, angle = steady()
    rate = (angle[-1] - angle[0]) / (time[-1] - time[0])
    drifting = angle + 0.5 * rate * DRIFT_PER_MIN / 60 * (time - time.mean()) ** 2
    value, sd = number(cards_of(drifting, "rate_drift")["rate_drift"].size)
    assert abs(value - 1e6 * DRIFT_PER_MIN) < 4 * sd < 40


@pytest.mark.parametrize("name", TERMS)
def test_every_term_has_a_page_with_its_formula_and_what_separates_it(name: str) -> None:
    text = " ".join(" ".join(page_lines(name)).split())
    page = TERM_PAGES[name]
    for words in (MEANING[name], page.formula, page.typical, page.confounded, page.separates):
        assert " ".join(words.split()) in text
