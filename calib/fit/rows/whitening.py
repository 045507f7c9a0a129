"""What the rows of one pose set have in common under every model: their order and their sds."""

from dataclasses import dataclass

import numpy as np

from calib.fit.rows.initial_estimate import Start, start_of
from calib.numbers import NO_LENGTH
from calib.poses.imu_log import FloatArray, IntArray
from calib.poses.pose_set import PoseSet


@dataclass(frozen=True, eq=False)
class Whitening:
    """Order and sds of the data rows of n poses.

    Parameters
    ----------
    start : Start
        The ellipsoid of the poses.
    vector : array, shape (n, 3)
        The corrected vectors there, SI.
    magnitude, null : array, shapes (k,) and (m,)
        Indices of the poses with a magnitude row, and of those with three null rows.
    magnitude_sd, null_sd : array, shapes (k,) and (m, 3)
        Sds of these rows, SI, that of the reference included.
    common_relative : array, shape (k, q)
        The common errors relative to the reference.
    """

    start: Start
    vector: FloatArray
    magnitude: IntArray
    null: IntArray
    magnitude_sd: FloatArray
    null_sd: FloatArray
    common_relative: FloatArray

    @classmethod
    def of(cls, poses: PoseSet, start: Start | None = None) -> "Whitening":
        """The whitening of ``poses``; ``start`` is their ellipsoid where it is known already.

        Sds are known in nominal units, and a data sheet can be a third off: the start's matrix
        takes them to true units. |s| has the sd of s along its own direction.
        """
        start, reference = start or start_of(poses), poses.reference
        magnitude, null = np.flatnonzero(~reference.is_null), np.flatnonzero(reference.is_null)
        s = poses.reading @ start.matrix.T + start.offset
        direction = s / np.maximum(np.linalg.norm(s, axis=1, keepdims=True), NO_LENGTH)
        along = (((direction @ start.matrix) * poses.sd) ** 2).sum(axis=1)
        across = poses.sd**2 @ (start.matrix**2).T
        return cls(
            start=start,
            vector=s,
            magnitude=magnitude,
            null=null,
            magnitude_sd=np.sqrt(along + reference.sd**2)[magnitude],
            null_sd=np.sqrt(across + reference.sd[:, None] ** 2)[null],
            common_relative=reference.common[magnitude] / reference.magnitude[magnitude, None],
        )
