"""Runs that agree within themselves and contradict each other by gains: another sensor or range."""

import numpy as np

from calib.consistency.common_mistakes import runs_by_name
from calib.consistency.means_alone import by_means
from calib.effects.catalogue import BASE
from calib.errors import CalibrationError, Contradiction
from calib.fit.least_squares.result import MISFIT_P_VALUE, Fit
from calib.fit.least_squares.solver import fit
from calib.fit.model import Model
from calib.poses.checks.frozen import CERTAIN_SD
from calib.poses.imu_log import AXES
from calib.poses.pose_set import PoseSet

OTHER_GAIN = 0.01
"""Relative difference between the gains of a gyro in two runs, at most. Fact: 300 ppm/°C of data
sheets over 30 °C."""


def require_one_sensor(poses: PoseSet, model: Model, fitted: Fit) -> None:
    """Refuse a run that nothing but another sensor, or another range, can have logged.

    Its poses agree with each other and those of the other runs with each other, each by gains of
    their own that differ by more than any sensor's within a session.

    Raises
    ------
    Contradiction
        Naming the run.
    """
    poses, of_means = by_means(poses, model, fitted)
    base = Model(tuple(effect for effect in model.effects if effect.name in BASE))
    runs = runs_by_name(poses)
    if (of_means is None or len(runs) < 2 or set(base.names) != set(BASE)
            or of_means.p_value > MISFIT_P_VALUE / len(runs)):
        return
    for name, member in runs.items():
        try:
            alone, others = fit(poses.take(member), base), fit(poses.take(~member), base)
        except CalibrationError:
            continue
        scale = alone.model.slices()["scale"]
        apart = np.abs((1 - alone.theta[scale]) / (1 - others.theta[scale]) - 1)
        sd = np.sqrt(np.diag(alone.cov)[scale] + np.diag(others.cov)[scale])
        agree = min(alone.p_value, others.p_value) > MISFIT_P_VALUE
        if agree and (apart > OTHER_GAIN + CERTAIN_SD * sd).any():
            raise Contradiction(
                f"{poses.triad}: the poses of {name} agree with each other, and so do all others, "
                f"but their gains differ by {100 * apart.max():.2g} % ({AXES[int(apart.argmax())]} "
                f"the most). No sensor changes so much within a session: are these the logs of "
                f"another sensor or range, or is the rate wrong? Check the files and the rate of "
                f"this run."
            )
