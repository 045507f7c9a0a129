"""Partial residuals of an effect: what it would explain, row by row, beside what the model leaves.

Both are free of what the model's own parameters can take up, so that the points lie on the line of
slope 1 where the effect is there, and scatter about zero where it is not (Cook and Weisberg's
added-variable plot).
"""

from typing import TYPE_CHECKING

import numpy as np

from calib.assess import AssessedTriad
from calib.diagnosis.hypotheses.signature import whole_columns
from calib.effects.effect import Effect
from calib.effects.needs import unavailable
from calib.errors import Undetermined
from calib.fit.column_scaling import orthonormal_columns
from calib.poses.imu_log import FloatArray

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def partial_residuals(assessed: AssessedTriad, effect: Effect) -> tuple[FloatArray, FloatArray]:
    """What an effect explains and what is there, in sds of each row.

    Parameters
    ----------
    assessed : AssessedTriad
        Of a model without the effect.
    effect : Effect

    Returns
    -------
    explained, residual : array, shape (d,)
        In sds.

    Raises
    ------
    Undetermined
        The poses cannot evaluate the effect, or its columns are missing, with the names.
    """
    fit = assessed.calibration.fit
    reason = unavailable(effect, fit.poses.conditions(fit.poses.reading))
    if reason is not None:
        known = ", ".join(fit.poses.columns) or "none"
        raise Undetermined(f"{effect.name} cannot be evaluated in these poses: {reason}. Their "
                           f"columns are: {known}.")
    d = fit.equations.data_count
    columns = whole_columns(fit, effect)
    whole = np.zeros((len(fit.rows.residual), columns.shape[-1]))
    whole[:d] = columns
    basis = orthonormal_columns(fit.rows.jacobian)
    free = whole - basis @ (basis.T @ whole)
    residual = fit.rows.residual - basis @ (basis.T @ fit.rows.residual)
    size = np.linalg.lstsq(free, residual)[0]
    return np.asarray((free @ size)[:d]), np.asarray(residual[:d])


def partial_figure(assessed: AssessedTriad, effect: Effect) -> "Figure":
    """The partial residuals as a figure, a colour for each run."""
    from matplotlib.figure import Figure

    explained, residual = partial_residuals(assessed, effect)
    fit = assessed.calibration.fit
    runs = np.array(fit.poses.run)[fit.equations.row_pose][: len(explained)]
    drawing = Figure(figsize=(6.0, 4.2), layout="constrained")
    axes = drawing.subplots()
    for run in dict.fromkeys(runs):
        axes.plot(explained[runs == run], residual[runs == run], "o", ms=4, label=str(run))
    reach = float(np.abs(explained).max(initial=1.0))
    axes.plot([-reach, reach], [-reach, reach], color="black", lw=0.8)
    axes.axhline(0, color="black", lw=0.4)
    share = float((explained @ residual) / max(float(residual @ residual), np.finfo(float).tiny))
    axes.set(xlabel=f"what {effect.name} explains, sds of the row",
             ylabel="what the model leaves, sds of the row")
    axes.set_title(f"{fit.poses.triad}: {effect.name} explains {share:.0%} of the squares of the "
                   f"residual", fontsize=9)
    axes.legend(fontsize=8, frameon=False)
    return drawing
