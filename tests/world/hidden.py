"""What a session may hide: physics on a sensor axis, on the plate, or at the site.

Every effect is stated as the physics has it, in the sensor's own axes, and knows nothing of what a
calibration makes of it. An axis effect gives the error of the reading along each sensitive axis (in
m/s² or rad/s) from what truly acts there; a bench effect changes how the plate turns, or gravity,
while the session goes on stating the undisturbed value.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Literal

import numpy as np

from tests.world.bench import TEMPERATURE
from tests.world.imu import FloatArray
from tests.world.moments import Moments

TriadName = Literal["accelerometer", "gyroscope"]


@dataclass(frozen=True, eq=False)
class Hidden:
    """One effect of one size, hidden in one triad.

    ``detail`` holds what a size cannot: a time constant, a column, a pose, a moment.
    """

    name: str
    triad: TriadName
    size: FloatArray
    detail: Mapping[str, float | int | str] = field(default_factory=dict)

    def __post_init__(self) -> None:
        object.__setattr__(self, "size", np.asarray(self.size, float))
        if self.physics.shape != self.size.shape:
            raise ValueError(f"{self.name} has a size of shape {self.physics.shape}")

    @property
    def physics(self) -> "Physics":
        """The entry of :data:`EFFECTS` that this is a size of."""
        return EFFECTS[self.name.partition(":")[0]]

    @property
    def column(self) -> str:
        """The logged column that ``column:NAME`` and its unlisted relatives follow."""
        return self.name.partition(":")[2]

    def error(self, true: FloatArray, moments: Moments) -> FloatArray | float:
        """Error of the reading along the axes, broadcastable to (p, n, 3)."""
        return self.physics.act(self, true, moments) if self.physics.act else 0.0


LEAST_PUSH = 2e-4  # of full scale: 0.03 to 0.05 °/s, ten times Earth's rotation

Act = Callable[[Hidden, FloatArray, Moments], FloatArray]


@dataclass(frozen=True)
class Physics:
    """Shape of the size, its unit ({u} is m/s² or rad/s), and how it acts on an axis.

    ``act`` is None for what acts on the bench; see :func:`disturbed_run`.
    """

    shape: tuple[int, ...]
    unit: str
    act: Act | None = None


def _bias(effect: Hidden, true: FloatArray, moments: Moments) -> FloatArray:
    return effect.size


def _scale(effect: Hidden, true: FloatArray, moments: Moments) -> FloatArray:
    return effect.size * true


def _misalignment(effect: Hidden, true: FloatArray, moments: Moments) -> FloatArray:
    yz, xz, xy = effect.size  # how far y leans towards z, x towards z, x towards y
    _, y, z = np.moveaxis(true, -1, 0)
    return np.stack([xy * y + xz * z, yz * z, 0 * z], axis=-1)


def _frame_rotation(effect: Hidden, true: FloatArray, moments: Moments) -> FloatArray:
    return np.cross(effect.size, true)


def _quadratic(effect: Hidden, true: FloatArray, moments: Moments) -> FloatArray:
    return effect.size * true**2


def _cubic(effect: Hidden, true: FloatArray, moments: Moments) -> FloatArray:
    return effect.size * true**3


def _asymmetry(effect: Hidden, true: FloatArray, moments: Moments) -> FloatArray:
    return effect.size * np.abs(true)


def _cross_quadratic(effect: Hidden, true: FloatArray, moments: Moments) -> FloatArray:
    x, y, z = np.moveaxis(true, -1, 0)
    return np.stack([y * z, z * x, x * y], axis=-1) @ effect.size.T


def _temperature_bias(effect: Hidden, true: FloatArray, moments: Moments) -> FloatArray:
    return effect.size * moments.above_reference(TEMPERATURE)


def _temperature_scale(effect: Hidden, true: FloatArray, moments: Moments) -> FloatArray:
    return effect.size * moments.above_reference(TEMPERATURE) * true


def _bias_drift(effect: Hidden, true: FloatArray, moments: Moments) -> FloatArray:
    return effect.size * moments.since_on()


def _scale_drift(effect: Hidden, true: FloatArray, moments: Moments) -> FloatArray:
    return effect.size * moments.since_on() * true


def _warm_up(effect: Hidden, true: FloatArray, moments: Moments) -> FloatArray:
    return effect.size * np.exp(-moments.since_on() / float(effect.detail["tau_s"]))


def _hysteresis(effect: Hidden, true: FloatArray, moments: Moments) -> FloatArray:
    """What the pose before pushed the axis to, it keeps; Earth's rotation pushes nothing."""
    pushed = np.abs(moments.before) > LEAST_PUSH * moments.triad.full_scale
    return effect.size * np.where(pushed, np.sign(moments.before), 0.0)


def _memory(effect: Hidden, true: FloatArray, moments: Moments) -> FloatArray:
    """What the pose before left in the axis grows with its push and saturates."""
    largest = float(np.abs(moments.before).max()) or 1.0
    return effect.size * np.tanh(moments.before / (float(effect.detail["width"]) * largest))


def _vibration_rectification(effect: Hidden, true: FloatArray, moments: Moments) -> FloatArray:
    """Follows the variance of the vibration, summed over three equally shaken axes."""
    return effect.size * 3 * moments.vibration_m_s2**2


def _g_sensitivity(effect: Hidden, true: FloatArray, moments: Moments) -> FloatArray:
    return moments.force @ effect.size.T


def _g_squared_sensitivity(effect: Hidden, true: FloatArray, moments: Moments) -> FloatArray:
    return effect.size * moments.triad.project(moments.force) ** 2


