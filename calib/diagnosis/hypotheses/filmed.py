"""Hypotheses of a plate that drifts while the settings of its rate are filmed one after another.

What a clip stated was the rate at its own time. Rates of several settings so err by as much as the
plate drifted between them, which is a parameter of its own for each setting.
"""

from dataclasses import replace

import numpy as np

from calib.diagnosis.constants import CONSTANTS
from calib.diagnosis.hypotheses.signature import Projector, effect_columns
from calib.effects.effect import Effect
from calib.fit.least_squares.identifiability import VISIBLE_SHARE
from calib.fit.least_squares.result import Fit
from calib.numbers import SECONDS_PER_HOUR
from calib.poses.conditions import Conditions
from calib.poses.imu_log import FloatArray

LARGEST_APART = float(np.sqrt(12))
"""Time between two clips over the sd of one that was taken at any time of the session. Derived: a
uniform distribution."""


def between_clips(base: Fit, drift: Effect) -> Effect | None:
    """``drift`` with the time of each clip left open; None where the rows contradict it.

    Parameters
    ----------
    base : Fit
        Without it.
    drift : Effect
        ``reference_drift``.

    Returns
    -------
    Effect or None
        Its further parameters are what the rate of each setting errs by one sd of that time, in
        1/h. None of a plate of one setting, where its poses show no drift, and where the clips
        would have been taken further apart than the session is long: then the rates err by
        something else.
    """
    at = base.equations.at_reading
    shared = (at.magnitude > 0) & (at.since_middle_s != 0)
    rates = np.unique(np.abs(at.spin_rad_s[shared]))
    if len(rates) < 2:
        return None
    sd_h = float(np.ptp(at.since_middle_s[shared])) / LARGEST_APART / SECONDS_PER_HOUR

    def columns(poses: Conditions) -> FloatArray:
        magnitude = np.where(poses.magnitude > 0, poses.magnitude, 0.0)[:, None]
        of_setting = np.abs(poses.spin_rad_s)[:, None] == rates
        return np.hstack([drift.columns(poses), magnitude * of_setting * sd_h])

    whole = replace(drift, columns=columns, parameters=(*drift.parameters, *map(str, rates)))
    projector = Projector(base)
    rows = np.zeros((len(projector.residual), 1 + len(rates)))
    rows[: projector.data_count] = effect_columns(base, whole)
    seen = projector(rows * projector.root[:, None])
    inverse = np.linalg.pinv(seen, rcond=VISIBLE_SHARE)
    per_h, *offsets = inverse @ projector.residual
    doubt = CONSTANTS.limit_sd * float(np.linalg.norm(inverse[0]))
    if abs(per_h) < doubt:
        return None
    rest = projector.residual - seen @ (inverse @ projector.residual)
    doubt *= np.sqrt(max(rest @ rest / max(projector.dof, 1), 1.0))  # by what else is missing
    return whole if np.ptp(offsets) < LARGEST_APART * (abs(per_h) + doubt) else None
