"""Conditions that an effect may depend on, for every pose or every sample of a log."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from calib.poses.imu_log import FloatArray
from calib.poses.rows import Rows

VECTORS = ("force", "previous", "vibration")
RUN_COLUMN = "run:"
"""Prefix of the name of a run in the column that is 1 in its poses."""

PLACE_COLUMN = "pose:"
"""Column with the index of their pose, of rows that are points of poses round a turn."""

OTHER_TRIAD = ("other_x", "other_y", "other_z")
"""Columns with the nominal reading of the other triad, SI."""

FIELDS = (*VECTORS, "magnitude", "spin_rad_s", "time_s", "since_middle_s")
"""Fields of :class:`Conditions` beside the vector and the logged columns."""


@dataclass(frozen=True, eq=False)
class Conditions(Rows):
    """Everything an effect may depend on, one row per pose (or per sample of a log).

    Parameters
    ----------
    vector : array, shape (n, 3)
        The vector the effect is evaluated on, SI.
    magnitude : array, shape (n,)
        Reference magnitude, SI; NaN where there is none.
    force : array, shape (n, 3)
        Calibrated specific force in m/s²; NaN where no accelerometer was logged.
    spin_rad_s : array, shape (n,)
        Rate of the plate, positive counter-clockwise seen from above, 0 when stopped.
    time_s : array, shape (n,)
        Time since the session began.
    since_middle_s : array, shape (n,)
        Time since the middle of the poses that have a stated rate in common; 0 in others.
    previous : array, shape (n, 3)
        What each sensitive axis sensed in the pose recorded before; 0 for the first and after rest.
    vibration : array, shape (n, 3)
        Variance of the accelerometer within the pose, (m/s²)².
    columns : mapping of name to array, shape (n,)
        Logged covariates, for example ``temperature_c``; in the poses of a fit also
        :data:`OTHER_TRIAD` and a column for every run.
    """

    vector: FloatArray
    magnitude: FloatArray
    force: FloatArray
    spin_rad_s: FloatArray
    time_s: FloatArray
    since_middle_s: FloatArray
    previous: FloatArray
    vibration: FloatArray
    columns: Mapping[str, FloatArray] = field(default_factory=dict)

    @classmethod
    def of_vectors(
        cls,
        vector: FloatArray,
        columns: Mapping[str, FloatArray] | None = None,
        **known: FloatArray,
    ) -> "Conditions":
        """Conditions of which only some are known; all others are NaN.

        Parameters
        ----------
        vector : array, shape (n, 3)
            SI.
        columns : mapping of str to array, shape (n,)
        known : array, shape (n,) or (n, 3)
            Any other field by its name; a single row holds for all n.
        """
        n = len(vector)
        shape = {name: (n, 3) if name in VECTORS else (n,) for name in FIELDS}
        return cls(
            vector=vector,
            columns=columns or {},
            **{name: np.broadcast_to(known[name], shape[name]) if name in known
               else np.full(shape[name], np.nan) for name in FIELDS},
        )

    def __len__(self) -> int:
        return len(self.vector)

    def with_vector(self, vector: FloatArray) -> "Conditions":
        """The same conditions at the vectors ``vector`` (n, 3), SI."""
        return Conditions(vector, self.magnitude, self.force, self.spin_rad_s, self.time_s,
                          self.since_middle_s, self.previous, self.vibration, self.columns)

    def as_in_a_log(self, time_s: float | FloatArray) -> "Conditions":
        """The same conditions as far as samples tell them: no pose before, quiet, no plate.

        ``time_s`` is the time since the calibration session began, or at its end.
        """
        n = len(self)
        return replace(self, time_s=np.broadcast_to(time_s, n), previous=np.zeros((n, 3)),
                       vibration=np.zeros((n, 3)), spin_rad_s=np.zeros(n))

    def column(self, name: str) -> FloatArray:
        """The logged column ``name``, all NaN where it was not logged, in its unit, shape (n,)."""
        return self.columns.get(name, np.full(len(self.time_s), np.nan))
