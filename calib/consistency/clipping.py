"""Readings cut off below the converter's range: by a filter, an amplifier, or another full scale.

Noise is densest in its middle, and a wave is at its crest for less than half of the time. If a log
stays at its own largest (or smallest) value more often, that value is a limit. A quiet sensor on a
coarse converter has few values; an axis that stays at a single value while the other logs scatter
is frozen (:mod:`calib.consistency.repeats`).
"""

from collections.abc import Sequence

import numpy as np

from calib.errors import Undetermined
from calib.poses.checks.stray_samples import cut_off
from calib.poses.data_sheet import TriadSpec
from calib.poses.imu_log import AXES, ImuLog, Triad

CLIPPED_SHARE = 0.45
"""Share of a log's samples at its extreme. Derived: a wave of a few steps has up to 0.30 at its
crest, 0.40 in one and a half turns; noise that is cut off in its middle has half."""

FEWEST_LEVELS = 4
"""Number of values of an axis. Derived: noise of fewer can have a third of them at its end."""


def require_unclipped(logs: Sequence[ImuLog], triad: Triad, spec: TriadSpec) -> None:
    """Refuse logs of ``triad`` in which an axis is cut off below the full scale of ``spec``.

    Samples at the ends of the range are refused where the pose is averaged.

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
    rails = spec.count_range
    for log in logs:
        if not log.has(triad):
            continue
        for name, axis in zip(AXES, spec.signed(log.readings(triad)).T, strict=True):
            limits = cut_off(axis)
            for extreme in (axis.max(), axis.min()):
                there = axis == extreme
                share = float(there.mean())
                clipped = limits[there].any() or (
                    share > CLIPPED_SHARE and len(np.unique(axis)) >= FEWEST_LEVELS)
                if not clipped or not rails[0] < extreme < rails[1]:
                    continue
                raise Undetermined(
                    f"{log.label}: {triad} {name} stands at {extreme:g} in {100 * share:.0f} % of "
                    f"its samples and never goes beyond: the axis is clipped there, or stuck. The "
                    f"true value is unknown; choose a larger full scale or a slower plate, and "
                    f"record the pose again."
                )
