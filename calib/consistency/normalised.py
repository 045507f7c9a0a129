"""Readings of an accelerometer that a library has normalised to one length.

An attitude filter needs only the direction of gravity. Such unit vectors fit every model of bias,
scale and misalignment without a residual, and contain no information on the sensor.
"""

from collections.abc import Sequence

import numpy as np

from calib.errors import Undetermined
from calib.poses.data_sheet import TriadSpec
from calib.poses.imu_log import ImuLog
from calib.poses.samples.converter_steps import value_steps

SAME_LENGTH = 0.1
"""Scatter of the samples' length over that of their axes. Derived: if the noise of one axis is
three times less than that of the others it is 0.3; at a constant length only the steps scatter."""

FEWEST_STEPS = 4.0
"""Scatter of the axes, steps, from which one step is less than SAME_LENGTH of it. Derived."""


def require_raw(logs: Sequence[ImuLog], spec: TriadSpec) -> None:
    """Refuse logs of poses at rest whose accelerometer samples all have one length.

    Raises
    ------
    Undetermined
        Naming the first log, where most of them are so.
    """
    alike = []
    for log in logs:
        if not log.has("accelerometer"):
            continue
        counts = spec.signed(log.accelerometer)
        values = spec.nominal(counts)
        axes = float(np.sqrt(values.var(axis=0).mean()))
        step = float((value_steps(counts) * spec.nominal_scale).min())
        length = float(np.linalg.norm(values, axis=1).std())
        if axes > FEWEST_STEPS * step and length < SAME_LENGTH * axes:
            alike.append((log.label, length, axes))
    if 2 * len(alike) > len(logs):
        label, length, axes = alike[0]
        raise Undetermined(
            f"{label}: the accelerometer's samples have one length (sd {length:.2g} m/s², of each "
            f"axis {axes:.2g} m/s²), as have {len(alike) - 1} other logs: something brought them "
            f"to it, as filters of attitude do. Such vectors say nothing of bias and scale; log "
            f"what the sensor itself delivers."
        )
