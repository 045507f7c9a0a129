"""A session whose logger truncates readings toward zero."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tests.sessions import run_without_page
from tests.world.designs import paper_design
from tests.world.imu import mpu6050
from tests.world.session import simulate
from tests.world.truth import parameters
from tests.world.write import write_session


@pytest.mark.parametrize("truncates", [True, False])
def test_truncated_readings_are_told_and_leave_the_gains_right(
    tmp_path: Path, truncates: bool
) -> None:
    """Half a step of 16 counts is 0.05 % of gravity; the gains were 3 to 4 sds off."""
    sensor = mpu6050()
    coarse = replace(sensor.accelerometer, step_counts=16, truncates=truncates)
    design = paper_design(replace(sensor, accelerometer=coarse)).scaled(seconds=0.5)
    config = write_session(tmp_path, simulate(design, 900), film=False).config
    results = run_without_page(config)
    fit = results["accelerometer"]
    truth = parameters(coarse).scale_counts_per_unit
    off = np.array(fit["parameters"]["scale_counts_per_unit"]) - truth
    assert (np.abs(off) < 3 * np.array(fit["sd"]["scale_counts_per_unit"])).all()
    told = any("truncated toward zero" in note for note in results["warnings"])
    assert told == truncates
