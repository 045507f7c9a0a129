"""The sensitive axes of :mod:`calib.fit.rows.sensitive_axes` for a stack."""

from dataclasses import dataclass

import numpy as np

from calib.fit.batch.linear_algebra import inverses
from calib.fit.rows.residuals import Equations
from calib.fit.rows.sensitive_axes import NO_GAIN
from calib.poses.imu_log import BoolArray, FloatArray


@dataclass(frozen=True, eq=False)
class JointAxes:
    """T of S linear forms (S, 3, 3), its inverse, and their gains (S, 3)."""

    to_orthogonal: FloatArray
    to_sensed: FloatArray
    gain: FloatArray

    @classmethod
    def at(cls, one: Equations, theta: FloatArray) -> "JointAxes":
        """The sensitive axes at ``theta`` (S, p)."""
        matrix = np.tile(np.eye(3), (len(theta), 1, 1))
        if one.on_sensor and one.reading_index:  # which nothing else depends on
            matrix += np.einsum("sp,pij->sij", theta[:, one.reading_index], one.matrix_slopes)
        gain = np.einsum("sii->si", matrix).copy()
        aligned = matrix / np.where(np.abs(gain) < NO_GAIN, 1.0, gain)[:, None, :]
        return cls(aligned, inverses(aligned), gain)

    @property
    def is_sound(self) -> BoolArray:
        """Whether every axis has a gain, (S,)."""
        return np.asarray((np.abs(self.gain) >= NO_GAIN).all(axis=1))

    def sensed(self, vector: FloatArray) -> FloatArray:
        """What the sensitive axes sense of vectors (S, n, 3), in their unit."""
        return np.asarray(vector @ self.to_sensed.swapaxes(1, 2))

    def slopes(self, one: Equations) -> FloatArray:
        """dT/dtheta for the parameters of the reading, (S, p', 3, 3), per their SI unit."""
        diagonal_slopes = np.einsum("pii->pi", one.matrix_slopes)
        turned = self.to_orthogonal[:, None] * diagonal_slopes[:, None, :]
        return np.asarray((one.matrix_slopes - turned) / self.gain[:, None, None, :])
