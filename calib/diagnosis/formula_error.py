"""Error of the formulas in a model between the values that the poses saw.

A sensor that saturates is no cubic, though one fits all poses that saw few values. What an effect
of the model errs by on each axis is taken to be off by a smooth function of what that axis senses,

    δ_k = e_k(s) h_k(s_k),    h a Gaussian process of sd ``FORMULA_ERROR``,

of which the rows leave what they do not show beside all parameters.
"""

from dataclasses import replace

import numpy as np

from calib.diagnosis.absorbed import parted
from calib.diagnosis.hypotheses.listed import ATTITUDE, Hypothesis
from calib.diagnosis.hypotheses.unlisted import smooth_functions
from calib.effects.effect import Effect
from calib.fit.least_squares.result import Fit
from calib.fit.noise_size import FORMULA_ERROR
from calib.fit.triad.calibration import TriadCalibration
from calib.fit.validation.elsewhere import error_by_missing
from calib.fit.validation.prediction import Prediction
from calib.poses.conditions import Conditions
from calib.poses.imu_log import AXES, FloatArray

GRID = np.linspace(-1.0, 1.0, 41)
"""Readings over the largest between which a smooth function is interpolated. Numerical."""


def formulas_of_readings(fit: Fit) -> list[Effect]:
    """The sensor's effects in the model that are functions of what its axes sense."""
    return [each for each in fit.model.acting_on("sensor") if each.belongs_to == "sensor"
            and Hypothesis(each.name, "listed", 0.0, each).covariate == ATTITUDE]


def error_of_formulas(prediction: Prediction, calibration: TriadCalibration) -> FloatArray:
    """Mean square error of a corrected magnitude by formulas of the model that are off, SI, (m, d).
    """
    fit, total = calibration.fit, np.zeros_like(prediction.variance)
    residual = fit.rows.residual * np.sqrt(fit.weight)
    for effect in formulas_of_readings(fit):
        deviation = _deviation(fit, effect)
        held, remainder = parted(calibration, deviation)
        shown, turns = np.linalg.eigh(FORMULA_ERROR**2 * remainder.T @ remainder)
        likely = turns.T @ remainder.T @ residual * FORMULA_ERROR / (1 + shown)
        root = FORMULA_ERROR * np.column_stack([turns / np.sqrt(1 + shown), turns @ likely])
        variance = error_by_missing(calibration, prediction, deviation, held, root)
        total += np.where(np.isfinite(variance), variance, 0.0)
    return total


def _deviation(fit: Fit, effect: Effect) -> Effect:
    """What ``effect`` of the model errs by, times smooth functions of what each axis senses."""
    size, shape = fit.theta[fit.model.slices()[effect.name]], fit.shapes.get(effect.name)
    largest = float(np.abs(fit.rows.vector).max())
    modes = smooth_functions(GRID).T

    def columns(at: Conditions) -> FloatArray:
        error = effect.evaluate(at, shape) @ size
        share = at.vector / largest
        off = error[:, :, None] * np.stack([np.interp(share, GRID, mode) for mode in modes], axis=2)
        return np.asarray((np.eye(len(AXES))[:, :, None] * off[:, :, None, :]).reshape(
            *error.shape, -1))

    names = tuple(f"{axis}{j}" for axis in AXES for j in range(len(modes)))
    return replace(effect, name=f"{effect.name} off", parameters=names, columns=columns, shape=None)
