"""Terms of the wave rows of a leaning plate that depend on the rings of a set of poses.

See :mod:`calib.fit.rows.wave_rows` for the rows.
"""

from collections.abc import Sequence
from dataclasses import dataclass, fields

import numpy as np

from calib.fit.rows.initial_estimate import Start
from calib.fit.stacked import Stacked
from calib.poses.imu_log import FloatArray
from calib.poses.pose_set import PoseSet
from calib.poses.reference import room_names, tilt_name
from calib.poses.runs.ring import ANGLES, DIRECTION_SD_RAD, TO_WAVES, Ring
from calib.poses.samples.in_step import HARMONICS


@dataclass(frozen=True, eq=False)
class RingTerms(Stacked):
    """Terms of the d' rows of the w rings of each of S sets, apart from their readings.

    Attributes
    ----------
    row_sd : array, shape (..., d')
        The sds of the rows, SI.
    across : array, shape (..., w, 2, 3)
        Of a gyroscope the directions t; (..., 0, 2, 3) of an accelerometer.
    stated : array, shape (..., d')
        What the rows should show, SI.
    common : array, shape (..., d', q)
        What an sd of each common error adds to a row's reference, in its sds.
    by_wow : array, shape (..., w, 4, 3)
        The part of the waves that the wow of the plate makes, SI.
    """

    row_sd: FloatArray
    across: FloatArray
    stated: FloatArray
    common: FloatArray
    by_wow: FloatArray

    @classmethod
    def of(cls, sets: Sequence[PoseSet], starts: Start) -> "RingTerms":
        """The terms of S sets with rings, which start from ``starts``."""
        of_sets = []
        for k, poses in enumerate(sets):
            assert poses.ring is not None
            terms = _of_gyroscope if poses.triad == "gyroscope" else _of_accelerometer
            of_sets.append(terms(poses, poses.ring, starts.take(k)))
        return cls(*(np.array([getattr(one, f.name) for one in of_sets]) for f in fields(cls)))


def waves_round(values: FloatArray, axis: int) -> FloatArray:
    """Cosine and sine, once and twice per turn, of values round rings of w k points along an axis.

    That axis becomes (w, 4), in their unit. A constant has no wave, not even by rounding.
    """
    at = values.ndim + axis
    rings = values.reshape(*values.shape[:at], -1, ANGLES, *values.shape[at + 1 :])
    rings = rings - np.take(rings, [0], axis=at + 1)
    return np.asarray(np.moveaxis(np.tensordot(rings, TO_WAVES, axes=(at + 1, 1)), -1, at + 1))


def _of_gyroscope(poses: PoseSet, ring: Ring, start: Start) -> RingTerms:
    across = _across(poses, ring, start.matrix, start.offset)
    sd = np.sqrt(np.einsum("wij,wj->wi", (across @ start.matrix) ** 2, ring.sd[:, 0] ** 2))
    row_sd = np.tile(sd, (1, 2))  # cosine, then sine
    along, ahead = _of_the_room(ring, across).transpose(1, 0, 2)  # (w, 4)
    stated = (ring.vertical_rad_s * np.sin(ring.tilt_rad))[:, None] * along
    shown = np.stack([along * np.cos(ring.tilt_rad)[:, None], ahead])
    common = _room(poses, ring, shown) / row_sd.reshape(-1, 1)
    by_wow = np.zeros((len(ring.place), len(TO_WAVES), 3))
    return RingTerms(row_sd.ravel(), across, stated.ravel(), common, by_wow)


def _of_accelerometer(poses: PoseSet, ring: Ring, start: Start) -> RingTerms:
    waves = waves_round(ring.reading.reshape(-1, 3) @ start.matrix.T, -2)
    by_wow = _by_wow(ring.wow, start.corrected(poses.reading[ring.place]), waves)
    wave = (waves - by_wow)[:, :2]
    unit = wave / np.linalg.norm(wave, axis=2, keepdims=True)
    sd = np.sqrt(np.einsum("wci,wi->wc", (unit @ start.matrix) ** 2, ring.sd[:, 0] ** 2))
    once = np.column_stack([sd, np.sqrt((sd**2).mean(axis=1))])
    size = ring.gravity_m_s2 * np.sin(ring.tilt_rad)
    of_twice = np.sqrt(ring.sd[ring.twice, 1] ** 2 @ start.matrix.T**2)
    row_sd = np.concatenate([once.ravel(), np.tile(of_twice, (1, 2)).ravel()])
    stated, common = np.zeros(len(row_sd)), np.zeros((len(row_sd), poses.reference.common.shape[1]))
    stated[: once.size] = np.column_stack([size, size, np.zeros(len(size))]).ravel()
    common[: once.size] = _gravity_and_tilt(poses, ring, size) / once.reshape(-1, 1)
    return RingTerms(row_sd, np.zeros((0, 2, 3)), stated, common, by_wow)