def _lever_arm(effect: Hidden, true: FloatArray, moments: Moments) -> FloatArray:
    """The accelerometers sit further out in the case than the case's own drawing says."""
    swing = np.cross(moments.spin, effect.size)
    force = np.cross(moments.spin, swing) + np.cross(moments.spin_up, effect.size)
    return moments.triad.project(force)


def _column(effect: Hidden, true: FloatArray, moments: Moments) -> FloatArray:
    return effect.size * moments.above_reference(effect.column)


def _column_squared(effect: Hidden, true: FloatArray, moments: Moments) -> FloatArray:
    return effect.size * moments.above_reference(effect.column) ** 2


def _temperature_squared(effect: Hidden, true: FloatArray, moments: Moments) -> FloatArray:
    return effect.size * moments.above_reference(TEMPERATURE) ** 2


def _temperature_lag(effect: Hidden, true: FloatArray, moments: Moments) -> FloatArray:
    """The element warms later than the die whose temperature is logged, by one time constant."""
    lag_s = float(effect.detail["lag_s"])
    step = lag_s / 20
    grid = np.arange(0.0, float(moments.time_s.max()) + 2 * step, step)
    warmth = moments.warmth(grid)
    late = np.empty_like(warmth)
    late[0] = warmth[0]
    for i in range(1, len(grid)):
        late[i] = late[i - 1] + (warmth[i] - late[i - 1]) * step / lag_s
    late -= moments.courses[TEMPERATURE].reference
    return effect.size * np.interp(moments.time_s, grid, late)[..., None]


WAVES = 400


def _wander(effect: Hidden, true: FloatArray, moments: Moments) -> FloatArray:
    """A bias of exponential correlation: waves whose frequencies have its spectrum."""
    rng = np.random.default_rng(int(effect.detail["draw"]))
    frequency = rng.standard_cauchy((WAVES, 3)) / float(effect.detail["wander_tau_s"])
    phase = rng.uniform(0, 2 * np.pi, (WAVES, 3))
    time_s = moments.time_s.mean(axis=1)  # within a pose it stands still
    waves = np.cos(time_s[:, None, None] * frequency + phase).sum(axis=1)
    return effect.size * np.sqrt(2 / WAVES) * waves[:, None, :]


def _jump(effect: Hidden, true: FloatArray, moments: Moments) -> FloatArray:
    return effect.size * (moments.since_on() >= float(effect.detail["time_s"]))


def _bad_pose(effect: Hidden, true: FloatArray, moments: Moments) -> FloatArray:
    return effect.size * (moments.number == int(effect.detail["number"]))


def _periodic(effect: Hidden, true: FloatArray, moments: Moments) -> FloatArray:
    turns = moments.since_on() / float(effect.detail["period_s"])
    return effect.size * np.sin(2 * np.pi * turns + float(effect.detail["phase_rad"]))


EFFECTS: Mapping[str, Physics] = {
    "bias": Physics((3,), "{u}", _bias),
    "scale": Physics((3,), "1", _scale),
    "misalignment": Physics((3,), "rad", _misalignment),
    "frame_rotation": Physics((3,), "rad", _frame_rotation),
    "quadratic": Physics((3,), "1/({u})", _quadratic),
    "cubic": Physics((3,), "1/({u})²", _cubic),
    "asymmetry": Physics((3,), "1", _asymmetry),
    "cross_quadratic": Physics((3, 3), "1/({u})", _cross_quadratic),
    "temperature_bias": Physics((3,), "({u})/K", _temperature_bias),
    "temperature_scale": Physics((3,), "1/K", _temperature_scale),
    "bias_drift": Physics((3,), "({u})/s", _bias_drift),
    "scale_drift": Physics((3,), "1/s", _scale_drift),
    "warm_up": Physics((3,), "{u}", _warm_up),
    "hysteresis": Physics((3,), "{u}", _hysteresis),
    "vibration_rectification": Physics((3,), "({u})/(m/s²)²", _vibration_rectification),
    "g_sensitivity": Physics((3, 3), "(rad/s)/(m/s²)", _g_sensitivity),
    "g_squared_sensitivity": Physics((3,), "(rad/s)/(m/s²)²", _g_squared_sensitivity),
    "lever_arm": Physics((3,), "m", _lever_arm),
    "earth_rate": Physics((), "rad/s"),
    "reference_offset": Physics((), "{u}"),
    "reference_scale": Physics((), "1"),
    "reference_drift": Physics((), "1/s"),
    "direction_dependent_rate": Physics((), "1"),
    "column": Physics((3,), "({u})/unit of the column", _column),
    # Not in any catalogue of effects:
    "column_squared": Physics((3,), "({u})/(unit of the column)²", _column_squared),
    "memory": Physics((3,), "{u}", _memory),
    "temperature_squared": Physics((3,), "({u})/K²", _temperature_squared),
    "temperature_lag": Physics((3,), "({u})/K", _temperature_lag),
    "wander": Physics((3,), "{u}", _wander),
    "plate_wander": Physics((), "1"),
    "jump": Physics((3,), "{u}", _jump),
    "bad_pose": Physics((3,), "{u}", _bad_pose),
    "periodic": Physics((3,), "{u}", _periodic),
}

GYROSCOPE_ONLY = frozenset(
    {
        "g_sensitivity",
        "g_squared_sensitivity",
        "earth_rate",
        "reference_drift",
        "direction_dependent_rate",
        "plate_wander",
    }
)
