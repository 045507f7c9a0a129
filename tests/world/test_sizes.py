"""Drawn effects have the strength that was asked for."""

import numpy as np
import pytest

from tests.world.designs import paper_design, rich_design, soak_design
from tests.world.hidden import EFFECTS, GYROSCOPE_ONLY, Hidden
from tests.world.sizes import draw_effect, pose_equations, strength

QUICK = rich_design().scaled(sample_rate=0.1)
GYROSCOPE_ROWS = sorted(set(EFFECTS) - {"lever_arm"})
ACCELEROMETER_ROWS = sorted(
    set(EFFECTS) - GYROSCOPE_ONLY - {"lever_arm", "vibration_rectification"}
)


def with_column(name: str) -> str:
    return f"{name}:humidity_pct" if name.startswith("column") else name


@pytest.mark.parametrize("name", GYROSCOPE_ROWS)
def test_a_drawn_gyroscope_effect_has_the_wanted_strength(name: str) -> None:
    effect = draw_effect(with_column(name), "gyroscope", 5.0, QUICK, seed=3)
    assert strength(QUICK, 3, effect) == pytest.approx(5.0, rel=5e-3)


@pytest.mark.parametrize("name", ACCELEROMETER_ROWS)
def test_a_drawn_accelerometer_effect_has_the_wanted_strength(name: str) -> None:
    design = soak_design().scaled(sample_rate=0.1)
    effect = draw_effect(with_column(name), "accelerometer", 5.0, design, seed=4)
    assert strength(design, 4, effect) == pytest.approx(5.0, rel=5e-3)


@pytest.mark.parametrize("seed", range(8))
@pytest.mark.parametrize("name", ["jump", "bad_pose"])
def test_a_moment_or_a_pose_is_drawn_where_the_triad_is_calibrated(name: str, seed: int) -> None:
    effect = draw_effect(name, "accelerometer", 10.0, QUICK, seed)
    assert strength(QUICK, seed, effect) == pytest.approx(10.0, rel=5e-3)


def test_the_strength_of_a_bias_is_what_a_pencil_gives() -> None:
    """A bias b along x adds b n_x to a magnitude and b to one of three components at rest."""
    design = rich_design().scaled(sample_rate=0.1)
    part = design.sensor.gyroscope
    sd_turning = part.pose_mean_sd(200, 0.1)[0]
    sd_still = part.pose_mean_sd(80, 0.1)[0]
    rows = 4 * 18 * (1e-3 / sd_turning) ** 2 / 3 + 18 * (1e-3 / sd_still) ** 2
    expected = np.sqrt(rows / (4 * 18 + 3 * 18))
    effect = Hidden("bias", "gyroscope", np.array([1e-3, 0.0, 0.0]))
    assert strength(design, 5, effect) == pytest.approx(expected, rel=0.03)


def test_there_are_126_rows_in_the_rich_design_and_18_in_the_papers() -> None:
    assert len(pose_equations(rich_design(), 1, "gyroscope")) == 126
    assert len(pose_equations(paper_design(), 1, "gyroscope")) == 18
    assert len(pose_equations(soak_design(), 1, "accelerometer")) == 78


def test_what_cannot_be_drawn_is_refused() -> None:
    with pytest.raises(ValueError, match="g_sensitivity acts on gyroscopes"):
        draw_effect("g_sensitivity", "accelerometer", 5.0, QUICK, 1)
    with pytest.raises(ValueError, match="does not reach the pose equations"):
        draw_effect("vibration_rectification", "accelerometer", 5.0, QUICK, 1)
    with pytest.raises(ValueError, match=r"size of shape \(3,\)"):
        Hidden("bias", "gyroscope", np.array(0.1))
