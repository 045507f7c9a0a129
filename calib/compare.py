"""The model beside the measurements: residual of every pose, and its leave-one-out error."""

from dataclasses import dataclass

import numpy as np

from calib.imu_log import FloatArray, IntArray
from calib.solver import Fit

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

    @property
    def worst(self) -> PoseResidual:
        """The pose farthest from the model, in its own sds."""
        return max(self.poses, key=lambda pose: abs(pose.in_sd))


def orthonormal_columns(jacobian: FloatArray) -> FloatArray:
    """Orthonormal basis of the column space, shape (r, rank)."""
    scale = np.sqrt((jacobian**2).sum(axis=0))
    scale[scale == 0] = 1.0
    u, singular, _ = np.linalg.svd(jacobian / scale, full_matrices=False)
    return np.asarray(u[:, singular > 1e-9 * singular[0]])


def left_out_residual(residual: FloatArray, jacobian: FloatArray, pose: IntArray) -> FloatArray:
    """Whitened residual of every data row when its whole pose is left out of the fit, (d,).

    ``pose`` (d,) numbers the poses of the data rows; prior rows may follow them in ``residual``
    and ``jacobian``. Closed form: ``(I - H_bb)^-1 r_b`` for the rows b of a pose, H the hat matrix.
    """
    q = orthonormal_columns(jacobian)
    out = residual[: len(pose)].copy()
    leverage = (q[: len(pose)] ** 2).sum(axis=1)
    rows_of_pose = np.bincount(pose)
    single = rows_of_pose[pose] == 1
    safe = np.maximum(1 - leverage, 1 - LARGEST_LEVERAGE)
    out[single] = (out / safe)[single]
    for k in np.flatnonzero(rows_of_pose > 1):
        rows = np.flatnonzero(pose == k)
        block = np.eye(len(rows)) - q[rows] @ q[rows].T
        values, vectors = np.linalg.eigh(block)
        values = np.maximum(values, 1 - LARGEST_LEVERAGE)
        out[rows] = vectors @ ((vectors.T @ residual[rows]) / values)
    return np.asarray(out)


def compare(fit: Fit) -> Comparison:
    """Lay the fitted model beside every pose."""
    equations = fit.equations
    root = np.sqrt(fit.weight)
    pose, sd = equations.row_pose, equations.row_sd
    left_out = left_out_residual(fit.rows.residual * root, fit.rows.jacobian * root[:, None], pose)
    left_out_si = left_out * sd
    found = []
    for k in range(len(fit.poses)):
        rows = np.flatnonzero(pose == k)
        own, out = fit.residual_si[rows], left_out_si[rows]
        is_null = len(rows) > 1
        found.append(
            PoseResidual(
                label=fit.poses.label[k],
                run=fit.poses.run[k],
                residual=float(np.linalg.norm(own)) if is_null else float(own[0]),
                sd=float(np.sqrt(np.sum(sd[rows] ** 2))),
                left_out=float(np.linalg.norm(out)) if is_null else float(out[0]),
            )
        )
    return Comparison(tuple(found), fit.residual_rms, float(np.sqrt(np.mean(left_out_si**2))))
