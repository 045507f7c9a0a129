"""The diagnosis: every verdict is reached where it is due, and nowhere else.

Sessions come from the simulated bench, which shares no formula with the effects. The counts here
are small; ``python -m tests.bench.study_diagnosis`` has the large ones. Thresholds are what a
diagnosis that meets its goals misses once in a hundred runs or less.
"""

import re
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from scipy.stats import chi2

from calib.diagnosis.diagnose import Diagnosis, diagnose
from calib.effects.catalogue import BASE, EFFECTS
from calib.fit.least_squares.solver import fit
from calib.fit.model import Model
from calib.poses.pose_set import PoseSet
from tests.chance import fewest_hits, largest_left_out_rms, largest_rms
from tests.recorded_blocks import settle
from tests.trials import LISTED, drawn, follow_to_the_end, hidden_of, poses_of, run_trial
from tests.world.bench import Design
from tests.world.designs import paper_design, rich_design, soak_design
from tests.world.hidden import Hidden

# A quarter of the samples leaves the noise of a pose mean nearly as it is: the slow part rules.
RICH = rich_design().scaled(sample_rate=0.25)
PAPER = paper_design().scaled(sample_rate=0.25)
SOAK = soak_design().scaled(sample_rate=0.5)
RICH_ROWS, SOAK_ROWS = 126, 78  #: magnitudes, and components at rest for the gyro
TWO_SIGMA = 0.9545
INSIDE_THE_RATES_SD = ("reference_offset",)
BLIND_EVERYWHERE = ("frame_rotation", "reference_scale")
NOT_SO_LARGE = ("earth_rate",)  #: five noise units are twenty times the Earth's rate
SEEN_BY_ALL = [n for n in LISTED
               if n not in (*INSIDE_THE_RATES_SD, *BLIND_EVERYWHERE, *NOT_SO_LARGE)]
BLIND_ON_THE_PAPERS_POSES = (
    "frame_rotation",
    "g_sensitivity",
    "earth_rate",
    "reference_offset",
    "reference_scale",
    "direction_dependent_rate",
)


def said_of(poses: PoseSet) -> Diagnosis:
    return diagnose(fit(poses, Model.of(BASE)))


@cache
def clean(design_name: str, seed: int) -> Diagnosis:
    design = {"rich": RICH, "paper": PAPER, "soak": SOAK}[design_name]
    triad = "accelerometer" if design_name == "soak" else "gyroscope"
    return said_of(poses_of(design, seed, triad, ()))


def with_hidden(name: str, size: float, design: Design, seed: int, triad: str) -> Diagnosis:
    hidden = hidden_of([name], triad, size, design, seed)
    assert hidden is not None
    return said_of(poses_of(design, seed, triad, hidden))


# --- one effect --------------------------------------------------------------------------------


@pytest.mark.parametrize("name", SEEN_BY_ALL)
def test_a_rich_session_names_what_is_hidden_and_the_error_falls(name: str) -> None:
    """One session each at five noise units; the study has 40 at two, five and ten."""
    hidden = drawn(name, "gyroscope", 5.0, RICH, 101)
    assert hidden is not None
    found = run_trial(RICH, 101, "gyroscope", [hidden])
    assert found.named, f"{found.verdict} {found.says}"
    assert found.first
    noise = largest_rms(RICH_ROWS, Model.of((*BASE, name)).size)
    assert found.rms_after < noise < found.rms_before
    assert found.loo_after < largest_left_out_rms(RICH_ROWS, Model.of((*BASE, name)).size)


@pytest.mark.parametrize("seed", [101, 102])
def test_no_size_that_nature_does_not_have_explains(seed: int) -> None:
    """A floor that turns twenty times as fast as the Earth is not the Earth."""
    found = with_hidden("earth_rate", 5.0, RICH, seed, "gyroscope")
    assert found.verdict != "nothing_missing"
    assert "earth_rate" not in (*found.names, *found.group)


def test_a_size_that_no_part_has_is_told_and_not_named() -> None:
    """Some 10 °/s per g is a hundred times what data sheets quote."""
    poses = poses_of(RICH, 104, "gyroscope", [])
    matrix = np.radians(10.0) / 9.8 * np.random.default_rng(1).standard_normal((3, 3))
    found = said_of(replace(poses, reading=poses.reading + poses.force @ matrix.T))
    assert "g_sensitivity" not in (*found.names, *found.group)
    assert "'g_sensitivity' would explain most of it, but would be" in found.text
    assert "times the largest that such sensors have: look for bad poses first" in found.text


