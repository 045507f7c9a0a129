"""Comparison of the axes of the gyroscope with those of the accelerometer, by the plate.

On a turning plate both triads point along its axis, ``f/|f| = σ R n`` with n the direction of the
gyro's rate, σ = ±1 the direction in which the run turns and R the rotation between the frames. R is
the orthogonal matrix nearest to ``Σ σ f nᵀ`` (Kabsch 1976), here with reflections, and σ is free
for each run: it is known from neither triad while their axes are in question. Within a case R is
near the identity. Near another of the 48 signed permutations, columns are exchanged or mirrored.
"""

from collections.abc import Mapping
from itertools import product

import numpy as np

from calib.consistency.signed_axes import (
    IDENTITY,
    SIGNED_PERMUTATIONS,
    nearest_signed,
    permutation_words,
)
from calib.errors import Contradiction
from calib.poses.imu_log import FloatArray, IntArray
from calib.poses.pose_set import PoseSet

FEWEST_POSES = 6  #: derived: three directions, each seen twice
LEAST_SPREAD = 0.05
"""Smallest singular value per pose, 1/3 if isotropic: a judgement; below it an axis is unseen."""

MOST_RUNS = 8  #: a limit of time
LARGEST_SCATTER = 0.2
"""Scatter of the directions about those that one rotation predicts, rad: a sensor ten centimetres
off the spindle at 45 rpm senses gravity turned by as much. Derived."""

OTHER_POSE = 0.5
"""Angle, rad, from which a pose cannot belong to the frame of the others: an exchange of axes turns
any pose by 60° or more, noise by a thousandth. Derived: half of it."""

OTHER_LENGTH = 0.03
"""Relative difference of a length that remains only if no exchange of axes explains it. Derived: an
effect of the sensor makes a per cent."""

SAME_DIRECTION = 0.05
"""Angle, rad, to the plate's axis once an exchange is undone. Derived: 13 mm off the spindle at 45
rpm; by chance one of the exchanges of a pose comes as near in 6 of 100."""

REPAIR = (
    "Name the columns in the right order (`columns`), or multiply the mirrored ones by -1. The "
    "lengths alone do not show it, and everything that joins both triads would be wrong."
)


def require_common_axes(poses: PoseSet, vector: FloatArray, sense: Mapping[str, float]) -> None:
    """Refuse turning poses in which the axes of the two triads contradict each other.

    Parameters
    ----------
    poses : PoseSet
        Of the gyro, with the calibrated specific force.
    vector : array, shape (n, 3)
        The calibrated rates.
    sense : mapping of run to float
        How the plate turns where the accelerometer shows it, +1 ccw, -1 cw; 0 or absent unknown.

    Raises
    ------
    Contradiction
        Naming which axes are exchanged or mirrored, of all poses, of a run or of a pose.
    """
    used = (poses.spin_rad_s != 0) & np.isfinite(poses.force).all(axis=1)
    used &= (np.linalg.norm(vector, axis=1) > 0) & (np.linalg.norm(poses.force, axis=1) > 0)
    runs = np.array(poses.run)[used]
    names = list(dict.fromkeys(runs))
    if used.sum() < FEWEST_POSES or len(names) > MOST_RUNS:
        return
    f, n = _units(poses.force[used]), _units(vector[used])
    relation = _relation(f, n, runs, sense)
    if relation is None:
        return
    rotation, sigma = relation
    if len(names) > 1:
        _compare_runs(f, n, runs, sense)
    angle = _angles(f, sigma[:, None] * n @ rotation.T)
    if np.median(angle) > LARGEST_SCATTER:
        length = np.linalg.norm(vector[used], axis=1) / poses.reference.magnitude[used]
        if np.max(np.abs(length - 1)) > OTHER_LENGTH:
            return  # some poses distort the fit, and all directions with it
        raise Contradiction(
            "gyroscope: on the turning plate both triads point along its axis, but no rotation "
            "joins their directions in these poses. Are the columns of both triads of the same "
            "sensor and of the same poses, and in the right order in every file?"
        )
    order = nearest_signed(rotation)
    if not np.array_equal(order, np.eye(3)):
        raise Contradiction(
            f"gyroscope: on the turning plate both triads point along its axis, but here only if "
            f"in the gyroscope's axes, or in the accelerometer's, {_in_words(order)}. {REPAIR}"
        )
    far = np.flatnonzero(angle > OTHER_POSE)
    if far.size:
        near = max(SAME_DIRECTION, 3 * float(np.median(angle)))
        odd = np.flatnonzero(used)[far]
        raise Contradiction(_of_one_pose(poses, vector, odd, sigma[far[0]] * rotation, near))


