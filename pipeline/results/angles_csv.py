"""The angles of a clip as a CSV table, for other programs."""

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from vision.phase_track import RateHistory
    from vision.rate.measure import RateMeasurement

HEAD = "frame,time_s,angle_rad,residual_rad,used"


def angles_csv(history: "RateHistory", rate: "RateMeasurement | None" = None) -> str:
    """A row for each frame that shows the plate.

    Columns are the number of the frame, its time stamp, the angle, which goes on from turn to turn,
    its residual from the stated model, and whether the rate uses it. Where no constant rate was
    found, ``rate`` is None, and the residual is empty.
    """
    angle = history.angle
    if rate is None:
        rest = [",0"] * len(angle.time_s)
    else:
        rest = [f"{residual:.9g},{int(used)}" for residual, used in zip(
            rate.fit.residual_rad, rate.fit.used, strict=True)]
    rows = [f"{frame},{time:.6f},{turned:.9g},{more}" for frame, time, turned, more in zip(
        np.asarray(angle.index), angle.time_s, angle.angle_rad, rest, strict=True)]
    return "\n".join([HEAD, *rows]) + "\n"
