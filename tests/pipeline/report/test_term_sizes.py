"""The sizes of the plate's terms: what was put into an angle is what is stated."""

import math
import re

import numpy as np
import pytest

from pipeline.console.effect_pages import page_lines
from pipeline.report.plate.rate_charts import term_sizes
from pipeline.stages.rate import measure_setting
from tests.vision.phase_tracks import phase_track, steady
from vision.rate.term_pages import TERM_PAGES
from vision.rate.terms import CONSTANT_RATE, MEANING, TERMS
from vision.rate.timebase import Timebase

AMPLITUDE_RAD, PHASE_RAD = 0.012, 0.4
DRIFT_PER_MIN = 400e-6


def sizes_of(angle_rad: np.ndarray, *model: str) -> dict[str, str]:
    track = phase_track(steady()[0], angle_rad, noise_rad=2e-4, seed=3)
    rate = measure_setting("slow", [track], Timebase(),
                           model=(CONSTANT_RATE, *model))
    return dict(term_sizes(rate.clips[0]))


def number(text: str) -> tuple[float, float]:
    value, sd = re.findall(r"−?[\d.]+", text)[:2]
    return float(value.replace("−", "-")), float(sd)


@pytest.mark.parametrize("model", [(), ("once_per_rev",)])
def test_a_wave_has_its_amplitude_whether_it_is_missing_or_in_the_model(
    model: tuple[str, ...]
) -> None:
    angle = steady()[1]
    sizes = sizes_of(angle + AMPLITUDE_RAD * np.cos(angle - PHASE_RAD), *model)
    amplitude, sd = number(sizes["size of once_per_rev"])
    assert abs(amplitude - math.degrees(AMPLITUDE_RAD)) < 4 * sd < 0.01
    assert list(sizes) == ["size of once_per_rev"]  # no other term is named


def test_a_drift_is_stated_in_parts_of_the_rate_per_minute() -> None:
    time, angle = steady()
    rate = (angle[-1] - angle[0]) / (time[-1] - time[0])
    drifting = angle + 0.5 * rate * DRIFT_PER_MIN / 60 * (time - time.mean()) ** 2
    value, sd = number(sizes_of(drifting, "rate_drift")["size of rate_drift"])
    assert abs(value - 1e6 * DRIFT_PER_MIN) < 4 * sd < 40


@pytest.mark.parametrize("name", TERMS)
def test_every_term_has_a_page_with_its_formula_and_what_separates_it(name: str) -> None:
    text = " ".join(" ".join(page_lines(name)).split())
    page = TERM_PAGES[name]
    for words in (MEANING[name], page.formula, page.typical, page.confounded, page.separates):
        assert " ".join(words.split()) in text
