"""What is advised next is something that the session has not."""

import pytest

from calib.diagnosis.next_measurement.pose_blocks import menu
from calib.effects.catalogue import BASE
from calib.fit.least_squares.solver import fit
from calib.fit.model import Model
from tests.lots import pose_sets_of
from tests.world.bench import Design
from tests.world.designs import paper_design, soak_design
from tests.world.imu import mpu6050
from tests.world.lot import LotPlan, draw_lot


@pytest.mark.parametrize(("design", "has_corners"), [
    (soak_design(mpu6050()), True), (paper_design(mpu6050()), False),
])
def test_corners_that_the_session_has_are_not_advised(design: Design, has_corners: bool) -> None:
    poses = pose_sets_of(draw_lot(design, LotPlan(1), 3))[0]
    blocks = {block.code for block in menu(fit(poses, Model.of(BASE)))}
    assert ("corners" in blocks) is not has_corners
    assert "repeat" in blocks