def test_the_earth_at_its_own_rate_can_be_named() -> None:
    """By a gyroscope with a thousandth of the noise."""
    quiet = replace(RICH, sensor=RICH.sensor.with_noise(1e-3), rate_sd_relative=1e-8)
    hidden = Hidden("earth_rate", "gyroscope", np.array(5e-5))
    found = said_of(poses_of(quiet, 103, "gyroscope", [hidden]))
    assert "earth_rate" in (*found.names, *found.group), found.text


@pytest.mark.parametrize("name", ["temperature_bias", "temperature_scale", "bias_drift",
                                  "quadratic", "cubic", "cross_quadratic", "hysteresis"])
def test_three_soaks_name_what_an_accelerometer_hides(name: str) -> None:
    hidden = drawn(name, "accelerometer", 5.0, SOAK, 105)
    assert hidden is not None
    found = run_trial(SOAK, 105, "accelerometer", [hidden])
    # Asymmetry and quadratic look alike in 26 poses: there it may stay open between the two.
    assert found.first
    assert name in found.says, f"{found.verdict} {found.says}"
    assert found.named or set(found.says) == {"quadratic", "asymmetry"}
    noise = largest_rms(SOAK_ROWS, Model.of((*BASE, name)).size)
    assert found.rms_after < noise or not found.named


@pytest.mark.parametrize("name", ["quadratic", "cross_quadratic", "scale_drift", "reference_drift"])
def test_the_papers_own_poses_never_name_another_effect(name: str) -> None:
    for seed in (110, 111):
        found = with_hidden(name, 10.0, PAPER, seed, "gyroscope")
        right = {name, "scale_drift"} if name == "reference_drift" else {name}
        assert found.verdict != "effect" or set(found.group) & right, f"seed {seed}: {found.text}"


def test_the_sizes_two_sigma_interval_holds_the_truth() -> None:
    """6 sessions of three effects, 30 parameters."""
    held = stated = 0
    for seed in range(2):
        for name in ("bias_drift", "g_sensitivity", "quadratic"):
            hidden = drawn(name, "gyroscope", 5.0, RICH, seed)
            assert hidden is not None
            found = run_trial(RICH, seed, "gyroscope", [hidden])
            held, stated = held + found.held, stated + found.stated
    assert stated == 2 * (3 + 9 + 3)
    assert held >= fewest_hits(stated, TWO_SIGMA)


# --- nothing, and what cannot be seen ----------------------------------------------------------


@pytest.mark.parametrize("design", ["rich", "paper", "soak"])
def test_clean_sessions_name_nothing(design: str) -> None:
    """Real noise is correlated and so is this; 4 sessions, at most one doubt."""
    said = [clean(design, seed).verdict for seed in range(4)]
    assert "effect" not in said
    assert said.count("nothing_missing") >= 3


def test_nothing_missing_says_how_well_the_noise_explains_the_residual() -> None:
    found = clean("rich", 0)
    assert found.verdict == "nothing_missing"
    assert found.name is None
    assert found.text.startswith("Nothing is missing: the poses' own noise explains the residual")
    assert found.p_value > 1e-3


@pytest.mark.parametrize("name", BLIND_ON_THE_PAPERS_POSES)
def test_effects_that_one_speed_cannot_show_are_listed_as_blind_and_never_named(name: str) -> None:
    for seed in (120, 121):
        found = with_hidden(name, 20.0, PAPER, seed, "gyroscope")
        assert name in found.blind
        assert name not in {c.name for c in found.ranking}
        assert found.verdict in ("nothing_missing", "ambiguous")
        assert name not in found.group


def test_a_rotated_frame_and_a_wrong_clock_are_blind_in_any_design() -> None:
    for design in ("rich", "paper", "soak"):
        assert {"frame_rotation", "reference_scale"} <= set(clean(design, 1).blind)


def test_without_logged_temperature_its_effects_are_unavailable_and_say_why() -> None:
    poses = poses_of(PAPER, 1, "gyroscope", ())
    found = said_of(replace(poses, columns={}))
    assert set(found.unavailable) == {name for name in EFFECTS if name.startswith("temp")}
    assert "no complete column temperature_c" in found.unavailable["temperature_bias"]


# --- aliases and what to record ----------------------------------------------------------------


def test_aliases_are_named_together_with_what_separates_them() -> None:
    """On 18 wedge poses at one speed three effects are one."""
    found = with_hidden("quadratic", 10.0, PAPER, 1, "gyroscope")
    assert found.verdict == "effect"
    assert set(found.group) == {"quadratic", "asymmetry", "g_squared_sensitivity"}
    assert not found.addable
    assert re.match(r"'\w+', '\w+' or '\w+' is missing; they look the same here, so that these "
                    r"poses cannot determine which\. '\w+': ", found.text)
    assert found.record_next is not None
    assert found.record_next in found.text


