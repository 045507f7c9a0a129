"""Poses made for an answer that is known: what the readings must be so that theta fits exactly.

The laws and the solver's known answers use these. They invert the model of :mod:`calib.fit.model`
by its own statement (s + T F(T⁻¹ s) theta = M y + c), so they check that fitting, correction and
Jacobian agree with each other; what they mean physically is checked against the simulated bench.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from scipy.spatial.transform import Rotation

from calib.effects.catalogue import BASE
from calib.effects.effect import EFFECTS
from calib.fit.model import Model
from calib.fit.rows.residuals import Equations
from calib.poses.attitudes import natural_directions
from calib.poses.conditions import Conditions
from calib.poses.data_sheet import TriadSpec
from calib.poses.imu_log import FloatArray, Triad
from calib.poses.pose_set import PoseSet
from calib.poses.reference import CommonError, constant_reference, join_references

MODEL = Model.of(BASE)
SPECS = {
    "accelerometer": TriadSpec(20.0, 16, "twos-complement"),
    "gyroscope": TriadSpec(8.0, 16, "offset-binary"),
    "magnetometer": TriadSpec(100.0, 16, "twos-complement"),
}

GRAVITY = 9.81
SLOW, FAST = 100 / 180 * np.pi, 200 / 180 * np.pi
FIELD_UT = 50.0
DIP = np.array([0.4, -1.1, 0.3])  #: turn of the field against gravity, case by case the same
SD: Mapping[str, float] = {"accelerometer": 4e-3, "gyroscope": 3e-4, "magnetometer": 0.02}
STATED_SD = 1e-4
POSE_S = 30.0
LEAN = np.array([1.08, 0.05, -0.31])
"""Turn of the whole set of poses, so that no axis lies level in any of them and memory of the
pose before has a sign that noise does not flip."""
BASE_THETA = np.array([0.02, -0.013, 0.007, 0.011, -0.008, 0.015, 0.004, -0.006, 0.009])
"""Bias (of a rad/s or ten times that in m/s²), scale and misalignment of a low-cost unit."""

BIAS_FACTOR = {"accelerometer": 10.0, "gyroscope": 1.0, "magnetometer": 50.0}
WALK_TAU_S = 700.0  #: correlation time of a bias that wanders, s


def tilted(directions: FloatArray, rng: np.random.Generator, jitter_deg: float = 3.0) -> FloatArray:
    """Unit vectors near ``directions``, as hands and wedges place them, (n, 3)."""
    moved = directions + np.radians(jitter_deg) * rng.standard_normal(directions.shape)
    return moved / np.linalg.norm(moved, axis=1, keepdims=True)


def made_poses(
    triad: Triad,
    speeds: Sequence[float],
    *,
    seed: int = 0,
    corners: bool = False,
    jitter_deg: float = 3.0,
    shared_sd: float = 0.0,
) -> PoseSet:
    """Poses that read the truth: one pass through the directions for every speed, 0 for rest.

    For the accelerometer every speed is a pass under gravity, on a plate turning at that speed.
    ``shared_sd`` is the relative sd that the poses of one speed have in common.
    """
    rng = np.random.default_rng([seed, 77])
    natural = natural_directions(corners) @ Rotation.from_rotvec(LEAN).as_matrix().T
    up = np.concatenate([tilted(natural, rng, jitter_deg) for _ in speeds])
    spin = np.repeat(np.asarray(speeds, float), len(natural))
    n = len(up)
    time_s = POSE_S * rng.permutation(n)
    warmth = 10 * np.sin(time_s / 700.0) + 3 * rng.standard_normal(n)
    references = []
    for i, speed in enumerate(speeds):
        size = {"accelerometer": GRAVITY, "magnetometer": FIELD_UT}.get(triad, abs(speed))
        shared = [CommonError(f"rate {i}", shared_sd * size, of_setting=True)]
        references.append(constant_reference(len(natural), size, shared if size else []))
    vector = {"accelerometer": GRAVITY * up, "gyroscope": spin[:, None] * up,
              "magnetometer": FIELD_UT * up @ Rotation.from_rotvec(DIP).as_matrix()}[triad]
    return PoseSet(
        triad=triad,
        label=tuple(f"pose {i + 1}" for i in range(n)),
        run=tuple(f"run {i}" for i in range(len(speeds)) for _ in natural),
        reading=vector,
        sd=np.full((n, 3), SD[triad]),
        force=GRAVITY * up,
        vibration=np.tile(0.01 * rng.uniform(0.5, 2.0, (n, 1)) * (1 + np.abs(spin[:, None])), 3),
        spin_rad_s=spin,
        time_s=time_s,
        expected=np.zeros((n, 3)),
        reference=join_references(references),
        columns={
            "temperature_c": 30 + warmth,
            "humidity_pct": 45 + 5 * rng.standard_normal(n),
        },
    )


def rich_poses(triad: Triad, seed: int = 0, **kinds: float) -> PoseSet:
    """All that makes effects visible: speeds, directions, rest, corners, a course of heat."""
    speeds = (SLOW, -SLOW, FAST, -FAST, 0.0) if triad == "gyroscope" else (0.0, SLOW, FAST)
    return made_poses(triad, speeds, seed=seed, corners=True, **kinds)  # type: ignore[arg-type]


def base_theta(model: Model, triad: Triad) -> FloatArray:
    """Theta (p,) with the bias, scale and misalignment of a low-cost unit, zero elsewhere."""
    theta = np.zeros(model.size)
    factor = np.where(np.arange(9) < 3, BIAS_FACTOR[triad], 1.0)
    for i, name in enumerate(("bias", "scale", "misalignment")):
        if name in model.names:
            theta[model.slices()[name]] = (factor * BASE_THETA)[3 * i : 3 * i + 3]
    return theta


def read_through(
    poses: PoseSet, model: Model, theta: FloatArray, shapes: Mapping[str, float] | None = None
) -> PoseSet:
    """``poses`` (which read the truth) as a sensor with ``theta`` reads them."""
    true = poses.reading
    turning = ~poses.reference.is_null
    at = poses.conditions(true)
    reference = model.acting_on("reference")
    if reference:
        columns = np.concatenate([e.evaluate(at) for e in reference], axis=1)
        size = poses.reference.magnitude + columns @ theta[model.positions(reference)]
        gain = size / np.where(turning, poses.reference.magnitude, 1)
        true = np.where(turning[:, None], true * gain[:, None], poses.expected)
    matrix, offset = linear_form(model, theta)
    to_axes = np.linalg.inv(matrix / np.diag(matrix))  # T of eq. (2): unit upper triangular
    before = poses.conditions(true, true @ to_axes.T).previous
    held = replace(Equations.of(poses, Model.of(())).conditions(true), previous=before)
    linear = true.copy()
    for effect in model.acting_on("sensor"):
        size = theta[model.slices()[effect.name]]
        shape = (shapes or {}).get(effect.name)
        if effect.orthogonal:
            linear = linear + effect.evaluate(held, shape) @ size
            continue
        felt = replace(held, vector=held.vector @ to_axes.T)
        error = effect.evaluate(felt, shape) @ size  # of every sensitive axis
        linear = linear + np.linalg.solve(to_axes, error.T).T
    return replace(poses, reading=np.linalg.solve(matrix, (linear - offset).T).T)


def linear_form(model: Model, theta: FloatArray) -> tuple[FloatArray, FloatArray]:
    """M (3, 3) and c (3,) of ``M y + c``, written out from eq. (1)-(2)."""
    values = {name: np.zeros(3) for name in ("bias", "scale", "misalignment")}
    values |= {name: theta[where] for name, where in model.slices().items() if name in values}
    (mx, my, mz), matrix = values["misalignment"], np.eye(3) - np.diag(values["scale"])
    matrix -= np.array([[0, mz, my], [0, 0, mx], [0, 0, 0]])
    return matrix, -values["bias"]


def with_noise(poses: PoseSet, rng: np.random.Generator) -> PoseSet:
    """Readings and references off by a draw of their stated sds."""
    noise = poses.sd * rng.standard_normal(poses.reading.shape)
    reference = poses.reference
    shared = reference.common @ rng.standard_normal(reference.common.shape[1])
    stated = np.where(reference.is_null, 0.0, reference.magnitude + shared)
    return replace(
        poses,
        reading=poses.reading + noise,
        reference=replace(reference, magnitude=stated),
    )


def some_conditions(triad: Triad, n: int = 12, seed: int = 1) -> Conditions:
    """Complete conditions of ``n`` rows: nothing is NaN, no axis is near zero."""
    poses = rich_poses(triad, seed)
    rng = np.random.default_rng(seed)
    rows = rng.permutation(len(poses))[:n]
    at = poses.conditions(poses.reading)
    return at.take(rows)


def noisy(poses: PoseSet, seed: int, model: Model = MODEL) -> PoseSet:
    """``poses`` read by a low-cost unit, with a draw of every stated error."""
    read = read_through(poses, model, base_theta(model, poses.triad))
    return with_noise(read, np.random.default_rng([seed, 5]))


def chosen(poses: PoseSet, rows: FloatArray | list[int]) -> PoseSet:
    """These poses alone, or several times."""
    return replace(poses.take(rows), time_s=30.0 * np.arange(len(rows)))


def pairs(names: list[str]) -> list[tuple[str, Triad]]:
    """Every effect of these names with every triad it is for."""
    return [(name, triad) for name in names for triad in EFFECTS[name].triads]


def walk(time_s: FloatArray, random: np.random.Generator) -> FloatArray:
    """An Ornstein-Uhlenbeck course of unit variance and ``WALK_TAU_S``, step by step, (n, 3)."""
    order = np.argsort(time_s)
    course, value, last = np.zeros((len(time_s), 3)), random.normal(size=3), time_s[order[0]]
    for i in order:
        keep = np.exp(-(time_s[i] - last) / WALK_TAU_S)
        value, last = keep * value + np.sqrt(1 - keep**2) * random.normal(size=3), time_s[i]
        course[i] = value
    return course
