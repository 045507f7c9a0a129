"""The accelerometer of the real Xsens MTi, calibrated from its public log."""

import gzip
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from calib.averaging import average_pose
from calib.calibration import TriadCalibration, calibrate_triad
from calib.catalogue import BASE
from calib.imu_log import ImuLog
from calib.model import Model
from calib.poses import pose_set
from calib.runs import gravity_run
from calib.sensor import TriadSpec
from calib.solver import fit
from calib.still import find_still

REAL = Path(__file__).parents[3] / "shared" / "real" / "imu_tk_xsens"
SPEC = TriadSpec(50.0, 16, "offset-binary")
GRAVITY_M_S2 = 9.81744  # of imu_tk's own test program


@cache
def real_accelerometer() -> TriadCalibration:
    """The real Xsens log of imu_tk, whole still windows, gravity as its publishers took it."""
    if not REAL.is_dir():
        pytest.skip("the real Xsens log is not there (../shared/real/imu_tk_xsens)")
    with gzip.open(REAL / "xsens_acc.mat.gz", "rt") as text:
        rows = np.loadtxt(text)
    blank = np.full((len(rows), 3), np.nan)
    stills = find_still(ImuLog("xsens_acc", rows[:, 0], rows[:, 1:], blank))
    means = [average_pose(still, SPEC, None) for still in stills]
    poses = pose_set("accelerometer", [gravity_run("still", means, GRAVITY_M_S2, 0.0)], 0.0)
    return calibrate_triad(fit(poses, Model.of(BASE)), SPEC)
