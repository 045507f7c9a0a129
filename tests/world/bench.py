"""The experiment: site, turntable, attitudes, surroundings and the runs of one evening."""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from itertools import product

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from tests.world.imu import FloatArray, Sensor
from tests.world.plate import PlateMotion

EARTH_RATE_RAD_S = 7.292115e-5
RATED_SPEED_RAD_S = 100 * np.pi / 90  # 33 1/3 rpm, the speed that ``vibration_m_s2`` is quoted at


@dataclass(frozen=True)
class Site:
    """Where on Earth: latitude (degrees) and the local magnitude of gravity (m/s²)."""

    latitude_deg: float = 40.85
    gravity_m_s2: float = 9.80267

    def earth_rate(self) -> FloatArray:
        """Earth's rotation, shape (3,), in north, west, up."""
        latitude = np.deg2rad(self.latitude_deg)
        return EARTH_RATE_RAD_S * np.array([np.cos(latitude), 0.0, np.sin(latitude)])


@dataclass(frozen=True)
class Turntable:
    """The record player and how the sensor lies on it.

    Parameters
    ----------
    tilt_rad : (float, float)
        Rotation of the spindle away from the vertical, about north and about west.
    offset_m : (float, float)
        Where on the plate the case is put, from the spindle, in plate coordinates.
    placement_sd_m : float
        Scatter of that, anew for every pose.
    vibration_m_s2 : float
        Vibration that the motor makes at 33 1/3 rpm, per axis, root mean square; proportional to
        speed.
    rocking : callable or None
        How the case rocks on the plate: a small rotation vector in plate coordinates, rad,
        (p, n, 3), from the angle of the plate, rad, and the time within its pose, s, (p, n) each.
    magnet : (float, float)
        What acts on the gyroscope and stays in the room, north and west, in units of
        :attr:`magnetic`: a motor's field.
    magnetic : array, shape (3, 3)
        Error of the gyroscope in the case by that, rad/s per unit.
    """

    tilt_rad: tuple[float, float] = (0.006, -0.004)
    offset_m: tuple[float, float] = (0.0, 0.0)
    placement_sd_m: float = 0.001
    vibration_m_s2: float = 0.05
    rocking: Callable[[FloatArray, FloatArray], FloatArray] | None = None
    magnet: tuple[float, float] = (0.0, 0.0)
    magnetic: FloatArray = field(default_factory=lambda: np.eye(3))


def wedge_directions() -> FloatArray:
    """The 18 directions of a cube and a 45° wedge, shape (18, 3): 6 faces and 12 edges."""
    return _grid_directions({1, 2})


def corner_directions() -> FloatArray:
    """The 8 corners of a cube, shape (8, 3)."""
    return _grid_directions({3})


def _grid_directions(nonzero: set[int]) -> FloatArray:
    found = [v for v in product((1, 0, -1), repeat=3) if sum(map(abs, v)) in nonzero]
    grid = np.array(found, float)
    return grid / np.linalg.norm(grid, axis=1)[:, None]


def attitudes(directions: FloatArray, jitter_deg: float, rng: np.random.Generator) -> FloatArray:
    """Rotations (p, 3, 3) from the case to a frame whose z is up.

    The case direction ``directions[i]`` points up to within ``jitter_deg`` (sd about each axis);
    the heading is anything.
    """
    up = np.array([0.0, 0.0, 1.0])
    heading = Rotation.from_rotvec(rng.uniform(0, 2 * np.pi, len(directions))[:, None] * up)
    axis = np.cross(directions, up)
    sine = np.linalg.norm(axis, axis=1)
    axis[sine == 0] = [1.0, 0.0, 0.0]  # upright or upside down: any horizontal axis will do
    angle = np.arctan2(sine, directions @ up) / np.linalg.norm(axis, axis=1)
    stand_up = Rotation.from_rotvec(angle[:, None] * axis)
    slip = np.deg2rad(jitter_deg) * rng.standard_normal((len(directions), 3))
    return (heading * Rotation.from_rotvec(slip) * stand_up).as_matrix()


@dataclass(frozen=True)
class Course:
    """How a quantity of the surroundings goes through the evening, and how it is logged.

    ``start + rise (1 - exp(-t/tau_s))`` plus a slow wander, plus the soak of a run where the
    quantity is the temperature. ``reference`` is the value at which an effect of it vanishes.
    """

    start: float
    rise: float = 0.0
    tau_s: float = 600.0
    wander_sd: float = 0.0
    wander_tau_s: float = 120.0
    reference: float = 0.0
    logging_sd: float = 0.0
    decimals: int = 3

    def draw(self, end_s: float, rng: np.random.Generator) -> "DrawnCourse":
        """One evening's course up to ``end_s``."""
        spacing = self.wander_tau_s / 20
        knots = np.arange(0.0, end_s + 2 * spacing, spacing)
        keep = np.exp(-1 / 20)
        wander = np.empty(len(knots))
        kick = self.wander_sd * rng.standard_normal(len(knots))
        wander[0] = kick[0]
        for i in range(1, len(knots)):
            wander[i] = keep * wander[i - 1] + np.sqrt(1 - keep**2) * kick[i]
        return DrawnCourse(self, knots, wander)