@pytest.mark.parametrize(
    ("name", "seed"), [("quadratic", 1), ("asymmetry", 6), ("g_squared_sensitivity", 2),
                       ("cross_quadratic", 13), ("temperature_bias", 13)]
)
def test_recording_the_advised_block_settles_an_open_verdict(name: str, seed: int) -> None:
    size = 5.0 if name == "temperature_bias" else 10.0  # at 10 it is settled at once
    hidden = drawn(name, "gyroscope", size, PAPER, seed)
    assert hidden is not None
    settled = settle(PAPER, seed, "gyroscope", [hidden])
    assert settled is not None, "this session is settled at once; another seed stays open"
    assert settled.block is not None
    assert settled.right, f"after {settled.block}: {settled.verdict} {settled.after}"


def test_a_far_stronger_effect_in_the_new_block_does_not_pass_for_a_wrong_reference() -> None:
    """The soak shows 20 K of what was seen over less than 1 K; gains of nothing fit that too."""
    hidden = drawn("temperature_bias", "gyroscope", 5.0, PAPER, 26)
    assert hidden is not None
    settled = settle(PAPER, 26, "gyroscope", [hidden])
    assert settled is not None
    assert settled.block == "soak"
    assert settled.after == ("temperature_bias",)


def test_a_speed_that_saturates_the_gyro_is_not_advised() -> None:
    """33 1/3 rpm is 200 °/s; the paper's gyro ends at 150 °/s."""
    poses = poses_of(PAPER, 1, "gyroscope", hidden_of(["quadratic"], "gyroscope", 10.0, PAPER, 1)
                     or ())
    base = fit(poses, Model.of(BASE))
    wide = diagnose(base, (), np.radians(300.0)).advice
    narrow = diagnose(base, (), np.radians(150.0)).advice
    assert wide is not None
    assert narrow is not None
    assert narrow.block != "speed"


# --- what is in no catalogue -------------------------------------------------------------------


def test_one_bad_pose_is_named_by_its_label() -> None:
    hidden = hidden_of(["bad_pose"], "gyroscope", 10.0, RICH, 3)
    assert hidden is not None
    poses = poses_of(RICH, 3, "gyroscope", hidden)
    found = said_of(poses)
    assert found.verdict == "bad_pose"
    spoilt = int(hidden[0].detail["number"])
    assert found.name == poses.label[_order_in_time(poses)[spoilt]]
    assert found.name in found.text


def _order_in_time(poses: PoseSet) -> list[int]:
    return [int(i) for i in np.argsort(poses.time_s)]


def test_a_bias_that_follows_the_square_of_a_column_is_laid_to_the_column() -> None:
    for column in ("humidity_pct", "supply_v"):
        found = with_hidden(f"column_squared:{column}", 10.0, RICH, 4, "gyroscope")
        assert found.verdict in ("unknown", "effect")
        assert found.name in (column, f"column:{column}")


def test_a_bias_that_follows_a_logged_column_can_be_added_by_its_name() -> None:
    found = with_hidden("column:humidity_pct", 5.0, RICH, 5, "gyroscope")
    assert found.verdict == "effect"
    assert found.name == "column:humidity_pct"
    assert found.addable


def test_an_error_that_no_effect_has_is_unknown_and_points_to_writing_ones_own() -> None:
    found = with_hidden("column_squared:humidity_pct", 10.0, RICH, 6, "gyroscope")
    assert found.verdict == "unknown"
    assert "follows the logged column humidity_pct" in found.text
    assert "write it as your own effect" in found.text


def test_noise_larger_than_stated_is_called_noise() -> None:
    poses = poses_of(RICH, 7, "gyroscope", ())
    found = said_of(replace(poses, sd=poses.sd / 2))
    assert found.verdict == "noise"
    assert "times what the poses' own noise leaves" in found.text


# --- two effects -------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "pair", [("g_sensitivity", "temperature_scale"), ("cubic", "hysteresis"),
             ("temperature_bias", "reference_drift")]
)
def test_two_effects_at_once_are_both_found_by_going_on(pair: tuple[str, str]) -> None:
    hidden = hidden_of(pair, "gyroscope", 5.0, RICH, 8)
    assert hidden is not None
    loop = follow_to_the_end(poses_of(RICH, 8, "gyroscope", hidden))
    found = {*loop.added, *(loop.last.group if loop.last.verdict == "effect" else ())}
    assert set(pair) <= found
    assert chi2.sf(loop.fit.chi2, loop.fit.dof) > 1e-3
