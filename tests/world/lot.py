"""A lot: many accelerometers of one make, their poses at rest as mean counts, drawn all at once.

The physics of :mod:`tests.world.physics` for poses that last one sample: what truly acts along the
axes, the hidden effect by its own law, gain, offset, and the noise of a mean. One evening after
another with its samples takes 0.1 s; a study of 100,000 has none of that time.
"""

from dataclasses import dataclass

import numpy as np

from tests.world.bench import TEMPERATURE, Course, Design
from tests.world.hidden import Hidden
from tests.world.imu import MPU_SPREAD, FloatArray, Triad
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
    temperature_c : array, shape (S, n)
    time_s : array, shape (n,)
    unit : array of int, shape (S,)
        Which sensor each evening is of.
    size : array, shape (S, k)
        Size of the hidden effect.
    gravity_m_s2 : float
    triad : Triad
        The typical unit.
    """

    counts: FloatArray
    true_counts: FloatArray
    sd_counts: FloatArray
    temperature_c: FloatArray
    time_s: FloatArray
    unit: FloatArray
    size: FloatArray
    gravity_m_s2: float
    triad: Triad

    def __len__(self) -> int:
        return len(self.counts)


@dataclass(frozen=True)
class LotPlan:
    """What a lot is to be.

    ``hidden`` is the name of an effect, ``common_sd`` and ``spread_sd`` its size in the whole lot
    and the spread of its sizes over the sensors, ``own_sd`` the lowest and the highest size that
    every evening has in a direction of its own (log-uniform); all are root mean squares over the
    pose equations in noise units. ``evening_sd`` is by how many sds of a pose mean a bias differs
    from evening to evening, ``noise_dof`` the degrees of freedom that a pose adds to the estimate
    of its own noise.
    """

    sensors: int
    evenings: int = 1
    hidden: str | None = None
    common_sd: float = 0.0
    spread_sd: float = 0.0
    own_sd: tuple[float, float] | None = None
    evening_sd: float = 0.0
    noise_dof: float = 2.0


def draw_lot(design: Design, plan: LotPlan, seed: int) -> Lot:
    """Draw the evenings of ``plan`` with the poses at rest of ``design``."""
    rng = np.random.default_rng([seed, 60])
    typical = design.sensor.accelerometer
    sets = plan.sensors * plan.evenings
    unit = np.repeat(np.arange(plan.sensors), plan.evenings)
    up, time_s = _directions(design, sets, rng)
    n = len(time_s)
    force = design.site.gravity_m_s2 * up
    lean = MPU_SPREAD.tilt_rad * np.triu(rng.standard_normal((plan.sensors, 3, 3)), 1)
    axes = typical.axes + lean
    axes /= np.linalg.norm(axes, axis=2, keepdims=True)
    true = np.einsum("sij,snj->sni", axes[unit], force)
    gain = typical.gain * (1 + MPU_SPREAD.gain * rng.standard_normal((plan.sensors, 3)))
    half_span = 2 ** (typical.bits - 1)
    offset = MPU_SPREAD.offset * half_span * rng.standard_normal((plan.sensors, 3))
    sd = typical.pose_mean_sd(round(POSE_S * SAMPLE_RATE_HZ), 1 / SAMPLE_RATE_HZ)  # SI
    warmth = _warmth(design.temperature, time_s, sets, rng)
    size, error = np.zeros((sets, 0)), np.zeros((sets, n, 3))
    if plan.hidden is not None:
        tau_s = np.random.default_rng([seed, 61]).uniform(*WARM_UP_TAU_S)
        each = _unit_errors(plan.hidden, design, true, force, time_s, warmth, tau_s)
        rows = _rows_of(plan.hidden, each, up / sd)
        if plan.own_sd is None:
            size = _sizes(plan, rows, rng)[unit]
        else:
            size = _own_sizes(plan.own_sd, rows, rng)
        error = np.einsum("snik,sk->sni", each, size)
    offset_s = offset[unit] + plan.evening_sd * (sd * typical.gain) * rng.standard_normal((sets, 3))
    noise = sd * typical.gain * rng.standard_normal((sets, n, 3))
    without_noise = gain[unit, None] * (true + error) + offset_s[:, None] + typical.offset
    dof = plan.noise_dof * n
    stated = np.sqrt(rng.chisquare(dof, (sets, 1, 1)) / dof) * sd * typical.gain
    return Lot(
        counts=without_noise + noise,
        true_counts=without_noise,
        sd_counts=np.broadcast_to(stated, noise.shape),
        temperature_c=warmth,
        time_s=time_s,
        unit=unit,
        size=size,
        gravity_m_s2=design.site.gravity_m_s2,
        triad=typical,
    )


def _directions(
    design: Design, sets: int, rng: np.random.Generator
) -> tuple[FloatArray, FloatArray]:
    """Directions that face up (S, n, 3) in an order of their own, and the poses' times (n,)."""
    rest = np.vstack([run.directions for run in design.runs if run.motion is None])
    order = np.argsort(rng.random((sets, len(rest))), axis=1)
    up = rest[order] + np.deg2rad(design.jitter_deg) * rng.standard_normal((sets, len(rest), 3))
    up /= np.linalg.norm(up, axis=2, keepdims=True)
    return up, POSE_S / 2 + (POSE_S + REST_S) * np.arange(len(rest))


