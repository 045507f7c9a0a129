"""A gyroscope that was only at rest: its bias and what errs at rest, never a scale."""

from dataclasses import replace

import numpy as np
import pytest

from calib.diagnosis.diagnose import diagnose
from calib.errors import Undetermined
from calib.fit.least_squares.angrisano import fit_paper
from calib.fit.least_squares.solver import fit
from calib.fit.model import Model
from calib.fit.triad.calibration import calibrate_triad
from calib.fit.validation.leave_one_out import compare
from calib.poses.pose_set import PoseSet
from pipeline.errors import message_of
from tests.calib.made_poses import SPECS, made_poses, read_through, with_noise

BIAS = np.array([0.02, -0.01, 0.03])


def at_rest(model: Model, theta: np.ndarray, seed: int = 1) -> PoseSet:
    poses = read_through(made_poses("gyroscope", (0.0, 0.0), seed=seed), model, theta)
    return with_noise(poses, np.random.default_rng([seed, 5]))


@pytest.mark.parametrize("names", [("bias", "scale", "misalignment"), ("bias", "scale")])
def test_a_scale_from_rest_is_refused_and_the_model_that_would_do_is_named(
    names: tuple[str, ...],
) -> None:
    poses = at_rest(Model.of(["bias"]), BIAS)
    with pytest.raises(Undetermined, match=r"were taken at rest.*never scale") as caught:
        fit(poses, Model.of(names))
    assert "gyroscope: {model: [bias]}" in message_of(caught.value)
    if len(names) == 3:
        with pytest.raises(Undetermined, match="were taken at rest"):
            fit_paper(poses, Model.of(names), SPECS["gyroscope"])


def test_the_bias_comes_out_with_its_sd_and_the_gains_stay_the_data_sheet_s() -> None:
    scores = []
    for seed in range(30):
        found = fit(at_rest(Model.of(["bias"]), BIAS, seed), Model.of(["bias"]))
        scores.append((found.theta - BIAS) / np.sqrt(np.diag(found.cov)))
    assert np.std(scores) == pytest.approx(1.0, abs=0.2)
    parameters = calibrate_triad(found, SPECS["gyroscope"]).parameters
    assert np.isnan(parameters.sd[2]).all()
    assert parameters.scale_counts_per_unit == pytest.approx(
        1 / SPECS["gyroscope"].nominal_scale
    )


def test_g_sensitivity_at_rest_is_found_beside_the_bias() -> None:
    model = Model.of(["bias", "g_sensitivity"])
    theta = np.concatenate([BIAS, 1e-3 * np.arange(-4.0, 5.0)])
    poses = at_rest(model, theta)
    found = fit(poses, model)
    assert found.theta == pytest.approx(theta, abs=5 * np.sqrt(np.diag(found.cov)).max())
    bare = fit(poses, Model.of(["bias"]))
    assert bare.chi2 / bare.dof > 100
    assert compare(found).loo_rms < compare(bare).loo_rms / 10
    assert diagnose(bare).name == "g_sensitivity"
    assert diagnose(found).verdict == "nothing_missing"


def test_one_turning_pose_more_is_another_question() -> None:
    poses = at_rest(Model.of(["bias"]), BIAS)
    turning = made_poses("gyroscope", (1.0,)).take([0])
    names = dict.fromkeys(turning.run, "turning")
    both = poses.concat(replace(turning, run=tuple(names.values())))
    with pytest.raises(Undetermined, match="do not determine"):
        fit(both, Model.of(["bias", "scale", "misalignment"]))
