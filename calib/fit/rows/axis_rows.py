"""Rows of the poses that show directions, and the effect of reference errors on rows.

If gravity rotates in an accelerometer, the mean and the waves contain parts of it; if a gyroscope
turns, its waves contain none of the rate.

    t·s - |s| t·(φ × n + dn)

The direction n is the axis about which a gyroscope turns on a plate that leans, because gravity
rotates about the same axis in the accelerometer (:mod:`calib.fit.triad.leaning`); or the vertical
in a case placed in a known attitude, such as a cube on a level plate. There each pose has three
rows, its magnitude and these two. φ is the rotation between the frames beyond a first estimate,
without prior knowledge, and dn the uncertainty of n due to the calibration of the accelerometer,
which is zero for a case.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from calib.fit.linear import solutions, times
from calib.fit.rows.initial_estimate import Start
from calib.fit.rows.wave_rows import WaveRows
from calib.fit.rows.whitened_rows import Whitening
from calib.fit.stacked import Stacked
from calib.poses.attitudes import two_across
from calib.poses.imu_log import FloatArray, IntArray
from calib.poses.pose_set import PoseSet
from calib.poses.reference import FRAME_NAMES, accelerometer_names
from calib.poses.runs.ring import DIRECTION_SD_RAD


def whitened_references(
    whitening: Whitening, waves: WaveRows | None, count: int, whole: FloatArray,
    errors: FloatArray,
) -> FloatArray:
    """Whitened columns of errors of the references.

    Parameters
    ----------
    whitening : Whitening
    waves : WaveRows or None
    count : int
        Number d of data rows.
    whole : array, shape (S n,)
        The references, with all of gravity where it goes round, SI.
    errors : array, shape (..., n, k)
        Of the references, SI per unit of each parameter.

    Returns
    -------
    array, shape (..., d, k)
        In sds of the data rows.
    """
    magnitude, lead = whitening.magnitude, errors.shape[:-2]
    relative = errors[..., magnitude, :] / whole.reshape(*lead, -1)[..., magnitude, None]
    columns = np.zeros((*lead, count, errors.shape[-1]))
    in_sds = whitening.stated / whitening.magnitude_sd
    columns[..., : len(magnitude), :] = relative * in_sds[..., None]
    if waves is not None and waves.of_gravity:
        in_sds = waves.of_rings.stated / waves.row_sd
        columns[..., -waves.count :, :] = relative[..., waves.row_pose, :] * in_sds[..., None]
    return columns


LEAST_WEIGHT = 1e-3
"""Weight of parallel frames against a pose in the first estimate of the angles. Numerical."""


@dataclass(frozen=True, eq=False)
class AxisRows(Stacked):
    """Two rows for each of the w poses with a known direction of each of S sets of poses.

    Attributes
    ----------
    row_pose : tuple of int, length 2w
        Pose of every row, in every set.
    across : array, shape (..., 2w, 3)
        The unit vectors t over the sds of their rows, per rad/s.
    row_sd : array, shape (..., 2w)
        rad/s.
    common : array, shape (..., 2w, q)
        What an sd of each common error adds to a row, in its sds.
    """

    row_pose: tuple[int, ...]
    across: FloatArray
    row_sd: FloatArray
    common: FloatArray

    @classmethod
    def of(cls, sets: Sequence[PoseSet], start: Start) -> "AxisRows | None":
        """The rows of S sets; None where no direction is known."""
        one = sets[0]
        if _turns_about_axis(one):
            assert one.ring is not None
            place, rows_of = one.ring.place, _of_ring
        elif one.up is not None and set(FRAME_NAMES) <= set(one.reference.common_names):
            place, rows_of = np.flatnonzero(np.isfinite(one.up).all(axis=1)), _of_attitudes
        else:
            return None
        if place.size == 0:  # a run that contains only stopped poses
            return None
        parts = [rows_of(poses, start.take(k)) for k, poses in enumerate(sets)]
        across, sd, common = (np.array(values) for values in zip(*parts, strict=True))
        return cls(tuple(map(int, np.repeat(place, 2))), across / sd[..., None], sd, common)

    def residual(self, s: FloatArray, eta: FloatArray) -> FloatArray:
        """Residual of the rows at the vectors ``s`` (..., n, 3), rad/s, in their sds, (..., 2w)."""
        turning = (self.across * s[..., list(self.row_pose), :]).sum(axis=-1)
        return np.asarray(turning - times(self.common, eta))

    def directions(self, slope: FloatArray | None) -> FloatArray:
        """Sensitivity of each row to an error of its pose's vector, (..., 2w, 3), per SI unit.

        Parameters
        ----------
        slope : array, shape (..., n, 3, 3), or None
            What effects that follow the vector make of its changes.
        """
        if slope is None:
            return self.across
        turned = slope[..., list(self.row_pose), :, :].swapaxes(-1, -2)
        return solutions(turned, self.across[..., None])[..., 0]


def _turns_about_axis(poses: PoseSet) -> bool:
    """Whether a calibrated accelerometer shows the axis of a leaning plate."""
    return (poses.triad == "gyroscope" and poses.ring is not None
            and bool(np.isfinite(poses.ring.axis).all()))


def _of_ring(poses: PoseSet, start: Start) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Directions, sds and common errors of the rows of one set on a leaning plate."""
    ring = poses.ring
    assert ring is not None
    s = poses.reading[ring.place] @ start.matrix.T + start.offset
    turn = np.sign(poses.spin_rad_s[ring.place]) * np.linalg.norm(s, axis=1)
    rotation = Rotation.align_vectors(s / turn[:, None], ring.axis)[0]
    size = np.linalg.norm(np.ptp(ring.force, axis=1), axis=1) / 2 / np.sqrt(2)
    moved = np.einsum("ij,wja->wai", rotation.as_matrix(), ring.axis_moved)
    return _rows(poses, start, ring.place, rotation.apply(ring.axis), turn,
                 (ring.force_sd / size)[:, None], moved,
                 accelerometer_names(ring.axis_moved.shape[2]))