def _by_wow(wow: FloatArray, mean: FloatArray, waves: FloatArray) -> FloatArray:
    """Force that wow (w, 4) causes by the distance from the spindle, (w, 4, 3), m/s².

    ``mean`` (w, 3) and ``waves`` (w, 4, 3) are corrected.
    """
    turned = np.cross(waves[:, 1], waves[:, 0])  # along the direction of turning
    n = turned / np.linalg.norm(turned, axis=1, keepdims=True)
    force = mean - (mean * n).sum(axis=1, keepdims=True) * n
    ahead = np.cross(n, force)
    p, q = wow[:, 0::2, None], wow[:, 1::2, None]
    order = np.array(HARMONICS)[:, None]
    cosine = 2 * p * force[:, None] - order * q * ahead[:, None]
    sine = 2 * q * force[:, None] + order * p * ahead[:, None]
    return np.stack([cosine, sine], axis=2).reshape(-1, len(TO_WAVES), 3)


def _across(poses: PoseSet, ring: Ring, matrix: FloatArray, offset: FloatArray) -> FloatArray:
    """Directions along and across the lean where the wave begins, (w, 2, 3)."""
    up = np.sign(poses.spin_rad_s[ring.place])[:, None] * (
        poses.reading[ring.place] @ matrix.T + offset)
    up /= np.linalg.norm(up, axis=1, keepdims=True)
    lean = waves_round(ring.force.reshape(-1, 3), -2)[:, 0]
    lean -= (lean * up).sum(axis=1, keepdims=True) * up
    lean /= np.linalg.norm(lean, axis=1, keepdims=True)
    return np.stack([lean, np.cross(up, lean)], axis=1)


def _of_the_room(ring: Ring, across: FloatArray) -> FloatArray:
    """Rows of vectors fixed in the room along t1 and t2 where the wave begins, (w, 2, 4)."""
    sine = waves_round(ring.force.reshape(-1, 3), -2)[:, 1]
    turned = np.sign(np.einsum("wi,wi->w", sine, across[:, 1]))  # +1: gravity goes t1 to t2
    quarter = np.array([[0.0, 1.0], [-1.0, 0.0]])
    begin = np.broadcast_to(np.eye(2), (len(turned), 2, 2))
    return np.concatenate([begin, turned[:, None, None] * quarter], axis=2)


def _room(poses: PoseSet, ring: Ring, shown: FloatArray) -> FloatArray:
    """Effect of an sd of the Earth's horizontal rate along and across the lean on each row, SI.

    ``shown`` (2, w, 4) is the effect of a unit of each.
    """
    names = poses.reference.common_names
    common = np.zeros((len(ring.place), 4, len(names)))
    for i, place in enumerate(ring.place):
        for j, name in enumerate(room_names(poses.run[place])):
            if name in names:
                common[i, :, names.index(name)] = ring.room_rad_s[i] * shown[j, i]
    return common.reshape(-1, len(names))


def _gravity_and_tilt(poses: PoseSet, ring: Ring, size: FloatArray) -> FloatArray:
    """Effect of an sd of the errors of gravity and of the tilt on each row, SI, (rows, q)."""
    reference = poses.reference
    relative = reference.common[ring.place] / reference.magnitude[ring.place, None]
    for i, place in enumerate(ring.place):
        name = tilt_name(poses.run[place])
        if name in reference.common_names:
            which = reference.common_names.index(name)
            relative[i, which] = DIRECTION_SD_RAD / np.tan(ring.tilt_rad[i])
    rows = np.zeros((len(size), 3, len(reference.common_names)))
    rows[:, :2] = (size[:, None] * relative)[:, None]
    return rows.reshape(-1, len(reference.common_names))
