"""The paper's parameters and back, and calibrations put to work."""

from dataclasses import replace

import numpy as np
import pytest

from calib.effects.catalogue import BASE, find_effect
from calib.effects.effect import EFFECTS
from calib.errors import CalibrationError
from calib.fit.least_squares.result import MISFIT_P_VALUE
from calib.fit.least_squares.solver import fit
from calib.fit.model import Model
from calib.fit.parameters import alignment, theta_of, triad_parameters
from calib.fit.triad.calibration import calibrate_triad
from calib.poses.attitudes import direction_name, list_directions, natural_directions, uncovered
from calib.poses.data_sheet import TriadSpec
from pipeline.errors import message_of
from tests.calib.made_poses import (
    MODEL,
    SLOW,
    SPECS,
    base_theta,
    made_poses,
    noisy,
    read_through,
    rich_poses,
    with_noise,
)


@pytest.mark.parametrize("encoding", ["offset-binary", "twos-complement"])
def test_theta_and_the_papers_parameters_are_one_to_one(encoding: str) -> None:
    spec = TriadSpec(8.0, 16, encoding)  # type: ignore[arg-type]
    theta = base_theta(MODEL, "gyroscope")
    parameters = triad_parameters(MODEL, theta, np.eye(9), spec)
    assert theta_of(parameters, spec) == pytest.approx(theta, abs=1e-14)


def test_what_is_not_fitted_is_no_minus_zero() -> None:
    p = triad_parameters(Model.of(("bias", "scale")), np.full(6, 1e-3), np.eye(6),
                         TriadSpec(8.0, 16, "twos-complement"))
    assert not np.signbit(p.misalignment_rad).any()


def test_correcting_counts_by_the_paper_is_correcting_by_the_fit() -> None:
    spec = SPECS["gyroscope"]
    poses = noisy(made_poses("gyroscope", (SLOW,)), 1)
    found = calibrate_triad(fit(poses, MODEL), spec)
    counts = poses.reading / spec.nominal_scale + spec.nominal_bias_counts
    by_paper = found.parameters.correct(counts)
    assert by_paper == pytest.approx(found.fit.rows.vector, abs=1e-12)
    assert found.correct(poses.conditions(poses.reading)) == pytest.approx(by_paper, abs=1e-12)


def test_the_sds_of_the_paper_are_those_of_random_draws() -> None:
    spec = SPECS["gyroscope"]
    rng = np.random.default_rng(2)
    theta = base_theta(MODEL, "gyroscope")
    a = 1e-4 * rng.standard_normal((9, 9))
    cov = a @ a.T
    stated = np.concatenate(triad_parameters(MODEL, theta, cov, spec).sd)
    draws = rng.multivariate_normal(theta, cov, 4000)
    values = []
    for each in draws:
        p = triad_parameters(MODEL, each, cov, spec)
        values.append(np.concatenate([p.misalignment_rad, p.bias_counts,
                                      p.scale_counts_per_unit]))
    assert stated == pytest.approx(np.std(values, axis=0), rel=0.05)


def test_the_alignment_matrix_is_eq_2() -> None:
    expected = [[1, 0.3, 0.2], [0, 1, 0.1], [0, 0, 1]]
    assert alignment(np.array([0.1, 0.2, 0.3])) == pytest.approx(np.array(expected))


def test_a_correction_with_effects_undoes_them_on_other_readings() -> None:
    model = Model.of((*BASE, "quadratic", "temperature_bias"))
    theta = base_theta(model, "gyroscope")
    theta[9:] = 3e-3, -2e-3, 1e-3, 2e-4, -1e-4, 3e-4
    found = fit(read_through(rich_poses("gyroscope", 1), model, theta), model)
    calibration = calibrate_triad(found, SPECS["gyroscope"])
    other = rich_poses("gyroscope", 2)
    read = read_through(other, model, theta)
    corrected = calibration.correct(other.conditions(read.reading))
    turning = ~other.reference.is_null  # at rest the effect is held at what should be read
    assert corrected[turning] == pytest.approx(other.reading[turning], abs=1e-9)


