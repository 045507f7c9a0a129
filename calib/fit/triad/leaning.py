"""Tilt of a plate and its axis of rotation, from the accelerometer on it.

On a plate that leans the wave of gravity spans the plane across the axis of rotation, wherever the
sensor lies: unlike the mean force it does not depend on the distance from the spindle. With cosine
c and sine d of the wave the axis is ``c × d``; the uncertainty of the accelerometer's calibration
moves it by

    dn = -(n·dc) c/|c|² - (n·dd) d/|d|²
"""

from dataclasses import replace

import numpy as np

from calib.fit.least_squares.result import Fit
from calib.fit.model import stack_columns
from calib.poses.conditions import Conditions
from calib.poses.imu_log import FloatArray
from calib.poses.pose_set import PoseSet
from calib.poses.reference import FRAME_NAMES, accelerometer_names
from calib.poses.runs.ideal_ring import NOT_FITTED, Leaning
from calib.poses.runs.ring import ANGLES, TO_WAVE, leans_of


def with_axes(poses: PoseSet, accelerometer: Fit) -> PoseSet:
    """Poses of the gyroscope with the axes of their rings; as they are where the plate is level.

    Parameters
    ----------
    poses : PoseSet
        With calibrated specific force.
    accelerometer : Fit
    """
    ring = poses.ring
    if ring is None:
        return poses
    wave = np.einsum("ck,wkj->wcj", TO_WAVE, ring.force)
    square = (wave**2).sum(axis=2)
    axis = np.cross(wave[:, 0], wave[:, 1])
    axis /= np.linalg.norm(axis, axis=1, keepdims=True)
    axis *= np.sign((axis * ring.force.mean(axis=1)).sum(axis=1))[:, None]
    moved = _moved(accelerometer, wave)  # (w, 2, 3, a)
    along = np.einsum("wi,wcia->wca", axis, moved) / square[:, :, None]
    count = moved.shape[-1]
    names = (*FRAME_NAMES, *accelerometer_names(count))
    reference = poses.reference
    return replace(
        poses,
        ring=replace(ring, axis=axis, axis_moved=-np.einsum("wca,wci->wia", along, wave)),
        reference=replace(
            reference,
            common=np.hstack([reference.common, np.zeros((len(poses), len(names)))]),
            common_names=(*reference.common_names, *names)),
    )


def _moved(fit: Fit, wave: FloatArray) -> FloatArray:
    """Shift of waves (w, 2, 3) by an sd of each error of the nine parameters, SI."""
    reading = fit.model.acting_on("reading")
    index = fit.model.positions(reading)
    ends = np.concatenate([wave.reshape(-1, 3), np.zeros((1, 3))])
    columns = stack_columns(reading, Conditions.of_vectors(ends), {})
    of_wave = (columns[-1] - columns[:-1]).reshape(*wave.shape, -1)  # a bias makes no wave
    size, turns = np.linalg.eigh(fit.cov[np.ix_(index, index)])
    return np.asarray(of_wave @ (turns * np.sqrt(np.maximum(size, 0.0))))


def leaning_of(fit: Fit) -> Leaning:
    """The tilt of every plate and the force across its axis in every pose.

    Parameters
    ----------
    fit : Fit
        Of an accelerometer.

    Returns
    -------
    Leaning
        Nothing where all poses were at rest.
    """
    ring, corrected = fit.poses.ring, fit.rows.points
    if ring is None or corrected is None:
        return NOT_FITTED
    tilt, across = leans_of(corrected.reshape(-1, ANGLES, 3))
    runs = np.array(fit.poses.run)[ring.place]
    return Leaning({str(name): float(tilt[runs == name].mean()) for name in np.unique(runs)},
                   {fit.poses.label[i]: float(size)
                    for i, size in zip(ring.place, across, strict=True)})
