"""A fitted model corrects readings.

With y the nominal reading and s the corrected vector:

    v = y - E(y) theta_reading            the linear form M y + c of Angrisano et al. eq. (1)
    s + C(s) theta_sensor = v             of :mod:`calib.fit.sensitive_axes`
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from calib.fit.model import Model, pick, stack_columns
from calib.fit.sensitive_axes import axes_of, solve_sensor
from calib.poses.conditions import Conditions
from calib.poses.data_sheet import TriadSpec
from calib.poses.imu_log import FloatArray


@dataclass(frozen=True, eq=False)
class Correction:
    """What is needed to correct the readings of one triad, and nothing else.

    ``theta`` (p,) are the fitted parameters of ``model`` and ``shapes`` its shape parameters;
    ``spec`` turns counts into the nominal readings they act on.
    """

    spec: TriadSpec
    model: Model
    theta: FloatArray
    shapes: Mapping[str, float]

    def linear_form(self) -> tuple[FloatArray, FloatArray]:
        """M (3, 3) and c (3,) of ``M y + c``, which bias, scale and misalignment make up."""
        probes = np.vstack([np.zeros(3), np.eye(3)])
        at = Conditions.of_vectors(probes)
        effects = self.model.acting_on("reading")
        s = probes
        if effects:
            s = probes - stack_columns(effects, at, {}) @ self.theta[pick(self.model, effects)]
        return np.asarray((s[1:] - s[0]).T), np.asarray(s[0])

    def correct(self, at: Conditions) -> FloatArray:
        """Corrected vectors for nominal readings ``at.vector`` and their conditions, (n, 3).

        Effects on the reference are left out: they are errors of the bench, not of the sensor.
        """
        matrix, offset = self.linear_form()
        s = at.vector @ matrix.T + offset
        sensor = self.model.acting_on("sensor")
        if not sensor:
            return np.asarray(s)
        theta = self.theta[pick(self.model, sensor)]
        axes = axes_of(matrix)
        return solve_sensor(sensor, theta, self.shapes, lambda v: replace(at, vector=v), s, axes)
