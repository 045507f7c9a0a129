"""The stated chance of a name comes true: where poses are recorded as advised, so often one is."""

import re

import numpy as np
import pytest

from calib.diagnosis.diagnose import Diagnosis, diagnose
from calib.diagnosis.next_measurement.chance import Rival, chance_of_a_name
from calib.diagnosis.next_measurement.pose_blocks import hypothetical
from calib.effects.catalogue import BASE
from calib.effects.effect import EFFECTS
from calib.fit.least_squares.result import Fit
from calib.fit.least_squares.solver import fit
from calib.fit.model import Model
from tests.calib.made_poses import base_theta, made_poses, read_through, with_noise

SIZE = np.array([1.0, -0.7, 0.5])
SESSIONS = 12


def diagnosed(size: float, seed: int, passes: int = 1) -> tuple[Fit, Diagnosis]:
    """An accelerometer with a quadratic error in 18 poses, laid so many times."""
    model = Model.of((*BASE, "quadratic"))
    theta = base_theta(model, "accelerometer")
    theta[model.slices()["quadratic"]] = size * SIZE
    poses = made_poses("accelerometer", (0.0,) * passes, seed=seed, jitter_deg=0.5)
    read = with_noise(read_through(poses, model, theta), np.random.default_rng([seed, 5]))
    base = fit(read, Model.of(BASE))
    return base, diagnose(base)


@pytest.mark.parametrize("size", [1e-3, 4e-3, 6e-3])
def test_so_often_as_stated_a_name_comes_of_the_poses_once_more(size: float) -> None:
    base, said = diagnosed(size, 1)
    sizes = {one.name: one.size for one in said.ranking if one.kind == "listed"}
    sizes["quadratic"] = size * SIZE
    (then,) = (then for block, then in hypothetical(base) if block.code == "repeat")
    rivals = [Rival(EFFECTS[name], sizes[name]) for name in ("quadratic", "asymmetry")]
    chance = chance_of_a_name(then, rivals)
    assert chance is not None
    named = [diagnosed(size, 100 + seed, 2)[1].group == ("quadratic",) for seed in range(SESSIONS)]
    sd = np.sqrt(max(chance * (1 - chance), 0.04) / SESSIONS)
    assert abs(np.mean(named) - chance) < 3 * sd


def test_what_no_block_settles_is_said_and_the_effect_stands_for_its_class() -> None:
    _, said = diagnosed(3e-4, 1)
    assert said.verdict == "effect"
    assert "Nothing more can be known of it from this sensor on this bench" in said.text
    assert said.explanation.step == "add"
    assert said.record_next is None
    _, strong = diagnosed(4e-3, 1)
    assert re.search(r"Record next: the 8 corner poses \(5 min, after which (100|9\d) % of",
                     strong.text)
    assert strong.explanation.step == "record"
