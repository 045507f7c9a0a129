"""Names of the common errors of what poses show all round one turn."""

from calib.poses.imu_log import AXES


def room_names(run: str) -> tuple[str, str]:
    """The common errors of a run by the Earth's horizontal rate, along and across the lean."""
    return f"Earth's rate along the tilt of {run}", f"Earth's rate across the tilt of {run}"


def tilt_name(run: str) -> str:
    """The common error of a run by the tilt of its plate."""
    return f"tilt of {run}"


FRAME_NAMES = tuple(f"frame angle {axis}" for axis in AXES)
"""The common errors by the rotation between both triads. Definition."""


def accelerometer_names(count: int) -> tuple[str, ...]:
    """The common errors by what the accelerometer's calibration leaves open."""
    return tuple(f"accelerometer {i + 1}" for i in range(count))


def is_free(name: str) -> bool:
    """Whether a common error is an unknown that the rows alone decide."""
    return name.startswith("tilt of ") or name in FRAME_NAMES
