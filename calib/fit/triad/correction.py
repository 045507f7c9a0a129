"""A fitted model corrects readings.

With y the nominal reading and s the corrected vector:

    v = y - E(y) theta_reading            the linear form M y + c of Angrisano et al. eq. (1)
    s + C(s) theta_sensor = v             of :mod:`calib.fit.rows.sensitive_axes`
"""

from collections.abc import Container, Mapping
from dataclasses import dataclass, replace

import numpy as np

from calib.effects.needs import why_not_finite
from calib.fit.model import Model, stack_columns
from calib.fit.rows.sensitive_axes import axes_of, solve_sensor
from calib.poses.conditions import Conditions
from calib.poses.data_sheet import TriadSpec
from calib.poses.imu_log import FloatArray


@dataclass(frozen=True, eq=False)
class Correction:
    """The parameters needed to correct the readings of one triad, and nothing else.

    Parameters
    ----------
    spec : TriadSpec
        The data sheet by which counts became the nominal readings that the parameters act on.
    model : Model
    theta : array, shape (p,)
        Its fitted parameters, in the units of :meth:`calib.effects.effect.Effect.unit_for`.
    shapes : mapping of effect name to shape parameter
    """

    spec: TriadSpec
    model: Model
    theta: FloatArray
    shapes: Mapping[str, float]

    def sensor_part(self, held: Container[str] | None = None) -> "Correction":
        """The correction without the effects of the bench; of the others only those in ``held``.

        Bias, scale and misalignment are always kept.
        """
        effects = tuple(
            effect
            for effect in self.model.effects
            if effect.belongs_to != "bench"
            and (held is None or effect.acts_on == "reading" or effect.name in held)
        )
        return replace(self, model=Model(effects), theta=self.theta[self.model.positions(effects)])

    def without(self, names: Container[str]) -> "Correction":
        """The correction without these effects."""
        kept = [effect for effect in self.model.effects if effect.name not in names]
        return replace(self, model=Model(tuple(kept)), theta=self.theta[self.model.positions(kept)])

    def not_evaluable(self, at: Conditions) -> dict[str, str]:
        """The effects on the sensor that these conditions cannot evaluate, with their reasons."""
        return {
            effect.name: why_not_finite(effect, at)
            for effect in self.model.acting_on("sensor")
            if not np.isfinite(effect.evaluate(at, self.shapes.get(effect.name))).all()
        }

    def linear_form(self) -> tuple[FloatArray, FloatArray]:
        """M (3, 3) and c (3,), SI, of its model: :func:`linear_form`."""
        return linear_form(self.model, self.theta)

    def correct(self, at: Conditions) -> FloatArray:
        """Corrected vectors of nominal readings.

        Effects on the reference are left out: they are errors of the bench, not of the sensor.

        Parameters
        ----------
        at : Conditions
            ``at.vector`` (n, 3) are the nominal readings, SI.

        Returns
        -------
        array, shape (n, 3)
            In the orthogonal axes of the triad, SI.

        Raises
        ------
        FitFailed
            The effects are so large that no true vector belongs to a reading.
        """
        matrix, offset = self.linear_form()
        s = at.vector @ matrix.T + offset
        sensor = self.model.acting_on("sensor")
        if not sensor:
            return np.asarray(s)
        theta = self.theta[self.model.positions(sensor)]
        axes = axes_of(matrix)
        return solve_sensor(sensor, theta, self.shapes, lambda v: replace(at, vector=v), s, axes)


def linear_form(model: Model, theta: FloatArray) -> tuple[FloatArray, FloatArray]:
    """M (3, 3) and c (3,), SI, of ``M y + c``, from bias, scale and misalignment."""
    probes = np.vstack([np.zeros(3), np.eye(3)])
    effects = model.acting_on("reading")
    s = probes
    if effects:
        columns = stack_columns(effects, Conditions.of_vectors(probes), {})
        s = probes - columns @ theta[model.positions(effects)]
    return np.asarray((s[1:] - s[0]).T), np.asarray(s[0])
