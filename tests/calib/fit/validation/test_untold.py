"""What no other log tells of a model is part of the error to expect."""

from dataclasses import replace

import numpy as np
import pytest

from calib.assess import assess
from calib.effects.catalogue import find_effect
from tests.calib.made_poses import MODEL, SPECS, noisy, rich_poses


@pytest.mark.parametrize("name", ["hysteresis", "bias_drift"])
def test_what_a_log_is_not_told_is_expected_at_its_size_in_the_session(name: str) -> None:
    poses = noisy(rich_poses("accelerometer"), 3)
    at = poses.conditions(poses.reading)
    effect = find_effect(name)
    theta = 30 * poses.sd[0, 0] * np.array([1.0, -0.7, 0.5])
    if name == "bias_drift":
        theta *= 3600 / np.ptp(poses.time_s)
    poses = replace(poses, reading=poses.reading + effect.evaluate(at) @ theta)
    prediction = assess(poses, MODEL + effect, SPECS["accelerometer"]).prediction
    assert prediction is not None
    in_a_log = at.as_in_a_log(float(poses.time_s.max()))
    left = (effect.evaluate(at) - effect.evaluate(in_a_log)) @ theta
    along_any = np.sqrt((left**2).sum(axis=1).mean() / 3)
    assert prediction.by_untold[name] == pytest.approx(along_any, rel=0.15)
    assert prediction.sd_median > 0.7 * along_any


def test_a_step_has_its_last_level_and_no_such_error() -> None:
    poses = noisy(rich_poses("accelerometer"), 3)
    step = find_effect("bias_step")
    half = step.from_shape(float(np.median(poses.time_s)) + 0.1)
    jump = 30 * poses.sd[0, 0] * np.array([1.0, -0.7, 0.5])
    at = poses.conditions(poses.reading)
    poses = replace(poses, reading=poses.reading + half.evaluate(at) @ jump)
    prediction = assess(poses, MODEL + step, SPECS["accelerometer"]).prediction
    assert prediction is not None
    assert not prediction.by_untold
