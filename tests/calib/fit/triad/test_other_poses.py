"""The accelerometer in the poses of the gyroscope: effects of the past are known there too."""

from dataclasses import replace

import numpy as np
import pytest

from calib.effects.expression import read_expression
from calib.effects.user_defined import user_effect
from calib.fit.least_squares.solver import fit
from calib.fit.triad.calibration import TriadCalibration, calibrate_triad
from calib.fit.triad.other_poses import correct_other_poses, missing_in, with_typical_columns
from calib.poses.past import with_pasts
from calib.poses.pose_set import PoseSet
from tests.calib.made_poses import MODEL, SPECS, made_poses, noisy

LATE = user_effect(
    "late", read_expression("lag(temperature_c, 300)"), "axis", "{u}/K", "accelerometer")


def calibrated(poses: PoseSet) -> TriadCalibration:
    whole = with_pasts(poses, LATE.pasts)
    return calibrate_triad(fit(whole, MODEL + LATE), SPECS["accelerometer"])


def test_a_lag_is_evaluated_in_other_poses_by_the_whole_session() -> None:
    at_rest = noisy(made_poses("accelerometer", (0.0, 0.0)), 1)
    calibration = calibrated(at_rest)
    later = replace(at_rest, time_s=at_rest.time_s + np.ptp(at_rest.time_s) + 60.0)
    beside = replace(later, triad="gyroscope", force=later.reading)
    assert missing_in(calibration, beside) == {}
    whole = with_pasts(at_rest, LATE.pasts).columns
    known = with_typical_columns(calibration, beside).columns
    name, = LATE.pasts
    assert known[name.name][np.argmin(later.time_s)] == pytest.approx(
        whole[name.name][np.argmax(at_rest.time_s)], abs=2.0)
    without = replace(beside, columns={})
    assert [*missing_in(calibration, without)] == ["late"]
    assert missing_in(calibration, with_typical_columns(calibration, without)) == {}
    force = correct_other_poses(calibration)(beside.accelerometer_conditions(beside.force))
    assert np.linalg.norm(force, axis=1) == pytest.approx(9.80665, abs=0.1)
