"""What effects are evaluated on: the conditions of every pose, whatever its vector."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from calib.fit.rows.sensitive_axes import probes_of
from calib.fit.stacked import Index
from calib.poses.conditions import Conditions, joined
from calib.poses.imu_log import BoolArray, FloatArray, IntArray
from calib.poses.pose_set import PoseSet


@dataclass(frozen=True, eq=False)
class Surroundings:
    """The conditions of S sets of n poses, one set after another, computed when they are needed.

    Parameters
    ----------
    sets : tuple of PoseSet, length S
    vector, sensed : array, shape (S n, 3)
        The corrected vectors at the start, and what each sensitive axis sensed in its pose, for
        the memory of the pose before; SI.
    previous : array, shape (S n, 3), or None
        What they sensed in the pose before where that is known already.
    """

    sets: tuple[PoseSet, ...]
    vector: FloatArray
    sensed: FloatArray
    previous: FloatArray | None = None

    def take(self, index: Index) -> "Surroundings":
        """The surroundings of some sets; those of one set are its own with and without an axis.

        A set may be taken more than once.
        """
        which = np.atleast_1d(np.arange(len(self.sets))[index]).ravel()
        if len(self.sets) == len(which) == 1:
            return self
        rows = self._rows[which].ravel()
        previous = None if self.previous is None else self.previous[rows]
        return Surroundings(tuple(self.sets[i] for i in which), self.vector[rows],
                            self.sensed[rows], previous)

    @property
    def _rows(self) -> IntArray:
        """Row of every pose, (S, n)."""
        return np.arange(len(self.vector)).reshape(len(self.sets), -1)

    @cached_property
    def at_reading(self) -> Conditions:
        """The conditions with the nominal readings."""
        return joined([poses.conditions(poses.reading) for poses in self.sets])

    @cached_property
    def at_start(self) -> Conditions:
        """The conditions at the start, after what the axes :attr:`sensed` in the poses before."""
        at = joined([poses.conditions(self.vector[rows], self.sensed[rows])
                     for poses, rows in zip(self.sets, self._rows, strict=True)])
        return at if self.previous is None else at.with_previous(self.previous)

    @cached_property
    def probes(self) -> Conditions:
        """The poses of each set six times, for the differences by which slopes are computed."""
        return probes_of(self.at_start, (len(self.sets),))

    def conditions(self, vector: FloatArray) -> Conditions:
        """What effects are evaluated on at the corrected vectors (..., n, 3), SI.

        In a null pose that is what it should read, not what it reads: scaled by an effect, its
        noise would look like a signal. The pose before stays as the start has it, so that rows
        are independent and a sign that flips with noise cannot make the iteration jump.
        """
        flat = vector.reshape(-1, 3)
        return self.at_start.with_vector(np.where(self.is_null[:, None], self.expected, flat))

    @cached_property
    def is_null(self) -> BoolArray:
        """Which poses were at rest, (S n,)."""
        return np.concatenate([poses.reference.is_null for poses in self.sets])

    @cached_property
    def expected(self) -> FloatArray:
        """What poses at rest should read, SI, (S n, 3)."""
        return np.concatenate([poses.expected for poses in self.sets])
