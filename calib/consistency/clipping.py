"""Readings cut off below the converter's range: by a filter, an amplifier, or another full scale.

Noise is densest in its middle. Where a log stands at its own largest (or smallest) value in a
quarter of its samples and more, twice as often as the sensor's other logs stand anywhere, that
value is a limit. A quiet sensor on a coarse converter stands somewhere most of the time.
"""

from collections.abc import Sequence

import numpy as np

from calib.errors import Undetermined
from calib.poses.data_sheet import TriadSpec
from calib.poses.imu_log import AXES, FloatArray, ImuLog, Triad

CLIPPED_SHARE = 0.25
"""Share of a log's samples at its extreme. Normal noise of a step's size has 7 % there, of half a
step's 31 %: what steps so coarsely does it in most logs. Derived, between the two."""

PILED_UP = 2.0
"""Times as frequent as the most frequent value in the median of the sensor's other logs. Derived:
by the place of the mean between two steps, normal noise of a third of a step and more makes the
most frequent value up to twice as frequent in one log as in another; what is quieter has one that
more than half of its samples have, and nothing can be twice as frequent."""


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
    values = [spec.signed(log.readings(triad)) for log in used]
    rails = spec.count_range
    high, low = (np.array([pick(each, axis=0) for each in values]) for pick in (np.max, np.min))
    at_limit = (high == high.max(axis=0)) | (low == low.min(axis=0))
    for extreme, limit in ((high, high.max(axis=0)), (low, low.min(axis=0))):
        share = np.array([(each == at).mean(axis=0)
                          for each, at in zip(values, extreme, strict=True)])
        clipped = (share > CLIPPED_SHARE) & (extreme == limit)
        clipped &= (extreme > rails[0]) & (extreme < rails[1])
        for i, k in np.argwhere(clipped).tolist():
            others = [each[:, k] for each, held in zip(values, at_limit[:, k], strict=True)
                      if not held]
            if not others or share[i, k] < PILED_UP * np.median([*map(_largest_share, others)]):
                continue
            raise Undetermined(
                f"{used[i].label}: {triad} {AXES[k]} stands at {extreme[i, k]:g} in "
                f"{100 * share[i, k]:.0f} % of its samples, and in no log of this run goes beyond: "
                f"the axis is clipped there, or stuck. The true value is unknown; choose a larger "
                f"full scale or a slower plate, and record the pose again."
            )


def _largest_share(values: FloatArray) -> float:
    """Share of the most frequent value."""
    _, counts = np.unique(values, return_counts=True)
    return float(counts.max() / len(values))
