"""Rows of the axis about which a gyroscope turns on a plate that leans.

Gravity goes round about the axis of the plate (:mod:`calib.fit.triad.axis_of_turning`), and the
gyroscope turns about the same; across it, along t1 and t2, its corrected vector s vanishes:

    t·s - |s| t·(φ × n + dn)

with φ what the frames are turned against each other beyond a first estimate, of which nothing is
known before, and dn what the calibration of the accelerometer leaves open.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from calib.fit.rows.initial_estimate import Start
from calib.fit.small_systems import solutions, times
from calib.fit.stacked import Stacked
from calib.poses.imu_log import FloatArray
from calib.poses.pose_set import PoseSet
from calib.poses.runs.ring import FRAME_NAMES, accelerometer_names

FRAME_SD_RAD = 0.03
"""Sd of each angle between the frames beyond the estimate by nominal directions. Derived: gains and
biases of a few per cent; wide enough that the rows alone decide."""


@dataclass(frozen=True, eq=False)
class AxisRows(Stacked):
    """Two rows for each of the w rings of each of S sets of poses.

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
        """The rows of S sets; None where no calibrated accelerometer shows an axis."""
        ring = sets[0].ring
        if ring is None or sets[0].triad != "gyroscope" or not np.isfinite(ring.axis).all():
            return None
        parts = [_of_set(poses, start.take(k)) for k, poses in enumerate(sets)]
        across, sd, common = (np.array(values) for values in zip(*parts, strict=True))
        return cls(tuple(map(int, np.repeat(ring.place, 2))), across / sd[..., None], sd, common)

    def residual(self, s: FloatArray, eta: FloatArray) -> FloatArray:
        """Residual of the rows at the vectors ``s`` (..., n, 3), rad/s, in their sds, (..., 2w)."""
        turning = (self.across * s[..., list(self.row_pose), :]).sum(axis=-1)
        return np.asarray(turning - times(self.common, eta))

    def directions(self, slope: FloatArray | None) -> FloatArray:
        """What every row shows of an error of its pose's vector, (..., 2w, 3), per SI unit.

        Parameters
        ----------
        slope : array, shape (..., n, 3, 3), or None
            What effects that follow the vector make of its changes.
        """
        if slope is None:
            return self.across
        turned = slope[..., list(self.row_pose), :, :].swapaxes(-1, -2)
        return solutions(turned, self.across[..., None])[..., 0]


def _of_set(poses: PoseSet, start: Start) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Directions, sds and common errors of the rows of one set."""
    ring = poses.ring
    assert ring is not None
    s = poses.reading[ring.place] @ start.matrix.T + start.offset
    speed = np.linalg.norm(s, axis=1)
    turn = np.sign(poses.spin_rad_s[ring.place]) * speed
    rotation = Rotation.align_vectors(s / turn[:, None], ring.axis)[0]
    n = rotation.apply(ring.axis)
    helper = np.eye(3)[np.argmin(np.abs(n), axis=1)]
    first = np.cross(n, helper)
    first /= np.linalg.norm(first, axis=1, keepdims=True)
    across = np.stack([first, np.cross(n, first)], axis=1)  # (w, 2, 3)
    size = np.linalg.norm(np.ptp(ring.force, axis=1), axis=1) / 2 / np.sqrt(2)
    by_reading = np.einsum("wij,wj->wi", (across @ start.matrix) ** 2, poses.sd[ring.place] ** 2)
    sd = np.sqrt(by_reading + (speed * ring.force_sd / size)[:, None] ** 2)
    names = poses.reference.common_names
    common = np.zeros((*sd.shape, len(names)))
    turned = np.cross(np.eye(3)[None], n[:, None]) * FRAME_SD_RAD  # (w, 3 angles, 3)
    moved = np.einsum("ij,wja->wai", rotation.as_matrix(), ring.axis_moved)
    errors = np.concatenate([turned, moved], axis=1) * turn[:, None, None]
    of_errors = (*FRAME_NAMES, *accelerometer_names(ring.axis_moved.shape[2]))
    where = [names.index(name) for name in of_errors]
    common[:, :, where] = np.einsum("wti,wei->wte", across, errors) / sd[:, :, None]
    return across.reshape(-1, 3), sd.ravel(), common.reshape(-1, len(names))
