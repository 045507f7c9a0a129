"""Poses without the waves of a leaning plate: mistakes in files show in their means."""

from dataclasses import replace

from calib.errors import CalibrationError
from calib.fit.least_squares.result import Fit
from calib.fit.least_squares.solver import fit
from calib.fit.model import Model
from calib.poses.pose_set import PoseSet


def by_means(poses: PoseSet, model: Model, fitted: Fit | None) -> tuple[PoseSet, Fit | None]:
    """The means of ``poses`` alone, and their fit in place of ``fitted``.

    Parameters
    ----------
    poses : PoseSet
    model : Model
    fitted : Fit or None
        With the waves; None where there was no fit.

    Returns
    -------
    poses : PoseSet
        Those given where the plate is level.
    fitted : Fit or None
        None where the means alone do not determine the model.
    """
    if poses.ring is None:
        return poses, fitted
    means = replace(poses, ring=None)
    try:
        return means, None if fitted is None else fit(means, model)
    except CalibrationError:
        return means, None
