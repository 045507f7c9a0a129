"""What effects are evaluated on at the solutions of several fits: a row for every pose of each."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from calib.effects.effect import Effect
from calib.effects.variation import about_mean
from calib.fit.least_squares.result import Fit
from calib.numbers import NO_LENGTH
from calib.poses.conditions import Conditions, joined
from calib.poses.imu_log import FloatArray, IntArray


@dataclass(frozen=True, eq=False)
class JointConditions:
    """The conditions of S fits of equal numbers of poses n, in the same order.

    Parameters
    ----------
    fits : sequence of Fit
        Of models that have a bias, or have none, and of the same kinds of rows.
    corrected, reading : Conditions
        Of S·n poses: with the corrected vectors, a pose at rest held at what it should read; and
        with the nominal readings.
    """

    fits: Sequence[Fit]
    corrected: Conditions
    reading: Conditions

    @classmethod
    def of(cls, fits: Sequence[Fit]) -> "JointConditions":
        """The conditions at the solutions ``fits``."""
        return cls(
            fits,
            joined([fit.equations.conditions(fit.rows.vector) for fit in fits]),
            joined([fit.equations.at_reading for fit in fits]),
        )

    @cached_property
    def to_orthogonal(self) -> FloatArray:
        """T, from the sensitive axes to the orthogonal ones, (S, 3, 3), no unit."""
        return np.array([fit.rows.axes.to_orthogonal for fit in self.fits])

    @cached_property
    def sensed(self) -> Conditions:
        """The corrected conditions with what the sensitive axes sense."""
        to_sensed = np.array([fit.rows.axes.to_sensed for fit in self.fits])
        vector = self.corrected.vector.reshape(len(self.fits), -1, 3) @ to_sensed.swapaxes(1, 2)
        return self.corrected.with_vector(vector.reshape(-1, 3))

    @cached_property
    def directions(self) -> FloatArray:
        """What every data row shows per SI unit of error of its pose's vector, (S, d, 3)."""
        chosen = self.fits[0].equations.magnitude
        turning = np.array([fit.rows.vector[chosen] for fit in self.fits])
        size = np.maximum(np.sqrt((turning**2).sum(axis=2)), NO_LENGTH)
        sd = np.array([fit.equations.magnitude_sd for fit in self.fits])
        along = turning / (size * sd)[..., None]
        following = [i for i, fit in enumerate(self.fits) if fit.rows.slope is not None]
        if following:
            slope = np.array([
                fit.rows.slope[chosen] for fit in self.fits if fit.rows.slope is not None
            ])
            along[following] = np.linalg.solve(
                slope.swapaxes(2, 3), along[following][..., None]
            )[..., 0]
        null_sd = np.array([fit.equations.null_sd for fit in self.fits])
        at_rest = (np.eye(3) / null_sd[..., None]).reshape(len(self.fits), -1, 3)
        return np.concatenate([along, at_rest], axis=1)

    @cached_property
    def along_vectors(self) -> FloatArray:
        """What every data row shows per SI unit of error in the length of its vector, (S, d, 1)."""
        chosen = self.fits[0].equations.magnitude
        s = np.array([fit.rows.vector[chosen] for fit in self.fits])
        unit = s / np.linalg.norm(s, axis=2, keepdims=True)
        along = np.zeros((*self.directions.shape[:2], 1))
        along[:, : len(chosen), 0] = (self.directions[:, : len(chosen)] * unit).sum(axis=2)
        return along

    @cached_property
    def row_pose(self) -> IntArray:
        """Pose of every data row, (d,)."""
        return self.fits[0].equations.row_pose

    @cached_property
    def typical_sd(self) -> FloatArray:
        """Median sd of the data rows of each fit, SI, (S,)."""
        return np.array([fit.equations.typical_sd for fit in self.fits])

    def of_effect(self, effect: Effect, shapes: Sequence[float | None]) -> FloatArray:
        """Errors of an effect per unit of its k parameters, each fit at its own shape.

        Returns
        -------
        array, shape (S, n, 3, k)
            Of the vectors; of an effect on the reference its magnitude's errors, (S, n, k).
        """
        at, fitted = self._place(effect), self.fits[0].model.names
        if len(set(shapes)) == 1:
            flat = about_mean(effect, fitted, len(shapes)).evaluate(at, shapes[0])
        else:
            n = len(at) // len(shapes)
            flat = np.concatenate([
                about_mean(effect, fitted).evaluate(at.take(slice(i * n, (i + 1) * n)), shape)
                for i, shape in enumerate(shapes)
            ])
        errors = flat.reshape(len(shapes), -1, *flat.shape[1:])
        if effect.acts_on == "sensor" and not effect.orthogonal:
            return np.asarray(self.to_orthogonal[:, None] @ errors)
        return errors

    def _place(self, effect: Effect) -> Conditions:
        """Where an effect is evaluated."""
        if effect.acts_on == "reading":
            return self.reading
        on_sensed = effect.acts_on == "sensor" and not effect.orthogonal
        return self.sensed if on_sensed else self.corrected