def test_sds_are_by_the_variance_to_expect_of_the_noise() -> None:
    """Judged by the stated sds and by the residual, in the end by the residual alone."""
    poses = noisy(made_poses("gyroscope", (SLOW, SLOW)), 3)
    right = calibrate_triad(fit(poses, MODEL), SPECS["gyroscope"])
    assert right.widening == pytest.approx(1.0, abs=0.1)
    small = fit(replace(poses, sd=poses.sd / 4), MODEL)
    wide = calibrate_triad(small, SPECS["gyroscope"])
    assert small.p_value < MISFIT_P_VALUE
    assert wide.widening == pytest.approx(np.sqrt(small.chi2 / small.dof), rel=1e-3)
    assert np.concatenate(wide.parameters.sd) == pytest.approx(
        np.concatenate(right.parameters.sd) * wide.widening / right.widening / 4, rel=1e-6
    )


def test_effect_values_list_the_shape_last() -> None:
    model = Model.of((*BASE, "warm_up"))
    theta = base_theta(model, "gyroscope")
    theta[9:] = 5e-3, 4e-3, -3e-3
    read = read_through(rich_poses("gyroscope"), model, theta, {"warm_up": 700.0})
    found = fit(with_noise(read, np.random.default_rng(1)), model)
    value, sd = calibrate_triad(found, SPECS["gyroscope"]).effect_values()["warm_up"]
    assert len(value) == 4
    assert abs(value[3] - 700.0) < 5 * sd[3]


# --- models ------------------------------------------------------------------------------------


def test_a_model_is_a_sum_that_can_be_taken_apart() -> None:
    more = MODEL + EFFECTS["cubic"]
    assert more.names == (*BASE, "cubic")
    assert (more.size, MODEL.size) == (12, 9)
    assert (more - "cubic").names == BASE
    assert more.slices()["cubic"] == slice(9, 12)
    with pytest.raises(CalibrationError, match="'cubic' is already in the model"):
        more + EFFECTS["cubic"]


def test_an_unknown_effect_is_answered_with_the_catalogue() -> None:
    with pytest.raises(CalibrationError, match=r"no effect is named 'cubc'") as caught:
        find_effect("cubc")
    assert message_of(caught.value).endswith("'cubc' (did you mean 'cubic'?)")
    with pytest.raises(CalibrationError, match="no effect is named 'column:'; there are: bias, "):
        find_effect("column:")


# --- directions in words -----------------------------------------------------------------------


def test_directions_are_named_as_one_would_lay_the_sensor() -> None:
    assert direction_name(np.array([0, 0, -1.0])) == "-z up"
    assert direction_name(np.array([1, 0, -1]) / np.sqrt(2)) == "edge +x -z up"
    assert direction_name(np.array([1, -1, 1]) / np.sqrt(3)) == "corner +x -y +z up"


def test_the_26_directions_are_6_faces_12_edges_8_corners() -> None:
    natural = natural_directions()
    assert natural.shape == (26, 3)
    assert np.linalg.norm(natural, axis=1) == pytest.approx(1.0)
    count = (np.abs(natural) > 0.1).sum(axis=1)
    assert np.bincount(count).tolist() == [0, 6, 12, 8]
    assert natural_directions(corners=False).shape == (18, 3)


def test_what_no_pose_is_near_is_uncovered() -> None:
    natural = natural_directions(corners=False)
    kept = 9.8 * np.delete(natural, [2, 11], axis=0)
    missing = uncovered(kept, natural)
    assert missing == pytest.approx(natural[[2, 11]])
    assert list_directions(missing) == ", ".join(map(direction_name, missing))
    assert len(uncovered(natural, natural)) == 0
    assert uncovered(np.zeros((0, 3)), natural[:4]) == pytest.approx(natural[:4])
    assert list_directions(natural, most=3).endswith("and 15 more")
