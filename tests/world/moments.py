"""What surrounds the simulated sensor at every sample of a run."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

from tests.world.bench import Course
from tests.world.imu import FloatArray, Triad


@dataclass(frozen=True, eq=False)
class Moments:
    """What surrounds the sensor during one run of p poses of n samples.

    Attributes
    ----------
    time_s : array, shape (p, n)
        Since the sensor was switched on.
    columns : mapping of name to array, shape (p, n)
        True courses of temperature and of every other logged quantity.
    courses : mapping of name to Course
        Where each of them is at its reference value.
    rate, force : array, shape (p, n, 3)
        True angular rate (rad/s) and specific force (m/s²) in the case frame, at the point of the
        case that was put over the spindle.
    spin, spin_up : array, shape (p, n, 3)
        The plate's part of the rate, and its time derivative, in the case frame.
    vibration_m_s2 : array, shape (p, 1, 1)
        Root mean square of the vibration in each pose.
    triad : Triad
        The triad that the effect acts on.
    before : array, shape (p, 1, 3)
        Mean along each sensitive axis during the pose before, zero for the first of the evening.
    number : array of int, shape (p, 1, 1)
        Running number of the pose through the evening, from 0.
    warmth : callable
        True temperature at any time of the evening, °C.
    """

    time_s: FloatArray
    columns: Mapping[str, FloatArray]
    courses: Mapping[str, Course]
    rate: FloatArray
    force: FloatArray
    spin: FloatArray
    spin_up: FloatArray
    vibration_m_s2: FloatArray
    triad: Triad
    before: FloatArray
    number: FloatArray
    warmth: Callable[[FloatArray], FloatArray]

    def since_on(self) -> FloatArray:
        """Time since power-on, shape (p, n, 1), in seconds."""
        return self.time_s[..., None]

    def above_reference(self, column: str) -> FloatArray:
        """How far a logged quantity is above its reference, shape (p, n, 1)."""
        return (self.columns[column] - self.courses[column].reference)[..., None]
