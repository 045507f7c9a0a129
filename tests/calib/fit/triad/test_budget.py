"""The parts of an sd: they add up, and each is what its cause does to the parameters."""

from dataclasses import replace

import numpy as np
import pytest

from calib.effects.catalogue import BASE
from calib.fit.least_squares.solver import fit
from calib.fit.model import Model
from calib.fit.triad.calibration import NOISE, TriadCalibration, calibrate_triad, uncertainty_budget
from calib.poses.pose_set import pose_set
from calib.poses.runs.reference_runs import GRAVITY, gravity_run
from tests.fitting import averaged, calibrated, spec_of
from tests.world.designs import paper_design, rich_design
from tests.world.session import simulate

SD_M_S2 = 5e-3


@pytest.fixture(scope="module")
def accelerometer() -> TriadCalibration:
    """Poses under a gravity that is known to 5 mm/s²."""
    session = simulate(paper_design().scaled(seconds=0.3), 1)
    sensor, g = session.design.sensor, session.design.site.gravity_m_s2
    specs = (
        spec_of(sensor.accelerometer, sensor.accelerometer.full_scale),
        spec_of(sensor.gyroscope, sensor.gyroscope.full_scale),
    )
    means = averaged(session.runs[0], specs, 0.0)
    poses = pose_set("accelerometer", [gravity_run("stopped", means, g, SD_M_S2)], 0.0)
    return calibrate_triad(fit(poses, Model.of(BASE)), specs[0])


@pytest.fixture(scope="module")
def gyroscope() -> TriadCalibration:
    design = rich_design().scaled(seconds=0.3, sample_rate=0.5)
    session = simulate(replace(design, rate_sd_relative=50e-6, clock_sd_relative=0.0), 2)
    return calibrated(session).gyroscope


@pytest.mark.parametrize("triad", ["accelerometer", "gyroscope"])
def test_the_parts_add_up_to_the_whole(triad: str, request: pytest.FixtureRequest) -> None:
    calibration: TriadCalibration = request.getfixturevalue(triad)
    parts = uncertainty_budget(calibration)
    assert len(parts) > 1
    variance = sum(sd**2 for sd in parts.values())
    assert variance == pytest.approx(np.array(calibration.parameters.sd) ** 2, rel=1e-9)


def test_an_error_of_gravity_is_an_error_of_the_scale_and_of_nothing_else(
    accelerometer: TriadCalibration,
) -> None:
    by_gravity = uncertainty_budget(accelerometer)[GRAVITY]
    misalignment_sd, bias_sd, scale_sd = by_gravity
    relative = SD_M_S2 / accelerometer.fit.poses.reference.magnitude[0]
    expected = accelerometer.parameters.scale_counts_per_unit * relative
    assert scale_sd == pytest.approx(expected, rel=1e-3)
    assert (misalignment_sd < 1e-3 * accelerometer.parameters.sd[0]).all()
    assert (bias_sd < 1e-3 * accelerometer.parameters.sd[1]).all()


def test_an_error_that_is_known_to_be_none_has_no_part(gyroscope: TriadCalibration) -> None:
    parts = uncertainty_budget(gyroscope)
    assert NOISE in parts
    assert {name for name in parts if name.startswith("rate ")} == {
        "rate 17rpm", "rate m17rpm", "rate 33rpm", "rate m33rpm",
    }
    assert "time base of the camera" not in parts  # the rates were stated without one