@dataclass(frozen=True, eq=False)
class DrawnCourse:
    """One realisation of a :class:`Course`; called with time in seconds."""

    course: Course
    knots_s: FloatArray
    wander: FloatArray

    def __call__(self, time_s: FloatArray) -> FloatArray:
        smooth = self.course.start - self.course.rise * np.expm1(-time_s / self.course.tau_s)
        return smooth + np.interp(time_s, self.knots_s, self.wander)


TEMPERATURE = "temperature_c"
WARM_UP = Course(  # °C: a unit switched on in a room at 24 °C
    start=24.0, rise=8.0, tau_s=600.0, wander_sd=0.3, reference=25.0, logging_sd=0.02, decimals=2
)
SUPPLY_V = Course(  # a USB port under changing load
    start=5.02, wander_sd=0.03, wander_tau_s=90.0, reference=5.0, logging_sd=0.001, decimals=4
)
HUMIDITY = Course(  # % relative humidity of the room
    start=45.0, wander_sd=5.0, wander_tau_s=400.0, reference=45.0, logging_sd=0.05, decimals=2
)


@dataclass(frozen=True, eq=False)
class Run:
    """A series of poses under one condition.

    Parameters
    ----------
    name : str
        Name of the plate setting, ``stopped`` for a plate at rest.
    motion : PlateMotion or None
        Its time zero is the first sample of the run. None: a table at rest, level or not.
    directions : array, shape (p, 3)
        Case directions that point up, before shuffling.
    seconds, rest_s : float
        Length of a pose, and of the pause after it.
    lead_s : float
        Pause before the first pose.
    soak_c : float
        Warmth added by a heating chamber during this run, in °C.
    in_accelerometer_section : bool
        Whether the poses calibrate the accelerometers.
    tilt_rad : (float, float) or None
        As of the turntable, where it is put another way for this run.
    """

    name: str
    motion: PlateMotion | None
    directions: FloatArray
    seconds: float
    rest_s: float = 22.0
    lead_s: float = 0.0
    soak_c: float = 0.0
    in_accelerometer_section: bool = False
    tilt_rad: tuple[float, float] | None = None

    @property
    def length_s(self) -> float:
        """From the first sample to the end of the last pause."""
        return len(self.directions) * (self.seconds + self.rest_s)


@dataclass(frozen=True, eq=False)
class Design:
    """A whole evening, before chance has been asked.

    ``rate_sd_relative`` is the uncertainty of the plate's rate where a session states it without
    a clip; the stated value is off by a random amount of that size, common to all poses of a run.
    ``clock_sd_relative`` comes on top: the clock by which all of them were measured.
    ``rests_count_for_gyroscope`` says whether the poses at rest are a run of the gyroscopes too.
    """

    title: str
    sensor: Sensor
    runs: tuple[Run, ...]
    site: Site = field(default_factory=Site)
    turntable: Turntable = field(default_factory=Turntable)
    sample_rate_hz: float = 100.0
    jitter_deg: float = 1.0
    shuffled: bool = True
    temperature: Course = WARM_UP
    columns: dict[str, Course] = field(default_factory=dict)
    rate_sd_relative: float = 50e-6
    clock_sd_relative: float = 0.0
    rests_count_for_gyroscope: bool = True

    @property
    def end_s(self) -> float:
        """Length of the evening."""
        return sum(run.lead_s + run.length_s for run in self.runs)

    def begins_s(self) -> list[float]:
        """Session time at which the first pose of each run begins."""
        begins, now = [], 0.0
        for run in self.runs:
            begins.append(now + run.lead_s)
            now += run.lead_s + run.length_s
        return begins

    def scaled(self, seconds: float = 1.0, sample_rate: float = 1.0) -> "Design":
        """The same evening with shorter poses or fewer samples (factors), for fast studies."""
        runs = tuple(replace(run, seconds=run.seconds * seconds) for run in self.runs)
        return replace(self, runs=runs, sample_rate_hz=self.sample_rate_hz * sample_rate)


def pose_order(count: int, shuffled: bool, rng: np.random.Generator) -> NDArray[np.int64]:
    """Which direction is taken when."""
    return rng.permutation(count) if shuffled else np.arange(count)
