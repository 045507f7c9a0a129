"""How a plate leans, and how far its poses lie from the spindle, by a fitted accelerometer."""

import numpy as np

from calib.fit.least_squares.result import Fit
from calib.poses.runs.ring import ANGLES, TO_WAVE
from calib.poses.runs.tilted_run import NOT_FITTED, Leaning


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
    points = corrected.reshape(-1, ANGLES, 3)
    wave = np.tensordot(points, TO_WAVE, axes=(1, 1)).transpose(0, 2, 1)  # (w, 2, 3)
    axis = np.cross(wave[:, 0], wave[:, 1])
    axis /= np.linalg.norm(axis, axis=1, keepdims=True)
    mean = fit.rows.vector[ring.place]
    along = np.abs((mean * axis).sum(axis=1))
    across = np.linalg.norm(mean - (mean * axis).sum(axis=1, keepdims=True) * axis, axis=1)
    tilt = np.arctan2(np.sqrt((wave**2).sum(axis=(1, 2)) / 2), along)
    runs = np.array(fit.poses.run)[ring.place]
    return Leaning({str(name): float(tilt[runs == name].mean()) for name in np.unique(runs)},
                   {fit.poses.label[i]: float(size)
                    for i, size in zip(ring.place, across, strict=True)})
