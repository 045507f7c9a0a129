"""A lot: many sensors of one make, their poses as mean counts, drawn all at once.

The physics of :mod:`tests.world.physics` for accelerometers in poses at rest that last one sample:
what truly acts along the axes, the hidden effect by its own law, gain, offset, and the noise of a
mean. One evening after another with its samples takes 0.1 s; a study of 100,000 has none of that
time. :mod:`tests.world.turning_lot` has the gyroscopes.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from tests.world.bench import TEMPERATURE, Course, Design
from tests.world.hidden import EFFECTS, Hidden, TriadName
from tests.world.imu import MPU_SPREAD, FloatArray, Triad
from tests.world.lot_sizes import IntArray, rows_of, sizes_of
from tests.world.moments import Moments
from tests.world.physics import courses
from tests.world.sizes import WARM_UP_TAU_S

POSE_S, REST_S = 8.0, 4.0
SAMPLE_RATE_HZ = 100.0
WARMING_K = 4.0  # by which the sensor warms through an evening, give or take a third


@dataclass(frozen=True, eq=False)
class Lot:
    """S evenings of n poses.

    Attributes
    ----------
    counts, true_counts : array, shape (S, n, 3)
        Means of the poses, and what they would be without noise.
    sd_counts : array, shape (S, n, 3)
        The sds that the samples would state.
    columns : mapping of name to array, shape (S, n)
        Temperature, and every other quantity that is logged.
    time_s : array, shape (n,)
    unit : array of int, shape (S,)
        Which sensor each evening is of.
    size : array, shape (S, k)
        Size of the hidden effect.
    magnitude : array, shape (S, n)
        The reference that is stated: gravity in m/s², the plate's rate in rad/s.
    triad : Triad
        The typical unit.
    force_m_s2 : array, shape (S, n, 3), or None
        Of gyroscopes the mean specific force in their poses.
    rate_sd, spin_rad_s : float
        Of gyroscopes the sd of the stated rate, and the rate of the plate with its sign.
    """

    counts: FloatArray
    true_counts: FloatArray
    sd_counts: FloatArray
    columns: Mapping[str, FloatArray]
    time_s: FloatArray
    unit: IntArray
    size: FloatArray
    magnitude: FloatArray
    triad: Triad
    force_m_s2: FloatArray | None = None
    rate_sd: float = 0.0
    spin_rad_s: float = 0.0

    def __len__(self) -> int:
        return len(self.counts)


@dataclass(frozen=True)
class LotPlan:
    """What a lot is to be.

    ``hidden`` is the name of an effect, ``beside`` that of a second one, ``common_sd`` and
    ``spread_sd`` its size in the whole lot and the spread of its sizes over the sensors, ``own_sd``
    the lowest and the highest size that every evening has in a direction of its own (log-uniform);
    all are root mean squares over the pose equations in noise units. ``cauchy_sd``, in place of
    ``own_sd``, is the scale of a half-Cauchy distribution of such sizes, of which the smallest are
    left out. ``evening_sd`` is by how many sds of a pose mean a bias differs from evening to
    evening, ``noise_dof`` the degrees of freedom that a pose adds to the estimate of its own noise.
    """

    sensors: int
    evenings: int = 1
    hidden: str | None = None
    common_sd: float = 0.0
    spread_sd: float = 0.0
    own_sd: tuple[float, float] | None = None
    cauchy_sd: float | None = None
    beside: str | None = None
    evening_sd: float = 0.0
    noise_dof: float = 2.0


def draw_lot(design: Design, plan: LotPlan, seed: int) -> Lot:
    """Draw the evenings of ``plan`` with the poses at rest of ``design``."""
    rng = np.random.default_rng([seed, 60])
    typical = design.sensor.accelerometer
    sets = plan.sensors * plan.evenings
    unit = np.repeat(np.arange(plan.sensors), plan.evenings)
    up, time_s, soak_c = _directions(design, sets, rng)
    n = len(time_s)
    force = design.site.gravity_m_s2 * up
    axes, gain, offset = unlike(typical, plan.sensors, rng)
    true = np.einsum("sij,snj->sni", axes[unit], force)
    sd = typical.pose_mean_sd(round(POSE_S * SAMPLE_RATE_HZ), 1 / SAMPLE_RATE_HZ)  # SI
    columns = {TEMPERATURE: warmth_of(design.temperature, time_s, sets, rng) + soak_c}
    columns |= {name: course_of(course, time_s, sets, rng)
                for name, course in design.columns.items()}
    size, error = np.zeros((sets, 0)), np.zeros((sets, n, 3))
    detail = _detail(time_s, np.random.default_rng([seed, 61]))
    for name in (plan.hidden, plan.beside):
        if name is None:
            continue
        if name == "wander":
            each = _wandering(time_s, sets, rng)
        else:
            each = _unit_errors(name, design, true, force, time_s, columns, detail)
        own = sizes_of(plan, unit, rows_of(name, each, up / sd), rng)
        error = error + np.einsum("snik,sk->sni", each, own)
        size = np.hstack([size, own])
    without_noise, counts, stated = in_counts(
        plan, typical, gain[unit], offset[unit], true + error, sd, rng)
    return Lot(
        counts=counts,
        true_counts=without_noise,
        sd_counts=stated,
        columns=columns,
        time_s=time_s,
        unit=unit,
        size=size,
        magnitude=np.full((sets, n), design.site.gravity_m_s2),
        triad=typical,
    )


def _detail(time_s: FloatArray, rng: np.random.Generator) -> dict[str, float | int | str]:
    """A time constant, a moment, a pose and a period; each effect takes what it needs."""
    first, last = float(time_s[0]), float(time_s[-1])
    return {
        "tau_s": rng.uniform(*WARM_UP_TAU_S),
        "time_s": first + rng.uniform(0.15, 0.85) * (last - first),
        "number": int(rng.integers(len(time_s))),
        "period_s": rng.uniform(0.3, 1.5) * (last - first),
        "phase_rad": rng.uniform(0, 2 * np.pi),
    }


WANDER_SPANS = (0.05, 3.0)
"""Lowest and highest correlation time of a wandering bias over the length of the evening."""


def _wandering(time_s: FloatArray, sets: int, rng: np.random.Generator) -> FloatArray:
    """Errors (S, n, 3, 3) of biases that wander by one along each axis, evening by evening."""
    span = np.exp(rng.uniform(*np.log(WANDER_SPANS)))
    course = Course(0.0, wander_sd=1.0, wander_tau_s=span * float(np.ptp(time_s)))
    each = np.zeros((sets, len(time_s), 3, 3))
    for k in range(3):
        each[:, :, k, k] = course_of(course, time_s, sets, rng)
    return each


def unlike(
    typical: Triad, sensors: int, rng: np.random.Generator
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Axes (sensors, 3, 3), gains and offsets in counts (sensors, 3) of units of one make."""
    lean = MPU_SPREAD.tilt_rad * np.triu(rng.standard_normal((sensors, 3, 3)), 1)
    axes = typical.axes + lean
    axes /= np.linalg.norm(axes, axis=2, keepdims=True)
    gain = typical.gain * (1 + MPU_SPREAD.gain * rng.standard_normal((sensors, 3)))
    half_span = 2 ** (typical.bits - 1)
    return axes, gain, MPU_SPREAD.offset * half_span * rng.standard_normal((sensors, 3))


