"""The model beside the measurements: residual of every pose, and its leave-one-out error."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from calib.fit.column_scaling import orthonormal_columns
from calib.fit.result import Fit
from calib.poses.imu_log import FloatArray, IntArray

LARGEST_LEVERAGE = 0.999
"""A pose that the fit passes through exactly has no leave-one-out error to speak of."""


@dataclass(frozen=True, eq=False)
class PoseResidual:
    """One pose beside the model, SI units.

    ``residual`` is the magnitude less the reference's, or the length of what a null pose still
    reads; ``sd`` the sd of that; ``left_out`` the same residual when the pose takes no part in the
    fit.
    """

    label: str
    run: str
    residual: float
    sd: float
    left_out: float

    @property
    def in_sd(self) -> float:
        """The residual in units of its sd."""
        return self.residual / self.sd


@dataclass(frozen=True, eq=False)
class Comparison:
    """Model against measurements: every pose, and the two root mean squares, SI."""

    poses: tuple[PoseResidual, ...]
    residual_rms: float
    loo_rms: float

    def worst(self, count: int) -> list[PoseResidual]:
        """The poses farthest from the model, in their own sds, the worst first."""
        return sorted(self.poses, key=lambda pose: -abs(pose.in_sd))[:count]


def pose_blocks(q: FloatArray, pose: IntArray) -> Iterator[tuple[IntArray, FloatArray]]:
    """Rows (m, b) of the poses that have b rows each, and their blocks of ``I - H``, (m, b, b).

    ``q`` (r, k) is an orthonormal basis of what was fitted, ``pose`` (d,) numbers the data rows'
    poses; the rows of a pose stand together.
    """
    _, first, count = np.unique(pose, return_index=True, return_counts=True)
    for size in np.unique(count):
        rows = first[count == size][:, None] + np.arange(size)
        part = q[rows]
        yield rows, np.eye(size) - part @ part.transpose(0, 2, 1)


def left_out_residual(residual: FloatArray, jacobian: FloatArray, pose: IntArray) -> FloatArray:
    """Whitened residual of every data row when its whole pose is left out of the fit, (d,).

    ``pose`` (d,) numbers the poses of the data rows; prior rows may follow them in ``residual``
    and ``jacobian``. Closed form: ``(I - H_bb)^-1 r_b`` for the rows b of a pose, H the hat matrix.
    """
    q = orthonormal_columns(jacobian)
    out = np.empty(len(pose))
    for rows, block in pose_blocks(q, pose):
        values, vectors = np.linalg.eigh(block)
        values = np.maximum(values, 1 - LARGEST_LEVERAGE)
        turned = np.einsum("mji,mj->mi", vectors, residual[rows]) / values
        out[rows] = np.einsum("mij,mj->mi", vectors, turned)
    return out


def compare(fit: Fit) -> Comparison:
    """Lay the fitted model beside every pose."""
    equations = fit.equations
    root = np.sqrt(fit.weight)
    pose, sd, own = equations.row_pose, equations.row_sd, fit.residual_si
    left_out = sd * left_out_residual(
        fit.rows.residual * root, fit.rows.jacobian * root[:, None], pose
    )
    found: list[PoseResidual] = []
    is_null = fit.poses.reference.is_null
    squares = np.stack([own**2, left_out**2, sd**2])
    lengths = np.sqrt(np.stack([np.bincount(pose, row, len(fit.poses)) for row in squares]))
    signed = np.zeros((2, len(fit.poses)))
    single = ~is_null[pose]
    signed[:, pose[single]] = own[single], left_out[single]
    for k in range(len(fit.poses)):
        residual, out = lengths[:2, k] if is_null[k] else signed[:, k]
        found.append(
            PoseResidual(
                label=fit.poses.label[k],
                run=fit.poses.run[k],
                residual=float(residual),
                sd=float(lengths[2, k]),
                left_out=float(out),
            )
        )
    loo_rms = float(np.sqrt(np.mean(left_out**2)))
    return Comparison(tuple(found), fit.residual_rms, loo_rms)