def _warmth(
    course: Course, time_s: FloatArray, sets: int, rng: np.random.Generator
) -> FloatArray:
    """Temperature (S, n): it rises towards the evening's own plateau."""
    rise = WARMING_K * (1 + rng.standard_normal((sets, 1)) / 3)
    start = course.start + rng.standard_normal((sets, 1))
    return start + rise * (1 - np.exp(-time_s / (time_s[-1] / 2)))


def _unit_errors(
    name: str, design: Design, true: FloatArray, force: FloatArray, time_s: FloatArray,
    warmth: FloatArray, tau_s: float,
) -> FloatArray:
    """Errors (S, n, 3, k) along the axes per unit of each of the k sizes of an effect.

    Every pose of every evening is one pose of a single long run; ``tau_s`` is the time constant of
    a warm-up.
    """
    sets, n, _ = true.shape
    before = np.concatenate([np.zeros((sets, 1, 3)), true[:, :-1]], axis=1)
    moments = Moments(
        time_s=np.tile(time_s, sets)[:, None],
        columns={TEMPERATURE: warmth.reshape(-1, 1)},
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
    shape = Hidden(name, "accelerometer", _size_like(name)).physics.shape
    units = np.eye(int(np.prod(shape))).reshape(-1, *shape)
    along = true.reshape(-1, 1, 3)
    detail = {"tau_s": tau_s}
    each = [np.broadcast_to(
        Hidden(name, "accelerometer", unit, detail).error(along, moments), along.shape)
        for unit in units]
    return np.stack([e.reshape(sets, n, 3) for e in each], axis=-1)


def _size_like(name: str) -> FloatArray:
    return np.zeros((3, 3) if name == "cross_quadratic" else 3)


def _rows_of(name: str, each: FloatArray, whitening: FloatArray) -> FloatArray:
    """What an effect adds to the pose equations per unit of each size, noise units, (S, n, k)."""
    rows = np.einsum("sni,snik->snk", whitening, each)
    if name.endswith(("_bias", "_scale", "_drift", "warm_up")):
        rows = rows - rows.mean(axis=1, keepdims=True)  # what does not vary is a bias or a gain
    return rows


def _sizes(plan: LotPlan, rows: FloatArray, rng: np.random.Generator) -> FloatArray:
    """Sizes (sensors, k): one for all, and a spread, each of the root mean square asked for."""
    k = rows.shape[2]

    def of_size(wanted: float, direction: FloatArray) -> FloatArray:
        rms = np.sqrt(np.mean(np.einsum("snk,k->sn", rows, direction) ** 2))
        return wanted * direction / rms

    common = of_size(plan.common_sd, rng.standard_normal(k))
    per_axis = np.array([of_size(1.0, axis)[j] for j, axis in enumerate(np.eye(k))])
    spread = plan.spread_sd / np.sqrt(k) * per_axis * rng.standard_normal((plan.sensors, k))
    return common + spread


def _own_sizes(
    limits: tuple[float, float], rows: FloatArray, rng: np.random.Generator
) -> FloatArray:
    """Sizes (S, k) of evenings that each have a direction and a root mean square of their own."""
    sets, _, k = rows.shape
    direction = rng.standard_normal((sets, k))
    rms = np.sqrt(np.mean(np.einsum("snk,sk->sn", rows, direction) ** 2, axis=1))
    wanted = np.exp(rng.uniform(*np.log(limits), sets))
    return direction * (wanted / rms)[:, None]