def in_counts(
    plan: LotPlan, typical: Triad, gain: FloatArray, offset: FloatArray, felt: FloatArray,
    sd: FloatArray, rng: np.random.Generator,
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Pose means (S, n, 3) of what the axes felt, SI, as counts: without noise, with noise of
    ``sd`` (3,), SI, and the sds that each evening's samples state. ``gain`` and ``offset``, (S, 3),
    are those of each evening's sensor.
    """
    sets, n, _ = felt.shape
    sd, dof = sd * typical.gain, plan.noise_dof * n
    offset = offset + plan.evening_sd * sd * rng.standard_normal((sets, 3))
    without_noise = gain[:, None] * felt + offset[:, None] + typical.offset
    noise = sd * rng.standard_normal(felt.shape)
    stated = np.sqrt(rng.chisquare(dof, (sets, 1, 1)) / dof) * sd
    return without_noise, without_noise + noise, np.broadcast_to(stated, felt.shape)


def _directions(
    design: Design, sets: int, rng: np.random.Generator
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Directions that face up (S, n, 3), those of each run in an order of their own; the poses'
    times (n,), and the warmth that a chamber adds in each (n,).
    """
    runs = [run for run in design.runs if run.motion is None]
    rest = np.vstack([run.directions for run in runs])
    chance, first = rng.random((sets, len(rest))), 0
    order, time_s, soak_c = [], [], []
    begins_s = 0.0
    for run in runs:
        count = len(run.directions)
        order.append(first + np.argsort(chance[:, first : first + count], axis=1))
        begins_s += run.lead_s
        time_s.append(begins_s + POSE_S / 2 + (POSE_S + REST_S) * np.arange(count))
        soak_c.append(np.full(count, run.soak_c))
        first, begins_s = first + count, begins_s + (POSE_S + REST_S) * count
    up = rest[np.hstack(order)]
    up = up + np.deg2rad(design.jitter_deg) * rng.standard_normal(up.shape)
    up /= np.linalg.norm(up, axis=2, keepdims=True)
    return up, np.concatenate(time_s), np.concatenate(soak_c)


def warmth_of(
    course: Course, time_s: FloatArray, sets: int, rng: np.random.Generator
) -> FloatArray:
    """Temperature (S, n): it rises towards the evening's own plateau."""
    rise = WARMING_K * (1 + rng.standard_normal((sets, 1)) / 3)
    start = course.start + rng.standard_normal((sets, 1))
    return start + rise * (1 - np.exp(-time_s / (time_s[-1] / 2)))


def course_of(
    course: Course, time_s: FloatArray, sets: int, rng: np.random.Generator
) -> FloatArray:
    """Another quantity (S, n) in the poses at ``time_s`` (n,): it wanders about its course."""
    kick = course.wander_sd * rng.standard_normal((sets, len(time_s)))
    wander = kick.copy()
    for i, keep in enumerate(np.exp(-np.diff(time_s) / course.wander_tau_s), 1):
        wander[:, i] = keep * wander[:, i - 1] + np.sqrt(1 - keep**2) * kick[:, i]
    return wander + course.start - course.rise * np.expm1(-time_s / course.tau_s)


def _unit_errors(
    name: str, design: Design, true: FloatArray, force: FloatArray, time_s: FloatArray,
    columns: Mapping[str, FloatArray], detail: Mapping[str, float | int | str],
) -> FloatArray:
    """Errors (S, n, 3, k) along the axes per unit of each of the k sizes of an effect.

    Every pose of every evening is one pose of a single long run.
    """
    sets, n, _ = true.shape
    before = np.concatenate([np.zeros((sets, 1, 3)), true[:, :-1]], axis=1)
    moments = Moments(
        time_s=np.tile(time_s, sets)[:, None],
        columns={name: values.reshape(-1, 1) for name, values in columns.items()},
        courses=courses(design),
        rate=np.zeros((sets * n, 1, 3)),
        force=force.reshape(-1, 1, 3),
        spin=np.zeros((sets * n, 1, 3)),
        spin_up=np.zeros((sets * n, 1, 3)),
        vibration_m_s2=np.zeros((sets * n, 1, 1)),
        triad=design.sensor.accelerometer,
        before=before.reshape(-1, 1, 3),
        number=np.tile(np.arange(n), sets)[:, None, None],
        warmth=lambda at: np.full_like(at, design.temperature.start),
    )
    along = true.reshape(-1, 1, 3)
    errors = errors_per_unit(name, "accelerometer", along, moments, detail)
    return errors.mean(axis=1).reshape(sets, n, 3, -1)


def errors_per_unit(
    name: str, triad: TriadName, true: FloatArray, moments: Moments,
    detail: Mapping[str, float | int | str],
) -> FloatArray:
    """Errors (p, samples, 3, k) of an effect along the axes per unit of each of its k sizes."""
    shape = EFFECTS[name.partition(":")[0]].shape
    units = np.eye(int(np.prod(shape))).reshape(-1, *shape)
    return np.stack([
        np.broadcast_to(Hidden(name, triad, unit, detail).error(true, moments),
                        true.shape)
        for unit in units
    ], axis=-1)
