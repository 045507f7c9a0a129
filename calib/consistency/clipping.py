"""Readings cut off below the converter's range: by a filter, an amplifier, or another full scale.

Noise is densest in its middle. Where a log stands at its own largest (or smallest) value in a
quarter of its samples and more, and the logs of the same sensor usually do so in next to none, that
value is a limit.
"""

from collections.abc import Sequence

import numpy as np

from calib.errors import Undetermined
from calib.poses.data_sheet import TriadSpec
from calib.poses.imu_log import AXES, ImuLog, Triad

CLIPPED_SHARE = 0.25
"""Of a log's samples at its extreme. Normal noise of a step's size has 7 % there, of half a step's
31 %: what steps so coarsely does it in most logs. Derived, between the two. Half and double
change none of 2 ordinary sessions and 1 mistake in ``tests.bench.contradiction_limits``."""

USUAL_SHARE = 0.05
"""Of a log's samples at its extreme, the median of the sensor's logs that are not at the limit.
Derived: below the 7 % of normal noise of a step's size, above which no limit shows."""

PILED_UP = 2.0
"""Times as frequent as any other value: noise cut off within its own width is. Derived: normal
noise cut off at its mean has half of its samples there and a step's share elsewhere."""


def require_unclipped(logs: Sequence[ImuLog], triad: Triad, spec: TriadSpec) -> None:
    """Refuse logs of ``triad`` in which an axis is cut off below the range of ``spec``.

    What stands at the ends of the range is refused where the pose is averaged.

    Parameters
    ----------
    logs : sequence of ImuLog
    triad : str
    spec : TriadSpec
        The data sheet of the triad.

    Raises
    ------
    Undetermined
        Naming log, axis and value.
    """
    used = [log for log in logs if log.has(triad)]
    if len(used) < 2:
        return
    values = [spec.signed(getattr(log, triad)) for log in used]
    rails = spec.count_range
    high, low = (np.array([pick(each, axis=0) for each in values]) for pick in (np.max, np.min))
    at_limit = (high == high.max(axis=0)) | (low == low.min(axis=0))
    for extreme, limit in ((high, high.max(axis=0)), (low, low.min(axis=0))):
        share = np.array([(each == at).mean(axis=0)
                          for each, at in zip(values, extreme, strict=True)])
        usual = np.array([np.median(each[~held]) if not held.all() else 1.0
                          for each, held in zip(share.T, at_limit.T, strict=True)])
        clipped = (share > CLIPPED_SHARE) & (extreme == limit) & (usual < USUAL_SHARE)
        clipped &= (extreme > rails[0]) & (extreme < rails[1])
        for i, k in np.argwhere(clipped).tolist():
            _, counts = np.unique(values[i][:, k], return_counts=True)
            if np.sort(counts)[-2:].sum() - counts.max() > counts.max() / PILED_UP:
                continue  # coarse steps: the value beside it is as frequent
            raise Undetermined(
                f"{used[i].label}: {triad} {AXES[k]} stands at {extreme[i, k]:g} in "
                f"{100 * share[i, k]:.0f} % of its samples, and in no log of this run goes beyond: "
                f"the axis is clipped there, or stuck. The true value is unknown; choose a larger "
                f"full scale or a slower plate, and record the pose again."
            )
