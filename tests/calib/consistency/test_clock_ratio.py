"""The clock of a sensor's log against that of the clip: gravity goes round on a leaning plate."""

from dataclasses import replace

import numpy as np
import pytest

from calib.consistency.clock_ratio import ClockRatio, clock_ratio
from calib.poses.imu_log import ImuLog
from tests.fitting import spec_of
from tests.world.bench import Design
from tests.world.designs import paper_design
from tests.world.session import simulate

FAST = 5e-4  #: of the clock of the simulated logs


def ratio(
    design: Design, seed: int, fast: float = FAST, rate_sd: float = 1e-4, filmed: bool = True
) -> ClockRatio | None:
    """The ratio of the two clocks in the turning run of a simulated evening."""
    session = simulate(design, seed)
    (run,) = (each for each in session.runs if each.run.motion is not None)
    logs = [ImuLog(pose.label, pose.time_s * (1 + fast), pose.accelerometer.astype(float),
                   pose.gyroscope.astype(float), {}) for pose in run.poses]
    rate = abs(session.rates[run.run.name].true_rad_s)
    return clock_ratio(logs, np.full(len(logs), rate), spec_of(design.sensor.accelerometer, 50.0),
                       rate_sd, filmed)


def test_a_clock_that_is_off_is_found_with_an_honest_sd() -> None:
    """18 poses of 20 s at 16 2/3 rpm on a plate that leans by 0.4°."""
    found = [ratio(paper_design(), seed) for seed in range(12)]
    assert all(each is not None for each in found)
    score = [(each.difference - (1 / (1 + FAST) - 1)) / each.sd for each in found if each]
    assert np.median([each.sd for each in found if each]) < 400e-6
    assert 0.4 < np.sqrt(np.mean(np.square(score))) < 1.6
    assert not any(each.contradicts for each in found if each)


def test_a_clock_of_a_per_cent_contradicts() -> None:
    found = ratio(paper_design(), 1, fast=0.01)
    assert found is not None
    assert found.contradicts
    assert "the plate turned 1.00 ± 0.03 % slower" in found.warning("rate.slow")


@pytest.mark.parametrize("fast", [-0.08, 0.03])
def test_a_rate_that_is_stated_wrongly_contradicts_unless_its_sd_allows_it(fast: float) -> None:
    wrong = ratio(paper_design(), 2, fast, rate_sd=1e-3, filmed=False)
    assert wrong is not None
    assert wrong.difference == pytest.approx(1 / (1 + fast) - 1, abs=5 * wrong.sd)
    assert wrong.contradicts
    assert "than stated" in wrong.warning("rate.slow")
    rough = ratio(paper_design(), 2, fast, rate_sd=0.02, filmed=False)
    assert rough is not None
    assert not rough.contradicts


def test_a_level_plate_says_nothing() -> None:
    design = paper_design()
    level = replace(design, turntable=replace(design.turntable, tilt_rad=(1e-5, 0.0)))
    assert ratio(level, 2) is None
