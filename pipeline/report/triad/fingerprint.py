"""The fingerprint of an effect in the poses of a session, over the measured residual.

The fingerprint is the difference of the exact fits with and without the effect, row by row. A real
effect has the pattern of the residual; for an absent one no more than the noise is fitted.
"""

from dataclasses import dataclass

import numpy as np

from calib.fit.least_squares.result import Fit
from calib.numbers import NO_LENGTH
from calib.poses.imu_log import FloatArray
from pipeline.drawings.charts import Chart, nice_limit, rightward, tick_text, upward
from pipeline.report.triad.refitted import Refits

NOISE = 1.0  #: sd of a whitened row
REACH = 4.0  #: sds that a chart shows at least


@dataclass(frozen=True, eq=False)
class Fingerprint:
    """One effect in the rows of a fit.

    Parameters
    ----------
    measured : array, shape (d,)
        Residual without the effect, in sds.
    pattern : array, shape (d,)
        What the effect explains of it.
    visible : float
        RMS share of the effect's signature that the rest of the model leaves.
    explained : float
        Share of the measured sum of squares.
    """

    measured: FloatArray
    pattern: FloatArray
    visible: float
    explained: float


def fingerprint(refits: Refits, name: str) -> Fingerprint | None:
    """The fingerprint of one effect; None where these poses do not determine it.

    ``refits`` are those of the triad. An effect on the noise widens the sds and has no pattern.
    """
    run = refits.run.added
    effect, other = refits.effect(name), refits.flipped(name)
    if effect is None or effect.acts_on == "noise" or other is None:
        return None
    with_it, without = (refits.run, other) if name in run else (other, refits.run)
    d = with_it.fit.equations.data_count
    measured, after = (one.fit.rows.residual[:d] for one in (without, with_it))
    where = with_it.fit.model.slices()[name]
    columns = with_it.fit.rows.jacobian[:, where]
    others = np.delete(with_it.fit.rows.jacobian, np.r_[where], axis=1)
    others = others / np.maximum(np.sqrt((others**2).sum(axis=0)), NO_LENGTH)
    visible = columns - others @ np.linalg.lstsq(others, columns, rcond=None)[0]
    chi2 = float(measured @ measured)
    return Fingerprint(
        measured, measured - after,
        float(np.sqrt((visible**2).sum() / max((columns**2).sum(), NO_LENGTH))),
        max(1 - float(after @ after) / chi2, 0.0) if chi2 > 0 else 0.0,
    )


def fingerprint_svg(shape: Fingerprint, name: str, fit: Fit) -> str:
    """A bar for every measured row, and the fingerprint as a line over them."""
    poses, runs = fit.equations.row_pose, fit.poses.run
    order = np.argsort(poses, kind="stable")
    reach = nice_limit(max(REACH, float(np.abs([shape.measured, shape.pattern]).max())))
    place = np.arange(len(order), dtype=float)
    chart = Chart(rightward(-0.5, len(order) - 0.5), upward(-reach, reach), "row",
                  f"residual (bars) and {name} (line) [sd]")
    chart.y_axis([(value, tick_text(value)) for value in (-reach, 0.0, reach)])
    chart.groups([runs[k] for k in poses[order]])
    chart.stripe(-NOISE, NOISE)
    chart.level(0.0)
    chart.bars(place, np.zeros(len(order)), shape.measured[order], "measured")
    chart.line(np.stack([place - 0.5, place + 0.5], axis=1).ravel(),
               np.repeat(shape.pattern[order], 2), "pattern")
    return chart.svg(f"Measured residual and fingerprint of {name}, in sds, pose by pose.",
                     kind="fingerprint")
