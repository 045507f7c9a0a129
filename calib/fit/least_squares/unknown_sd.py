"""Estimates of the sds of pose means that were stated without any.

Where poses were repeated in the same attitude, the scatter of their residuals is noise alone,
whatever the model misses (pure error; Draper and Smith, *Applied Regression Analysis*, 3rd ed.,
section 2.1): with r_gi the residuals of group g,

    σ² = Σ_g Σ_i (r_gi - r̄_g)² / Σ_g (n_g - 1).

Without repeated poses only the scatter about the model remains. It gives the parameters their sds,
but does not test the model: its misfit counts as noise.
"""

import math
from dataclasses import replace

import numpy as np

from calib.errors import Undetermined
from calib.fit.least_squares.result import Fit
from calib.fit.least_squares.solver import fit
from calib.fit.model import Model
from calib.fit.noise_size import Noise
from calib.fit.rows.whitened_rows import lengths
from calib.numbers import NO_LENGTH
from calib.poses.imu_log import SI_UNIT
from calib.poses.pose_set import PoseSet

SAME_ATTITUDE = math.radians(5.0)
"""Angle within which a sensor returns to the same face of a box. The misfit of the model differs
little between such poses, and counts as noise. A judgement."""

LEAST_REPEATS = 5.0
"""Degrees of freedom that a test of the model needs. A judgement."""

BY_RESIDUALS = 1.0
"""Degrees of freedom of sds that do not test the model: the test then never rejects. Derived."""

SMALLEST_SD = 1e-9
"""Least sd in typical readings: a converter of 24 bits, the finest, steps by 6e-8 of its range.
Derived."""

START_SD = 1e-3
"""Sd in units of the reference for the first of two fits; it only weighs common errors against the
rest. Numerical."""


def has_sds(poses: PoseSet) -> bool:
    """Whether the sd of every pose mean is known."""
    return bool(np.isfinite(poses.sd).all())


def tests_the_model(poses: PoseSet) -> bool:
    """Whether the sds come from something else than the residuals of the model.

    Returns
    -------
    bool
        Also True for sds that were stated or measured.
    """
    return poses.sd_dof is None or poses.sd_dof > BY_RESIDUALS


def noise_of(fitted: Fit, dof: int | None = None) -> Noise:
    """Noise of a fit with ``dof`` degrees of freedom; by default those of its own residual."""
    return Noise(fitted.dof if dof is None else dof, fitted.poses.noise_dof,
                 tests_the_model(fitted.poses))


def with_estimated_sds(poses: PoseSet, model: Model) -> PoseSet:
    """``poses`` (n) with one sd for all means, by repeated attitudes or by the residuals.

    Parameters
    ----------
    poses : PoseSet
        Whose sds are not known.
    model : Model
        By whose residuals they are estimated.

    Returns
    -------
    PoseSet
        With ``sd`` (n, 3), SI, its degrees of freedom ``sd_dof`` and a note of where they are from.

    Raises
    ------
    Undetermined
        There are no more equations than parameters, or the means show no noise at all.
    FitFailed
        By the fit.
    Contradiction
        By the fit.
    """
    typical = float(np.median(np.linalg.norm(poses.reading, axis=1)))
    sd = START_SD * typical
    dof = 0.0
    for _ in range(2):
        fitted = fit(replace(poses, sd=np.full_like(poses.reading, sd)), model)
        if fitted.dof < 1:
            raise Undetermined(
                f"{len(poses)} pose means without sds give as many equations as the model has "
                f"parameters, so their noise cannot be estimated. State the sds of the means, or "
                f"record more poses."
            )
        sd, dof = _by_repeats(fitted)
        if dof < LEAST_REPEATS:
            sd, dof = _by_residuals(fitted), BY_RESIDUALS
        if sd < SMALLEST_SD * typical:
            raise Undetermined(
                f"the pose means scatter by {sd / typical:.1g} of a reading, less than any "
                f"converter resolves, so they show no noise: are they computed, or are rows of "
                f"them copies? State the sds of the means."
            )
    by_repeats = dof >= LEAST_REPEATS
    source = (f"estimated from attitudes that were repeated within "
              f"{math.degrees(SAME_ATTITUDE):.0f}° ({dof:.0f} degrees of freedom)" if by_repeats
              else "the scatter of the poses about the model, which cannot test the model itself")
    note = (f"the pose means have no sds: {sd:.2g} {SI_UNIT[poses.triad]}, taken for all of them, "
            f"is {source}.")
    return replace(poses, sd=np.full_like(poses.reading, sd), sd_dof=dof,
                   notes=(*poses.notes, note))


def _by_repeats(fitted: Fit) -> tuple[float, float]:
    """Sd within groups of one attitude and one reference, and its degrees of freedom."""
    turning = fitted.equations.magnitude
    if not turning.any():
        return 0.0, 0.0
    vector, magnitude = fitted.rows.vector[turning], fitted.poses.reference.magnitude[turning]
    unit = vector / np.maximum(lengths(vector), NO_LENGTH)[:, None]
    alike = (unit @ unit.T >= math.cos(SAME_ATTITUDE)) & (magnitude[:, None] == magnitude)
    _, group = np.unique(alike.argmax(axis=1), return_inverse=True)
    residual, count = lengths(vector) - magnitude, np.bincount(group)
    within = residual - (np.bincount(group, residual) / count)[group]
    dof = float(len(residual) - len(count))
    return (math.sqrt(float(within @ within) / dof) if dof else 0.0), dof


def _by_residuals(fitted: Fit) -> float:
    """Sd of the residuals about the model."""
    rows = fitted.rows.residual[: fitted.equations.data_count]
    stated = float(fitted.poses.sd[0, 0])
    return stated * math.sqrt(float(rows @ rows) / fitted.dof)
