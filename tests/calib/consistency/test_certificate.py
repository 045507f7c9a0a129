"""A certificate beside an estimate: what a frame hides is left out, what differs is seen."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from calib.consistency.certificate import (
    FactoryCertificate,
    compare_certificate,
    frame_free,
    rounding_sd,
)
from calib.errors import CalibrationError
from calib.fit.parameters import TriadParameters
from calib.poses.data_sheet import TriadSpec
from tests.calib.real_xsens import real_accelerometer
from tests.world.imu import mti
from tests.world.truth import parameters

FloatArray = NDArray[np.float64]
SPEC = TriadSpec(50.0, 16, "offset-binary")

# Printed for this very unit and log by calibrate.m of imu_tk_matlab, see the README of the data.
XSENS = FactoryCertificate(
    bias_counts=np.array([33123.0, 33276.0, 32360.0]),
    scale_counts_per_unit=np.array([415.0, 413.0, 415.0]),
    alignment=np.array([[1.0, 0.0, -0.01], [0.01, 1.0, 0.01], [0.02, 0.01, 1.0]]),
)


def estimate(alpha: FloatArray, bias: FloatArray, scale: FloatArray) -> TriadParameters:
    sd = np.repeat([3e-4, 0.6, 0.08], 3)  # one arc minute, as the publication states them
    return TriadParameters(alpha, bias, scale, np.diag(sd**2))


def test_any_frame_of_the_certificate_gives_the_same_comparison() -> None:
    """The world's truth for a leaning triad, its certificate turned at random."""
    triad = mti().accelerometer
    truth = parameters(triad)
    for seed in range(5):
        turn = Rotation.random(random_state=seed).as_matrix()
        k, alpha = frame_free(triad.gain, triad.axes @ turn)
        assert k == pytest.approx(truth.scale_counts_per_unit, rel=1e-12)
        assert alpha == pytest.approx(truth.misalignment_rad, abs=1e-14)


def test_an_estimate_equal_to_its_certificate_differs_by_nothing() -> None:
    triad = mti().accelerometer
    truth = parameters(triad)
    case = Rotation.from_rotvec([0.02, -0.01, 0.03]).as_matrix()
    certificate = FactoryCertificate(triad.offset, triad.gain, alignment=triad.axes @ case)
    exact = estimate(truth.misalignment_rad, truth.bias_counts, truth.scale_counts_per_unit)
    for group in compare_certificate(exact, certificate, SPEC).values():
        assert group.sigma == pytest.approx(np.zeros(3), abs=1e-6)
        assert group.per_cent == pytest.approx(np.zeros(3), abs=1e-9)


def test_comparing_alignment_matrices_as_they_stand_would_see_the_frame_as_an_error() -> None:
    triad = mti().accelerometer
    case = Rotation.from_rotvec([0.02, -0.01, 0.03]).as_matrix()
    naive = np.linalg.inv(triad.axes @ case)
    truth = parameters(triad).misalignment_rad
    assert np.abs([naive[1, 2], naive[0, 2], naive[0, 1]] - truth).max() > 0.01


def test_the_publications_first_set_stands_against_its_certificate_as_printed() -> None:
    """Angrisano et al. Tab. 1: 42, 13 and 29 counts, -2.1, 0.1 and 0.2 counts per m/s²."""
    published = estimate(
        np.array([-0.0135, -0.0036, 0.0005]),
        np.array([33610.0, 33382.0, 32063.0]),
        np.array([547.6, 552.8, 550.6]),
    )
    certificate = FactoryCertificate(
        np.array([33652.0, 33395, 32034]), np.array([549.7, 552.7, 550.4])
    )
    found = compare_certificate(published, certificate, SPEC)
    assert "misalignment" not in found  # the certificate prints none
    assert found["bias"].difference == pytest.approx([-42, -13, 29])
    assert found["scale"].per_cent == pytest.approx([-0.382, 0.018, 0.036], abs=5e-4)
    # 42 counts are 63 of the stated sds: the publication's "comparable" is not its own sd's word.
    assert found["bias"].sigma == pytest.approx([-63, -19.5, 43.5], rel=0.01)
    assert found["bias"].per_cent == pytest.approx(100 * found["bias"].difference / 32767.5)


def test_the_rounding_of_the_certificate_counts_as_its_uncertainty() -> None:
    assert rounding_sd(np.array([33123.0, 33276.0])) == pytest.approx(1 / np.sqrt(12))
    assert rounding_sd(np.array([1.0, -0.01])) == pytest.approx(0.01 / np.sqrt(12))
    exact = estimate(np.zeros(3), XSENS.bias_counts, XSENS.scale_counts_per_unit)
    group = compare_certificate(exact, XSENS, SPEC)["misalignment"]
    # Two elements of the matrix, each ±0.005, make one of the triangle.
    of_two = np.sqrt(2) * 0.01 / np.sqrt(12)
    assert group.certificate_sd == pytest.approx(np.full(3, of_two), rel=0.05)


def test_alpha_of_eq_2_may_be_stated_instead_of_a_matrix() -> None:
    alpha = np.array([-0.0135, -0.0036, 0.0005])
    found = compare_certificate(
        estimate(alpha + 0.001, XSENS.bias_counts, XSENS.scale_counts_per_unit),
        replace(XSENS, alignment=None, misalignment_rad=alpha),
        SPEC,
    )
    assert found["misalignment"].difference == pytest.approx([0.001] * 3)
    assert found["misalignment"].per_cent == pytest.approx([0.1] * 3)


def test_logs_in_physical_units_have_no_range_to_relate_a_bias_to() -> None:
    exact = estimate(np.zeros(3), XSENS.bias_counts, XSENS.scale_counts_per_unit)
    found = compare_certificate(exact, XSENS, TriadSpec(np.inf, 0, "si"))
    assert np.isnan(found["bias"].per_cent).all()


def test_certificates_that_cannot_be_meant_are_refused() -> None:
    with pytest.raises(CalibrationError, match="gains are positive"):
        replace(XSENS, scale_counts_per_unit=np.array([415.0, -413.0, 415.0]))
    with pytest.raises(CalibrationError, match="row by row, without the gains"):
        replace(XSENS, alignment=415 * np.eye(3))
    with pytest.raises(CalibrationError, match="both given"):
        replace(XSENS, misalignment_rad=np.zeros(3))


def test_the_real_xsens_agrees_with_its_factory_in_bias_and_alignment_not_in_scale() -> None:
    found = compare_certificate(real_accelerometer().parameters, XSENS, SPEC)
    # The frame-free triangle of the factory's matrix (x, y, z), good to its two decimals.
    assert found["misalignment"].certificate == pytest.approx([-0.0202, -0.0098, -0.0097], abs=5e-5)
    assert (np.abs(found["misalignment"].sigma) < 2).all()
    # Offsets drift with the years: 1, -1 and 4 counts, the last 11 mm/s² and 13 sds.
    assert found["bias"].difference == pytest.approx([1.0, -0.8, 4.4], abs=0.3)
    assert found["bias"].sigma[2] > 8
    # Gains are printed to a whole count per m/s², 0.07 %; y differs by three times that.
    assert found["scale"].certificate_sd == pytest.approx([0.29] * 3, abs=0.01)
    assert found["scale"].per_cent == pytest.approx([-0.131, -0.223, -0.121], abs=0.02)
