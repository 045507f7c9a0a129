"""What is advised next is something that the session has not."""

from dataclasses import replace

import pytest

from calib.diagnosis.diagnose import diagnose
from calib.diagnosis.next_measurement.pose_blocks import TILTED, hypothetical, menu
from calib.effects.catalogue import BASE
from calib.fit.least_squares.solver import fit
from calib.fit.model import Model
from tests.fitting import tilted_pose_sets
from tests.lots import pose_sets_of
from tests.set_trials import design_of
from tests.trials import drawn, poses_of
from tests.world.bench import Design
from tests.world.designs import paper_design, soak_design, tilted_design
from tests.world.imu import mpu6050
from tests.world.lot import LotPlan, draw_lot
from tests.world.session import simulate


@pytest.mark.parametrize(("design", "has_corners"), [
    (soak_design(mpu6050()), True), (paper_design(mpu6050()), False),
])
def test_corners_that_the_session_has_are_not_advised(design: Design, has_corners: bool) -> None:
    poses = pose_sets_of(draw_lot(design, LotPlan(1), 3))[0]
    blocks = {block.code for block in menu(fit(poses, Model.of(BASE)))}
    assert ("corners" in blocks) is not has_corners
    assert "repeat" in blocks


def test_corners_of_a_gyroscope_are_asked_for_on_the_turning_plate() -> None:
    """Its session may have them at rest."""
    plate = poses_of(design_of("rich", 11), 11, "gyroscope", [])
    told = {block.code: block.instruction for block in menu(fit(plate, Model.of(BASE)))}
    assert told["corners"] == "the 8 corner poses on the turning plate"


def test_a_bias_that_follows_the_temperature_late_asks_for_another_soak() -> None:
    design = design_of("rich", 11)
    hidden = drawn("temperature_lag", "gyroscope", 20.0, design, 11)
    assert hidden is not None
    found = diagnose(fit(poses_of(design, 11, "gyroscope", [hidden]), Model.of(BASE)))
    assert (found.verdict, found.name) == ("unknown", "temperature_c")
    assert found.advice is not None
    assert (found.advice.block, found.advice.minutes) == ("soak", 60.0)
    assert found.advice.instruction in found.text


def test_a_steeper_lean_can_be_planned_for_a_plate_that_leans_a_little() -> None:
    """The axes of its poses come from the accelerometer, those of the planned ones from nowhere."""
    _, gyroscope, _ = tilted_pose_sets(
        simulate(replace(tilted_design(3.0), sample_rate_hz=25.0), 41))
    session = fit(gyroscope, Model.of(BASE))
    planned = {block.code: then for block, then in hypothetical(session)}
    assert len(planned[TILTED.code].poses) > len(gyroscope)
    ring = planned[TILTED.code].poses.ring
    assert ring is not None
    assert ring.axis_moved.shape == (len(ring.place), 3, 9)
