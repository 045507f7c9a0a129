"""The accelerometer's poses where the tilt of a plate must be fitted first."""

from calib.effects.catalogue import BASE
from calib.errors import CalibrationError
from calib.fit.least_squares.solver import fit
from calib.fit.model import Model
from calib.fit.triad.leaning import leaning_of
from pipeline.config.load import Config
from pipeline.stages.poses import Recordings
from pipeline.stages.site import Gravity
from pipeline.stages.triad_poses import TriadPoses, accelerometer_poses

TILT_ROUNDS = 2
"""Derived: the first leaves the square of what the nominal accelerometer errs by, a few 1e-4 of a
radian, and the second its fourth power."""


def leaning_poses(config: Config, recordings: Recordings, gravity: Gravity) -> TriadPoses:
    """The accelerometer's poses, those of plates that lean by the tilt that their fit gives.

    Raises
    ------
    Undetermined
        A plate does not lean enough to show the accelerometer's parameters.
    """
    poses = accelerometer_poses(config, recordings, gravity)
    for _ in range(TILT_ROUNDS):
        if poses.used.ring is None:
            break
        try:
            leaning = leaning_of(fit(poses.used, Model.of(BASE)))
        except CalibrationError:  # is said where the model of the configuration is fitted
            break
        poses = accelerometer_poses(config, recordings, gravity, leaning)
    return poses
