"""The rotation between the gyro's and the accelerometer's orthogonal frames.

Angrisano et al. call it impossible from magnitudes alone. Logging both triads on the turning plate
makes it visible: over whole turns the mean specific force points along the axis of rotation, so
the two directions must agree. Two transverse rows per pose,

    f/|f| = n + phi × n - (Ω²/g) (r - n (n·r)),     n the axis by the gyro, signed by its direction

give the rotation vector phi and the lever r that is fixed in the case. What is put on the plate
anew for every pose, not quite on the spindle, leaves a centripetal part of its own: its size is
estimated from the scatter of the rows, and weights the fast runs down.
"""

from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from calib.fit.column_scaling import pseudo_inverse
from calib.fit.least_squares.result import Fit
from calib.fit.model import stack_columns
from calib.poses.conditions import Conditions
from calib.poses.imu_log import BoolArray, FloatArray

FEWEST_POSES = 6  #: derived: twelve transverse rows for six unknowns
ITERATIONS = 20  #: numerical limit; the example takes three
LARGEST_PLACEMENT_M = 0.5  #: fact: beyond the rim of any plate
PLACEMENT_STEPS = 60  #: numerical limit: a step about doubles a variance that is far too small
PLACEMENT_TOLERANCE = 1e-12  #: change of chi-square over its degrees of freedom; numerical
EFFECTIVE_SAMPLES = 100.0
"""Independent samples that a pose of some ten seconds is worth at least. A judgement."""

LEAST_SINGULAR = 1e-6
"""Relative singular value below which the lever is not seen and stays at zero. Numerical."""


@dataclass(frozen=True, eq=False)
class FrameRotation:
    """The frame of the gyroscope in that of the accelerometer.

    Parameters
    ----------
    angles_rad, sd_rad : array, shape (3,)
        Rotation vector and its sds: ``v_accelerometer = v_gyro + angles × v_gyro`` to first order.
    lever_m : array, shape (3,)
        The accelerometer from the axis of the plate, in the axes of the case.
    """

    angles_rad: FloatArray
    sd_rad: FloatArray
    lever_m: FloatArray


def _transverse(n: FloatArray) -> FloatArray:
    """Two unit vectors across each direction ``n`` (m, 3), shape (m, 2, 3)."""
    helper = np.eye(3)[np.argmin(np.abs(n), axis=1)]
    first = np.cross(n, helper)
    first /= np.linalg.norm(first, axis=1, keepdims=True)
    return np.stack([first, np.cross(n, first)], axis=1)


@dataclass(frozen=True, eq=False)
class _TransverseRows:
    """Transverse rows (m, 2), their design (m, 2, 6) and what weights them."""

    residual: FloatArray
    design: FloatArray
    noise_sd: FloatArray
    per_metre: FloatArray

    def solve(self, placement_m: float) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Solution (6,), covariance (6, 6) and what is left of the rows (2m,), in their sds."""
        inverse, sd = self.inverse(placement_m)
        b = (self.residual / sd).ravel()
        solution = inverse @ b
        rest = b - (self.design / sd[:, :, None]).reshape(-1, 6) @ solution
        return solution, inverse @ inverse.T, rest

    def inverse(self, placement_m: float) -> tuple[FloatArray, FloatArray]:
        """What turns whitened rows into the solution, (6, 2m), and the rows' sd, (m, 1)."""
        sd = np.sqrt(self.noise_sd**2 + (placement_m * self.per_metre) ** 2)[:, None]
        a = (self.design / sd[:, :, None]).reshape(-1, 6)
        return pseudo_inverse(a, LEAST_SINGULAR), sd

    def placement(self) -> float:
        """The scatter of the placement at which chi-square is what it should be, m.

        The equation of Paule and Mandel (J. Res. NBS 87, 1982), by Newton's method: chi-square is
        convex in the variance and falls, so no step from zero passes the root.
        """
        dof = self.residual.size - 6
        variance = 0.0
        for _ in range(PLACEMENT_STEPS):
            rest = self.solve(np.sqrt(variance))[2]
            sd = np.hypot(self.noise_sd, np.sqrt(variance) * self.per_metre)
            slope = float((rest.reshape(-1, 2) ** 2).sum(axis=1) @ (self.per_metre / sd) ** 2)
            excess = float(rest @ rest) - dof
            if excess <= 0:
                break
            variance += excess / slope
            if variance >= LARGEST_PLACEMENT_M**2:
                return LARGEST_PLACEMENT_M
            if excess <= PLACEMENT_TOLERANCE * dof:
                break
        return float(np.sqrt(variance))