def _of_one_pose(
    poses: PoseSet, vector: FloatArray, odd: IntArray, rotation: FloatArray, near: float
) -> str:
    """Explanation for the first of the poses ``odd``: the exchange that resolves it, or none."""
    i, others = int(odd[0]), np.setdiff1d(np.arange(len(poses)), odd)
    counted = np.column_stack([poses.reading[others], np.ones(len(others))])
    affine = np.linalg.lstsq(counted, vector[others], rcond=None)[0]
    logged = np.linalg.solve(affine[:3].T, vector[i] - affine[3])
    force, turned = poses.force[i], float(poses.reference.magnitude[i])
    gyroscope = SIGNED_PERMUTATIONS @ logged @ affine[:3] + affine[3]  # (48, 3)
    length = np.abs(np.linalg.norm(gyroscope, axis=1) / turned - 1) < OTHER_LENGTH
    by = {"gyroscope": np.where(
        length, _angles(_units(gyroscope @ rotation.T), _units(force)), np.inf),
          "accelerometer": np.where(length[IDENTITY], _angles(
              _units(SIGNED_PERMUTATIONS @ force), _units(rotation @ vector[i])), np.inf)}
    triad = min(by, key=lambda each: float(by[each].min()))
    rate, gravity = float(np.linalg.norm(vector[i])), float(np.nanmedian(
        np.linalg.norm(poses.force, axis=1)))
    if by[triad].min() > near or abs(np.linalg.norm(force) / gravity - 1) > OTHER_LENGTH:
        return (
            f"{poses.label[i]}: its two triads are not readings of one pose (nor are those of "
            f"{len(odd) - 1} other poses): their directions differ, the gyroscope reads "
            f"{rate:.4g} rad/s by the gain and bias of the others while the plate turns at "
            f"{turned:.4g} rad/s, and the accelerometer {np.linalg.norm(force):.4g} m/s² where "
            f"gravity is {gravity:.4g} m/s². No exchange of its axes mends it: is one of them of "
            f"another file, range or zero? Record it again, or exclude it."
        )
    words = permutation_words(SIGNED_PERMUTATIONS[int(np.argmin(by[triad]))])
    return (
        f"{poses.label[i]}: on the turning plate both triads point along its axis, and in this "
        f"pose (and {odd.size - 1} others) they differ by more than {np.degrees(OTHER_POSE):.0f}°. "
        f"It fits if in its {triad}'s axes {words}, or its triads are of two poses. Record it "
        f"again, or exclude it."
    )


def _units(vectors: FloatArray) -> FloatArray:
    """Vectors (..., 3) at unit length."""
    return np.asarray(vectors / np.linalg.norm(vectors, axis=-1, keepdims=True))


def _angles(one: FloatArray, other: FloatArray) -> FloatArray:
    """Angles between unit vectors (..., 3), rad."""
    return np.asarray(np.arccos(np.clip((one * other).sum(axis=-1), -1.0, 1.0)))


def _in_words(order: FloatArray) -> str:
    """The exchange in words; first that which is less, where mirrored axes of the accelerometer
    would have mirrored the plate's direction."""
    words = permutation_words(order)
    if np.trace(order) < 0 and not np.array_equal(order, -np.eye(3)):
        return (f"{permutation_words(-order)} (in the accelerometer's axes this would mirror the "
                f"plate's direction too), or {words}")
    return words


def _relation(
    f: FloatArray, n: FloatArray, runs: np.ndarray, sense: Mapping[str, float]
) -> tuple[FloatArray, FloatArray] | None:
    """R (3, 3) and σ (m,) of unit vectors f and n (m, 3); None where the poses leave an axis open.

    Where no run's sense is known, R and all σ are known up to one common sign: then the R nearer to
    the identity is chosen.
    """
    names = list(dict.fromkeys(runs))
    sums = np.array([f[runs == name].T @ n[runs == name] for name in names])
    known = [sense.get(name, 0.0) for name in names]
    best: tuple[float, tuple[float, ...]] = (-1.0, ())
    for signs in product(*((s,) if s else (1.0, -1.0) for s in known)):
        total = np.tensordot(np.array(signs), sums, 1)
        best = max(best, (float(np.linalg.svd(total, compute_uv=False).sum()), signs))
    sign = np.array(best[1])
    u, singular, vt = np.linalg.svd(np.tensordot(sign, sums, 1))
    if singular[-1] < LEAST_SPREAD * len(f):
        return None
    rotation = u @ vt
    if not any(known) and np.trace(rotation) < 0:
        rotation, sign = -rotation, -sign
    return rotation, sign[[names.index(name) for name in runs]]


def _compare_runs(
    f: FloatArray, n: FloatArray, runs: np.ndarray, sense: Mapping[str, float]
) -> None:
    """Refuse a run whose axes are exchanged where those of other runs are not."""
    orders: dict[str, FloatArray] = {}
    for name in dict.fromkeys(runs):
        of_run = f[runs == name], n[runs == name]
        relation = _relation(*of_run, runs[runs == name], sense) if len(of_run[0]) > 2 else None
        if relation is None:
            continue
        rotation, sigma = relation
        if np.median(_angles(of_run[0], sigma[:, None] * of_run[1] @ rotation.T)) < LARGEST_SCATTER:
            orders[name] = nearest_signed(rotation)
    odd = [name for name, order in orders.items() if not np.array_equal(order, np.eye(3))]
    if odd and len(odd) < len(orders):
        raise Contradiction(
            f"{odd[0]}: in the poses of this run the gyroscope and the accelerometer point along "
            f"the plate's axis only if in the axes of one of them {_in_words(orders[odd[0]])}, "
            f"unlike in the other runs. {REPAIR}"
        )