def _of_attitudes(poses: PoseSet, start: Start) -> tuple[FloatArray, FloatArray, FloatArray]:
    """The same for a case in a known attitude."""
    assert poses.up is not None
    assert poses.up_sd_rad is not None
    place = np.flatnonzero(np.isfinite(poses.up).all(axis=1))
    up, s = poses.up[place], poses.reading[place] @ start.matrix.T + start.offset
    spin = poses.spin_rad_s[place] if poses.triad == "gyroscope" else np.zeros(len(place))
    turn = np.where(spin < 0, -1.0, 1.0) * np.linalg.norm(s, axis=1)
    rotation = rotation_onto(s / turn[:, None], up)
    return _rows(poses, start, place, rotation.apply(up), turn,
                 poses.up_sd_rad[place, None], np.zeros((len(place), 0, 3)), ())


def rotation_onto(directions: FloatArray, others: FloatArray) -> Rotation:
    """The rotation that brings ``others`` (w, 3) nearest to ``directions`` (w, 3), unit vectors.

    Where the poses leave a rotation open, the frames are taken as parallel.
    """
    weight = np.r_[np.ones(len(directions)), np.full(3, LEAST_WEIGHT)]
    return Rotation.align_vectors(
        np.vstack([directions, np.eye(3)]), np.vstack([others, np.eye(3)]), weight)[0]


def _rows(
    poses: PoseSet, start: Start, place: IntArray, n: FloatArray, turn: FloatArray,
    direction_sd: FloatArray, moved: FloatArray, moved_by: tuple[str, ...],
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Rows across the directions ``n`` (w, 3) in the frame of the triad.

    ``turn`` (w,) are the vectors' lengths along n, ``direction_sd`` (w, 1) or (w, 2) rad, and
    ``moved`` (w, a, 3) the shift of n by the common errors ``moved_by``.
    """
    across = two_across(n)  # (w, 2, 3)
    by_reading = np.einsum("wij,wj->wi", (across @ start.matrix) ** 2, poses.sd[place] ** 2)
    sd = np.sqrt(by_reading + (np.abs(turn)[:, None] * direction_sd) ** 2)
    names = poses.reference.common_names
    common = np.zeros((*sd.shape, len(names)))
    turned = np.cross(np.eye(3)[None], n[:, None]) * DIRECTION_SD_RAD  # (w, 3 angles, 3)
    errors = np.concatenate([turned, moved], axis=1) * turn[:, None, None]
    where = [names.index(name) for name in (*FRAME_NAMES, *moved_by)]
    common[:, :, where] = np.einsum("wti,wei->wte", across, errors) / sd[:, :, None]
    return across.reshape(-1, 3), sd.ravel(), common.reshape(-1, len(names))
