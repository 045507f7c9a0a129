"""Part of an effect that the parameters of a calibration absorb, and the part that the rows show.

An effect that a fit lacks moves its parameters by ``-(JᵀW J)⁻¹ JᵀW C`` per unit of its own, with C
its whitened columns.
"""

from dataclasses import replace

import numpy as np

from calib.diagnosis.hypotheses.signature import Linearisation, whole_columns
from calib.effects.effect import Effect
from calib.fit.least_squares.result import Fit
from calib.fit.rows.problem import with_common
from calib.fit.rows.sensitive_axes import sensor_columns
from calib.fit.triad.calibration import TriadCalibration
from calib.fit.validation.prediction import typical_force
from calib.poses.imu_log import FloatArray


def absorbed(
    calibration: TriadCalibration, effect: Effect, shape: float | None = None
) -> FloatArray:
    """Part of an effect that the parameters absorb, per unit of each of its parameters, (p, k)."""
    return parted(calibration, effect, shape)[0]


def parted(
    calibration: TriadCalibration, effect: Effect, shape: float | None = None
) -> tuple[FloatArray, FloatArray]:
    """Part of an effect that the parameters absorb (p, k), and part left in the rows (r, k), in
    their units and in sds.

    Of one that a length shows in square, k is the number of products of its parameters.
    """
    fit = calibration.fit
    root = np.sqrt(fit.weight)[:, None]
    seen = _columns(fit, effect, shape)
    columns = np.zeros((len(fit.rows.residual), seen.shape[1]))
    columns[: len(seen)] = seen
    basis = with_common(fit.basis, len(fit.eta))
    model = fit.rows.jacobian @ basis * root
    solution = np.linalg.lstsq(model, columns * root, rcond=None)[0]
    held = -(basis @ solution)[: fit.model.size]
    return np.asarray(held), np.asarray(columns * root - model @ solution)


def _columns(fit: Fit, effect: Effect, shape: float | None) -> FloatArray:
    """Whitened columns (d, k); gravity is along the axis of the plate where nobody logged it."""
    poses, solution = fit.poses, Linearisation(fit)
    if effect.in_square:
        vectors = solution.squares(effect)
        if poses.ring is not None:  # its waves have the effect itself
            vectors[poses.ring.place] = 0.0
        return solution.rows(vectors)
    if "force" not in effect.needs or np.isfinite(poses.force).all():
        return whole_columns(fit, effect, shape)
    along = np.sign(poses.spin_rad_s)[:, None] * fit.rows.vector
    up = along / np.linalg.norm(fit.rows.vector, axis=1, keepdims=True)
    at = replace(solution.corrected, force=typical_force(poses) * up)
    return solution.rows(sensor_columns((effect,), at, {}, fit.rows.axes))
