"""Angrisano et al. equation by equation, and the two solvers against each other."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from calib.effects.catalogue import BASE
from calib.effects.effect import EFFECTS
from calib.errors import CalibrationError, FitFailed
from calib.fit.least_squares.angrisano import (
    corrected_vectors,
    data_sheet_start,
    fit_paper,
    iterations_from,
    jacobian,
)
from calib.fit.least_squares.solver import fit
from calib.fit.model import Model
from calib.fit.parameters import TriadParameters, alignment
from calib.fit.rows.residuals import Equations
from calib.fit.triad.calibration import calibrate_triad
from calib.poses.data_sheet import TriadSpec
from calib.poses.pose_set import PoseSet
from tests.fitting import pose_sets
from tests.studies.angrisano.iteration import iterate_as_printed, rms_misclosure
from tests.world.designs import paper_design
from tests.world.session import simulate

FloatArray = NDArray[np.float64]
SPEC = TriadSpec(50.0, 16, "offset-binary")
X = np.array([-0.0135, -0.0036, 0.0005, 33652, 33395, 32034, 1 / 549.7, 1 / 552.7, 1 / 550.4])
COUNTS = np.random.default_rng(1).uniform(28000, 38000, (40, 3))


@pytest.fixture(scope="module")
def accelerometer() -> PoseSet:
    return pose_sets(simulate(paper_design(), 1))[0]


@pytest.fixture(scope="module")
def gyroscope() -> PoseSet:
    return pose_sets(simulate(paper_design(), 1))[1]


def counts_of(poses: PoseSet) -> FloatArray:
    return poses.reading / SPEC.nominal_scale + SPEC.nominal_bias_counts


def test_eq_5_is_eq_1_written_out() -> None:
    (alpha, bias, k) = X.reshape(3, 3)
    parameters = TriadParameters(alpha, bias, 1 / k, np.full((9, 9), np.nan))
    assert corrected_vectors(X, COUNTS) == pytest.approx(parameters.correct(COUNTS), abs=1e-12)
    by_hand = alignment(alpha) @ np.diag(k) @ (COUNTS[0] - bias)
    assert corrected_vectors(X, COUNTS)[0] == pytest.approx(by_hand, abs=1e-12)


@pytest.mark.parametrize("j", range(9))
def test_eq_6_is_the_negative_derivative_of_eq_5(j: int) -> None:
    step = np.zeros(9)
    step[j] = 1e-4 * max(abs(X[j]), 1e-2)
    slope = (corrected_vectors(X + step, COUNTS) - corrected_vectors(X - step, COUNTS)) / 2
    found = jacobian(X, COUNTS)[:, :, j]
    assert found == pytest.approx(-slope / step[j], rel=1e-8, abs=1e-8 * np.abs(found).max())


def test_eq_8_to_10_are_the_square_of_the_linearised_system() -> None:
    """(N - A dX)² = N² - 2 NᵀA dX + O(dX²): what is left over is of second order."""
    direction = np.array([1e-3, -1e-3, 2e-3, 30, -20, 10, 1e-6, -2e-6, 1e-6])
    n, a = corrected_vectors(X, COUNTS), jacobian(X, COUNTS)
    left = []
    for size in (1.0, 0.5):
        moved = corrected_vectors(X + size * direction, COUNTS)
        linear = (n**2).sum(axis=1) - 2 * np.einsum("ni,nij,j->n", n, a, size * direction)
        left.append(np.abs((moved**2).sum(axis=1) - linear).max())
    assert left[0] / left[1] == pytest.approx(4, rel=0.02)


def test_eq_12_starts_from_full_scale_and_bits() -> None:
    start = data_sheet_start(SPEC)
    assert start[:3].tolist() == [0, 0, 0]
    assert start[3:6].tolist() == [32767.5] * 3
    assert start[6:] == pytest.approx([100 / 65535] * 3)


def test_four_to_five_iterations_suffice_from_the_data_sheet(accelerometer: PoseSet) -> None:
    assert fit_paper(accelerometer, Model.of(BASE), SPEC).iterations in (4, 5)


def test_the_printed_sign_of_b_x_makes_the_iteration_diverge(accelerometer: PoseSet) -> None:
    equations, counts = Equations.of(accelerometer, Model.of(BASE)), counts_of(accelerometer)
    right, stopped = iterations_from(data_sheet_start(SPEC), equations, counts)
    magnitude = float(accelerometer.reference.magnitude[0])
    wrong = iterate_as_printed(
        data_sheet_start(SPEC), counts, magnitude, absolute=True, printed_sign=True)
    assert stopped
    assert right[-1].q < 1e-4 * right[0].q
    assert not wrong.stopped
    assert min(wrong.rms[1:]) > 100 * rms_misclosure(right[-1].x, counts, magnitude)


@pytest.mark.parametrize("triad", ["accelerometer", "gyroscope"])
def test_both_solvers_end_at_the_same_minimum(
    triad: str, request: pytest.FixtureRequest
) -> None:
    poses = request.getfixturevalue(triad)
    spec = SPEC if triad == "accelerometer" else TriadSpec(np.radians(150.0), 16, "offset-binary")
    default = calibrate_triad(fit(poses, Model.of(BASE)), spec).parameters
    published = calibrate_triad(fit_paper(poses, Model.of(BASE), spec), spec).parameters
    assert published.misalignment_rad == pytest.approx(default.misalignment_rad, abs=1e-10)
    assert published.bias_counts == pytest.approx(default.bias_counts, rel=1e-10)
    assert published.scale_counts_per_unit == pytest.approx(
        default.scale_counts_per_unit, rel=1e-10
    )
    assert published.cov == pytest.approx(default.cov, rel=1e-7, abs=1e-20)


def test_solver_paper_refuses_a_model_it_does_not_have(accelerometer: PoseSet) -> None:
    with pytest.raises(CalibrationError, match="knows the nine parameters of the paper only"):
        fit_paper(accelerometer, Model.of(BASE) + EFFECTS["quadratic"], SPEC)


def test_a_start_outside_the_interval_is_said_to_be_one(accelerometer: PoseSet) -> None:
    """A full scale stated at a third: k starts 0.001 too small, the interval ends at 0.0006."""
    third = replace(SPEC, full_scale=50.0 / 3)
    far = replace(
        accelerometer, reading=accelerometer.reading / 3, sd=accelerometer.sd / 3
    )
    with pytest.raises(FitFailed, match="outside its convergence interval"):
        fit_paper(far, Model.of(BASE), third)
    assert fit(far, Model.of(BASE)).chi2 == pytest.approx(
        fit(accelerometer, Model.of(BASE)).chi2, rel=1e-6
    )