def rotation_between_frames(fit: Fit, accelerometer: Fit | None = None) -> FrameRotation | None:
    """The rotation from the gyro's to the accelerometer's frame, where these poses show it.

    Parameters
    ----------
    fit : Fit
        Of the gyro, its poses with calibrated specific force.
    accelerometer : Fit or None
        Of the accelerometer; what its parameters leave open is common to all rows.

    Returns
    -------
    FrameRotation or None
        None where fewer than ``FEWEST_POSES`` turning poses have the accelerometer.
    """
    poses = fit.poses
    used = (poses.spin_rad_s != 0) & np.isfinite(poses.force).all(axis=1)
    if used.sum() < FEWEST_POSES:
        return None
    spin, force, s = poses.spin_rad_s[used], poses.force[used], fit.rows.vector[used]
    gravity = np.linalg.norm(force, axis=1)
    speed = np.linalg.norm(s, axis=1)
    f = force / gravity[:, None]
    n = np.sign(spin)[:, None] * s / speed[:, None]
    noise = np.hypot(poses.sd[used].mean(axis=1) / speed, _force_sd(fit, used) / gravity)
    per_metre = spin**2 / gravity
    rotation = _nearest_rotation(f.T @ n)
    for _ in range(ITERATIONS):
        turned = n @ rotation.T
        across = _transverse(turned)
        residual = np.einsum("mij,mj->mi", across, f - turned)
        turn = -np.cross(across, turned[:, None])
        lever = -across * per_metre[:, None, None]
        rows = _TransverseRows(residual, np.concatenate([turn, lever], axis=2), noise, per_metre)
        placement = rows.placement()
        solution, cov, _ = rows.solve(placement)
        rotation = Rotation.from_rotvec(solution[:3]).as_matrix() @ rotation
        if np.abs(solution[:3]).max() < 1e-12:
            break
    inverse, row_sd = rows.inverse(placement)
    gyro = _moved(fit, s) / speed[:, None, None]
    by_gyro = np.sign(spin)[:, None, None] * np.einsum("ij,mjp->mip", rotation, gyro)
    cov += _carried(inverse, row_sd, across, -by_gyro, fit)
    if accelerometer is not None:
        by_force = _moved(accelerometer, force) / gravity[:, None, None]
        cov += _carried(inverse, row_sd, across, by_force, accelerometer)
    sd = np.sqrt(np.diag(cov))
    angles = Rotation.from_matrix(rotation).as_rotvec()
    return FrameRotation(angles, sd[:3], solution[3:])


def _nearest_rotation(matrix: FloatArray) -> FloatArray:
    """The rotation R that maximises tr(Rᵀ ``matrix``), shape (3, 3).

    For ``Σ f nᵀ`` over pairs of directions it takes n nearest to f, also where all lie in one
    plane: Markley, *J. Astronaut. Sci.* 36 (1988), on Wahba's problem, eq. (12) to (14).
    """
    u, _, vt = np.linalg.svd(matrix)
    return np.asarray(u @ np.diag([1.0, 1.0, np.linalg.det(u @ vt)]) @ vt)


def _moved(fit: Fit, vector: FloatArray) -> FloatArray:
    """How far each parameter of bias, scale and misalignment moves ``vector`` (m, 3), (m, 3, p)."""
    at = Conditions.of_vectors(vector)
    return np.asarray(-stack_columns(fit.model.acting_on("reading"), at, {}))


def _carried(
    inverse: FloatArray, row_sd: FloatArray, across: FloatArray, moved: FloatArray, fit: Fit
) -> FloatArray:
    """Covariance (6, 6) that a triad's parameters carry into the solution."""
    rows = np.einsum("mij,mjp->mip", across, moved) / row_sd[:, :, None]
    gain = inverse @ rows.reshape(inverse.shape[1], moved.shape[2])
    index = fit.model.positions(fit.model.acting_on("reading"))
    return np.asarray(gain @ fit.cov[np.ix_(index, index)] @ gain.T)


def _force_sd(fit: Fit, used: BoolArray) -> FloatArray:
    """Sd of the specific force of a pose mean, by its vibration over a correlated second, (m,)."""
    scatter = fit.poses.vibration[used].mean(axis=1)
    return np.asarray(np.sqrt(scatter / EFFECTIVE_SAMPLES))
