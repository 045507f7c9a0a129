"""What is expected in new attitudes: it falls with what is there, not with what fits the poses."""

from dataclasses import replace

import numpy as np
import pytest

from calib.effects.catalogue import BASE
from calib.effects.expression import read_expression
from calib.effects.user_defined import user_effect
from calib.fit.least_squares.solver import fit
from calib.fit.model import Model
from calib.fit.triad.calibration import calibrate_triad
from calib.fit.validation.elsewhere import mean_square_apart, mean_square_error
from calib.fit.validation.leave_one_out import compare
from calib.poses.pose_set import PoseSet
from tests.calib.made_poses import FAST, SD, SLOW, SPECS, made_poses, noisy

MODEL = Model.of(BASE)
LATE = user_effect("late", read_expression("(1 + sign(time_s - 1080)) / 2 * s**3"), "axis", "1",
                   "gyroscope")


def dead_band(seed: int) -> PoseSet:
    """Poses at two rates, one after the other, whose readings lack what is near zero."""
    poses = noisy(made_poses("gyroscope", (SLOW, -SLOW, FAST, -FAST), seed=seed), seed)
    width = 8 * SD["gyroscope"]
    return replace(poses, reading=poses.reading - np.clip(poses.reading, -width, width),
                   time_s=30.0 * np.arange(len(poses)))


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_what_some_poses_determine_and_others_would_get_errs_more_though_poses_left_out_err_less(
    seed: int
) -> None:
    """The cube of the reading from a time on, where the slow poses come before it."""
    poses = dead_band(seed)
    before = fit(poses, Model.of((*BASE, "cubic")))
    after = fit(poses, before.model + LATE)
    assert compare(after).scatter < compare(before).scatter
    assert mean_square_error(after) > mean_square_error(before)


def test_it_falls_with_an_effect_that_is_there_and_with_no_other() -> None:
    fell = 0
    for seed in range(8):
        sound = noisy(made_poses("gyroscope", (SLOW, FAST), seed=seed), seed)
        curved = replace(sound, reading=sound.reading + 4e-4 * sound.reading**2)
        without, with_it = (fit(curved, Model.of((*BASE, *more))) for more in ((), ("quadratic",)))
        assert mean_square_error(with_it) < mean_square_error(without)
        apart = mean_square_apart(*(calibrate_triad(each, SPECS["gyroscope"])
                                    for each in (with_it, without)))
        assert apart > mean_square_error(with_it)
        fell += (mean_square_error(fit(sound, Model.of((*BASE, "quadratic"))))
                 < mean_square_error(fit(sound, MODEL)))
    assert fell <= 2
