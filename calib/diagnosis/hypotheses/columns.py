"""Logged columns that may cause an error, judged by their names.

A magnetometer and an orientation follow the attitude, a position follows the journey, a counter the
clock: an error that follows them does not reveal its cause.
"""

import re
from collections.abc import Sequence

from calib.poses.past import PAST
from calib.poses.pose_set import PoseSet

WORD = re.compile(r"[A-Z]+(?![a-z])|[A-Z]?[a-z]+")

OF_ATTITUDE = frozenset({
    "mag", "magn", "magnet", "magnetic", "magnetometer", "compass", "mx", "my", "mz", "roll",
    "pitch", "yaw", "heading", "euler", "ori",
    "orientation", "attitude", "mat", "rotation", "acc", "accel", "accelerometer", "gyr", "gyro",
    "gyroscope", "gravity",
})  # fmt: skip
OF_QUATERNION = frozenset({"quat", "quaternion", "q", "qw", "qx", "qy", "qz"})
"""Separate from the others, since ``q_w`` does not end in watts."""

OF_JOURNEY = frozenset({
    "gps", "gnss", "lat", "latitude", "lon", "lng", "longitude", "alt", "altitude", "vel",
    "velocity",
})  # fmt: skip
OF_CLOCK = frozenset({
    "time", "timestamp", "sampletime", "uptime", "utc", "epoch", "counter", "count", "packet",
    "seq", "sequence", "index", "status", "flag", "flags", "valid",
})  # fmt: skip
OF_CAUSES = frozenset({
    "v", "mv", "volt", "volts", "voltage", "a", "ma", "amp", "amps", "ampere", "current", "w", "mw",
    "watt", "watts", "power", "c", "degc", "celsius", "k", "kelvin", "temp", "temperature", "pa",
    "hpa", "kpa", "bar", "mbar", "pressure", "pct", "percent", "rh", "humidity",
})  # fmt: skip
"""Units and quantities that act on a sensor: ``mag_temp_c`` and ``alt_v`` are causes."""


def words_of(column: str) -> tuple[str, ...]:
    """The words of a column's name, in lower case: cut at ``_``, digits, brackets and case.

    >>> words_of("OriInc_q0"), words_of("alternator_a"), words_of("GPSAlt[1]")
    (('ori', 'inc', 'q'), ('alternator', 'a'), ('gps', 'alt'))
    """
    return tuple(word.lower() for word in WORD.findall(column))


def is_cause(column: str, named: Sequence[str] | None) -> bool:
    """Whether a logged column may cause an error; all that ``named`` lists do, where it is given.

    Without it every column may whose name has no word of attitude, journey or clock, or that ends
    on a unit or quantity of what acts on a sensor.
    """
    if column.startswith(PAST):
        return False
    if named is not None:
        return column in named
    words = words_of(column)
    if (OF_CLOCK | OF_QUATERNION) & set(words):
        return False
    if words and words[-1] in OF_CAUSES:
        return True
    return not (OF_ATTITUDE | OF_JOURNEY) & set(words)


def causes(poses: PoseSet, named: Sequence[str] | None = None) -> tuple[str, ...]:
    """The logged columns of ``poses`` that may cause an error."""
    return tuple(name for name in poses.columns if is_cause(name, named))


def set_aside(poses: PoseSet, named: Sequence[str] | None = None) -> tuple[str, ...]:
    """The logged columns of ``poses`` that vary and are not considered as causes."""
    aside = {name for name in poses.columns if not name.startswith(PAST)}
    aside -= set(causes(poses, named))
    return tuple(sorted(name for name in aside if poses.columns[name].std() > 0))
