"""How a plate leans, and how far its poses lie from the spindle, by a fitted accelerometer."""

import numpy as np

from calib.fit.least_squares.result import Fit
from calib.poses.runs.ring import ANGLES, leans_of
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
    tilt, across = leans_of(corrected.reshape(-1, ANGLES, 3))
    runs = np.array(fit.poses.run)[ring.place]
    return Leaning({str(name): float(tilt[runs == name].mean()) for name in np.unique(runs)},
                   {fit.poses.label[i]: float(size)
                    for i, size in zip(ring.place, across, strict=True)})
