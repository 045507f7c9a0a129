"""The rotation between the gyro's and the accelerometer's orthogonal frames.

Angrisano et al. call it impossible from magnitudes alone. Logging both triads on the turning plate
makes it visible: over whole turns the mean specific force points along the axis of rotation, so
the two directions must agree. Two transverse rows per pose,

    f/|f| = n + phi × n - (Ω²/g) (r - n (n·r)),     n the axis by the gyro, signed by its direction

give the rotation vector phi and the lever r that is fixed in the case. A sensor that is placed anew
for every pose, not quite on the spindle, adds a centripetal part that differs from pose to pose:
its size is estimated from the scatter of the rows, and reduces the weight of fast runs.

This is a question separate from the fit, and the fit does not depend on the answer: with these rows
in the fit, the misalignments of the gyroscope would depend on the accelerometer and on the
placement of each pose.
"""

from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from calib.fit.least_squares.result import Fit
from calib.fit.linear import pseudo_inverse
from calib.fit.model import stack_columns
from calib.fit.rows.axis_rows import rotation_onto
from calib.poses.attitudes import two_across
from calib.poses.conditions import Conditions
from calib.poses.imu_log import BoolArray, FloatArray

FEWEST_POSES = 6  #: derived: twelve transverse rows for six unknowns
ITERATIONS = 20  #: numerical limit; the example takes three
STEADY_RAD = 1e-12  #: rotation that ends the iterations; numerical
EFFECTIVE_SAMPLES = 100.0
"""Least number of independent samples in a pose of some ten seconds. A judgement."""

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
    turn = np.sign(spin) * np.linalg.norm(s, axis=1)
    f, n = force / gravity[:, None], s / turn[:, None]
    noise = np.hypot(poses.sd[used].mean(axis=1) / np.abs(turn), _force_sd(fit, used) / gravity)
    per_metre = spin**2 / gravity
    rotation = rotation_onto(f, n).as_matrix()
    for _ in range(ITERATIONS):
        turned = n @ rotation.T
        across = two_across(turned)
        residual = np.einsum("mij,mj->mi", across, f - turned)
        lever = -across * per_metre[:, None, None]
        design = np.concatenate([np.cross(turned[:, None], across), lever], axis=2)
        sd = np.hypot(noise, _placement_m(residual, design, noise, per_metre) * per_metre)
        gain = pseudo_inverse(_whitened(design, sd), LEAST_SINGULAR)
        solution = gain @ _whitened(residual, sd)
        rotation = Rotation.from_rotvec(solution[:3]).as_matrix() @ rotation
        if np.abs(solution[:3]).max() < STEADY_RAD:
            break
    moved = [(fit, -rotation @ _moved(fit, s) / turn[:, None, None])]
    if accelerometer is not None:
        moved.append((accelerometer, _moved(accelerometer, force) / gravity[:, None, None]))
    cov = gain @ gain.T
    for of_triad, directions in moved:
        carried = gain @ _whitened(across @ directions, sd)
        index = of_triad.model.positions(of_triad.model.acting_on("reading"))
        cov += carried @ of_triad.cov[np.ix_(index, index)] @ carried.T
    return FrameRotation(Rotation.from_matrix(rotation).as_rotvec(),
                         np.sqrt(np.diag(cov))[:3], solution[3:])


def _placement_m(
    residual: FloatArray, design: FloatArray, noise: FloatArray, per_metre: FloatArray
) -> float:
    """The scatter of the placement at which chi-square equals its expectation, m.

    The equation of Paule and Mandel (J. Res. NBS 87, 1982): chi-square falls with the variance.
    """
    from scipy.optimize import brentq  # few sessions log both triads on the plate

    def excess(variance: float) -> float:
        sd = np.sqrt(noise**2 + variance * per_metre**2)
        columns, rows = _whitened(design, sd), _whitened(residual, sd)
        rest = rows - columns @ (pseudo_inverse(columns, LEAST_SINGULAR) @ rows)
        return float(rest @ rest) - (residual.size - 6)

    if excess(0.0) <= 0:
        return 0.0
    # Without noise and with nothing fitted, this placement alone explains the rows.
    largest = float((residual**2 / per_metre[:, None] ** 2).sum()) / (residual.size - 6)
    return float(np.sqrt(brentq(excess, 0.0, largest)))


def _whitened(rows: FloatArray, sd: FloatArray) -> FloatArray:
    """Transverse rows (m, 2, ...) over the sds (m,) of their poses, (2m, ...)."""
    in_sds = rows / sd.reshape(-1, *[1] * (rows.ndim - 1))
    return np.asarray(in_sds.reshape(2 * len(sd), *rows.shape[2:]))


def _moved(fit: Fit, vector: FloatArray) -> FloatArray:
    """Shift of ``vector`` (m, 3) per parameter of bias, scale and misalignment, (m, 3, p)."""
    at = Conditions.of_vectors(vector)
    return np.asarray(-stack_columns(fit.model.acting_on("reading"), at, {}))


def _force_sd(fit: Fit, used: BoolArray) -> FloatArray:
    """Sd of the specific force of a pose mean, by its vibration over a correlated second, (m,).

    Where a table of means does not tell it, that is in the scatter of the placement.
    """
    scatter = np.nan_to_num(fit.poses.vibration[used]).mean(axis=1)
    return np.asarray(np.sqrt(scatter / EFFECTIVE_SAMPLES))
