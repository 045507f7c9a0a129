"""The accelerometer of the real Xsens MTi, calibrated from its public log."""

import gzip
from functools import cache

import numpy as np
import pytest

from calib.effects.catalogue import BASE
from calib.fit.least_squares.solver import fit
from calib.fit.model import Model
from calib.fit.triad.calibration import TriadCalibration, calibrate_triad
from calib.poses.averaging.average_pose import average_pose
from calib.poses.data_sheet import TriadSpec
from calib.poses.imu_log import ImuLog
from calib.poses.pose_set import pose_set
from calib.poses.rests.static_intervals import find_still
from calib.poses.runs.reference_runs import gravity_run
from tests.paths import REAL

XSENS = REAL / "imu_tk_xsens"
SPEC = TriadSpec(50.0, 16, "offset-binary")
GRAVITY_M_S2 = 9.81744  # of imu_tk's own test program


@cache
def real_accelerometer() -> TriadCalibration:
    """The real Xsens log of imu_tk, whole still windows, gravity as its publishers took it."""
    if not XSENS.is_dir():
        pytest.skip("the real Xsens log is not there (../shared/real/imu_tk_xsens)")
    with gzip.open(XSENS / "xsens_acc.mat.gz", "rt") as text:
        rows = np.loadtxt(text)
    blank = np.full((len(rows), 3), np.nan)
    specs = {"accelerometer": SPEC}
    stills = find_still(ImuLog("xsens_acc", rows[:, 0], rows[:, 1:], blank), specs).logs
    means = [average_pose(still, specs) for still in stills]
    poses = pose_set("accelerometer", [gravity_run("still", means, GRAVITY_M_S2, 0.0)], 0.0)
    return calibrate_triad(fit(poses, Model.of(BASE)), SPEC)
