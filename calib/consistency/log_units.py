"""Units of logs that their readings contradict: of temperature, and of time among the logs."""

from collections.abc import Sequence

import numpy as np

from calib.errors import Contradiction
from calib.poses.imu_log import TEMPERATURE, ImuLog

CELSIUS = (-80.0, 150.0)
"""Range of temperatures. Fact: wider than that of any inertial sensor's data sheet."""

OTHER_UNIT = 100.0
"""Ratio of the sample rates of two logs. Derived: the next unit of time is 1000 away."""


def require_celsius(logs: Sequence[ImuLog]) -> None:
    """Refuse temperatures that are not in °C.

    Raises
    ------
    Contradiction
        Naming the first such log.
    """
    low, high = CELSIUS
    for log in logs:
        warmth = log.columns.get(TEMPERATURE, np.zeros(1))
        typical = float(np.nanmedian(warmth)) if np.isfinite(warmth).any() else 0.0
        if not low < typical < high:
            raise Contradiction(
                f"{log.label}: its column temperature_c reads {typical:.4g} (median), where no "
                f"sensor works outside {low:g} to {high:g} °C. Is it in kelvin, in °F or in raw "
                f"counts? Bring it to °C, or rename the column."
            )


def require_one_unit_of_time(logs: Sequence[ImuLog]) -> None:
    """Refuse logs of one session whose clocks count in different units.

    Raises
    ------
    Contradiction
        Naming the log that differs most.
    """
    steps = np.array([float(np.median(np.diff(log.time_s))) for log in logs])
    typical = float(np.median(steps))
    ratio = np.maximum(steps / typical, typical / steps)
    odd = int(np.argmax(ratio))
    if ratio[odd] < OTHER_UNIT:
        return
    raise Contradiction(
        f"{logs[odd].label}: its time stamps are {steps[odd]:.3g} apart, those of the other logs "
        f"{typical:.3g}. Are some of them seconds and others milliseconds, microseconds or a "
        f"counter? Bring time_s of all logs to seconds."
    )
