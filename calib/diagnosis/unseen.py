"""What effects that these poses cannot see do to the parameters, if the sensor is typical.

An effect that the base absorbs whole leaves no residual and moves the parameters:

    d theta = -(JᵀW J)⁻¹ JᵀW C

per unit of its parameters, with C its whitened columns. With the catalogue's typical size for each
parameter, independent of the others, that is a covariance, and a line of its own in the budget.
Whether this sensor is typical is not in the data: the stated sds do not contain it.
"""

from collections.abc import Iterable, Mapping

import numpy as np

from calib.diagnosis.hypotheses.signature import whole_columns
from calib.effects.effect import EFFECTS, Effect
from calib.fit.rows.problem import with_common
from calib.fit.triad.calibration import TriadCalibration, parameter_sds
from calib.poses.imu_log import FloatArray, Triad
from calib.poses.runs import TIME_BASE

LEAST_SHARE = 0.1
"""Of a stated sd. Derived: what moves a parameter by less adds half a per cent to it, and is not
listed."""


def unseen_budget(
    calibration: TriadCalibration, blind: Iterable[str], part: str
) -> dict[str, FloatArray]:
    """Sd of misalignment (rad), bias (counts) and scale (counts per unit) by each blind effect.

    Parameters
    ----------
    calibration : TriadCalibration
    blind : iterable of str
        Effects that the poses cannot see, as the diagnosis lists them.
    part : str
        Class of the sensor, as the pages of the catalogue call it.

    Returns
    -------
    dict of name to array, shape (3, 3)
        As :func:`calib.fit.triad.calibration.uncertainty_budget`. Effects without a quoted size for
        this triad, and those that move no parameter, are left out; so is a wrong clock that is
        stated.
    """
    stated = calibration.fit.poses.reference
    clocked = stated.common[:, [name == TIME_BASE for name in stated.common_names]].any()
    budget = {}
    for name in blind:
        effect = EFFECTS.get(name)
        if effect is None or (name == "reference_scale" and clocked):
            continue
        size = typical_size(effect, part, calibration.triad)
        if size is None:
            continue
        shift = size * absorbed(calibration, effect)
        sds = parameter_sds(calibration, shift @ shift.T)
        if (np.nan_to_num(sds) > LEAST_SHARE * np.nan_to_num(calibration.parameters.sd)).any():
            budget[name] = sds
    return budget


def typical_size(effect: Effect, part: str, triad: Triad) -> float | None:
    """Size of each parameter, SI, for this class of sensor; what belongs to the bench has its own.

    None where the catalogue quotes none.
    """
    pages = effect.page.typical
    size = pages.get(part) or next(iter(pages.values()), None)
    return None if size is None else size.si_for(triad)


def absorbed(calibration: TriadCalibration, effect: Effect) -> FloatArray:
    """What the parameters absorb of an effect, per unit of each of its parameters, (p, k)."""
    fit = calibration.fit
    root = np.sqrt(fit.weight)[:, None]
    columns = np.zeros((len(fit.rows.residual), len(effect.parameters)))
    seen = whole_columns(fit, effect)
    columns[: len(seen)] = seen
    basis = with_common(fit.basis, len(fit.eta))
    solution = np.linalg.lstsq(fit.rows.jacobian @ basis * root, columns * root, rcond=None)[0]
    return np.asarray(-(basis @ solution)[: fit.model.size])


def together(budget: Mapping[str, FloatArray]) -> FloatArray:
    """All blind effects as one.

    Parameters
    ----------
    budget : mapping of str to array, shape (3, 3)
        By effect: what it adds to the sds of misalignment (rad), bias (counts) and scale (counts
        per SI unit), each x, y, z.

    Returns
    -------
    array, shape (3, 3)
        The root of the sum of their squares, in the same units.
    """
    return np.asarray(np.sqrt(sum(sds**2 for sds in budget.values())))
