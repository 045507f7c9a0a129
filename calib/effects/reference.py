"""Errors of the reference: the plate does not turn at the rate that was filmed.

Columns (n, k): error of the true magnitude over the stated one. Plate-stopped poses have none.
"""

import numpy as np

from calib.effects.effect import Page, effect
from calib.effects.typical import between, typical
from calib.numbers import SECONDS_PER_HOUR
from calib.poses.conditions import Conditions
from calib.poses.imu_log import FloatArray


def _magnitude(at: Conditions) -> FloatArray:
    """Reference magnitude of the poses that have one, 0 of a plate at rest, SI, (n,)."""
    return np.where(at.magnitude > 0, at.magnitude, 0.0)


@effect(
    "offset",
    acts_on="reference",
    unit="{u}",
    needs=("plate",),
    belongs_to="bench",
    page=Page(
        formula="m → m + c",
        typical={
            "record player": typical(note="frame counting at 15 fps: up to 1.85 % in one turn")
        },
        source="Angrisano et al., frame counting",
        confounded="scale exactly at one speed",
        separates="a second speed",
    ),
)
def reference_offset(at: Conditions) -> FloatArray:
    """The same error on every reference magnitude, whatever its size."""
    return np.asarray(_magnitude(at) > 0, float)[:, None]


@effect(
    "scale",
    acts_on="reference",
    unit="1",
    needs=("plate",),
    belongs_to="bench",
    page=Page(
        formula="m → m (1 + c)",
        typical={
            "camera crystal": typical(
                between(20, 100, "ppm"), note="0.1 % for 30 against 29.97 fps")
        },
        source="time base of the camera; local gravity anomaly",
        confounded="scale exactly, at every speed and in both directions",
        separates="another clock in the frame; surveyed gravity. These poses cannot",
    ),
)
def reference_scale(at: Conditions) -> FloatArray:
    """Every reference magnitude wrong by the same factor: camera clock or gravity value."""
    return _magnitude(at)[:, None]


@effect(
    "drift",
    acts_on="reference",
    unit="1/h",
    needs=("plate", "time"),
    constant_is="scale",
    belongs_to="bench",
    only_for=("gyroscope",),
    page=Page(
        formula="m → m (1 + d · t), t from the middle of the turning poses",
        typical={"record player": typical(between(0.1, 1, "%/h"), note="while the motor warms up")},
        source="motor drift",
        confounded="a scale_drift that is the same on all axes, exactly, in every design",
        separates="one clip per pose",
    ),
)
def reference_drift(at: Conditions) -> FloatArray:
    """The plate speeds up or slows down through the session, which its clips do not show."""
    return np.asarray(_magnitude(at) * at.since_middle_s / SECONDS_PER_HOUR)[:, None]


@effect(
    "direction",
    acts_on="reference",
    unit="1",
    needs=("plate",),
    belongs_to="bench",
    only_for=("gyroscope",),
    page=Page(
        formula="m → m (1 + c · sign(Ω))",
        typical={"record player": typical(between(0.01, 0.1, "%"))},
        source="drag and belt tension differ with the direction",
        confounded="isotropic g_sensitivity with two directions at one speed",
        separates="a second speed and plate-stopped poses; one clip per direction",
    ),
)
def direction_dependent_rate(at: Conditions) -> FloatArray:
    """The plate turns faster one way than the other, by the same factor at every speed."""
    return np.asarray(_magnitude(at) * np.sign(at.spin_rad_s))[:, None]
