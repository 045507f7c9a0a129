"""What effects are evaluated on, for a stack of fits: one row for every pose of every set."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from calib.fit.batch.fit_many import FittedStack
from calib.fit.batch.linear_algebra import inverses
from calib.fit.model import Model, stack_columns
from calib.poses.conditions import FIELDS, Conditions
from calib.poses.imu_log import FloatArray
from calib.poses.pose_set import PoseSet


@dataclass(frozen=True, eq=False)
class StackedConditions:
    """Conditions of the S·n poses of a stack of fits at their solutions.

    Parameters
    ----------
    reading, sensed, vector : Conditions
        With the nominal readings, what the sensitive axes sense, the corrected vectors; where a
        pose at rest reads what it should.
    to_orthogonal : array, shape (S, 3, 3)
        From the sensitive axes to the orthogonal ones.
    """

    reading: Conditions
    sensed: Conditions
    vector: Conditions
    to_orthogonal: FloatArray

    @classmethod
    def of(
        cls, stack: FittedStack, sets: Sequence[PoseSet], model: Model
    ) -> "StackedConditions":
        """The conditions of the fits of ``sets``, which are those of the stack in its order."""
        equations, k = stack.equations, stack.equations.stack.turning
        to_orthogonal = axes_of_many(linear_forms(model, stack.theta))
        held = stack.rows.vector.copy()
        held[:, k:] = equations.stack.expected
        reading = _joined(stack, sets)
        vector = replace(reading, vector=held.reshape(-1, 3))
        sensed = held @ np.swapaxes(inverses(to_orthogonal), 1, 2)
        return cls(reading, replace(vector, vector=sensed.reshape(-1, 3)), vector, to_orthogonal)


def linear_forms(model: Model, theta: FloatArray) -> FloatArray:
    """M (S, 3, 3), no unit, of ``s = M y + c`` at ``theta`` (S, p)."""
    probes = Conditions.of_vectors(np.vstack([np.zeros(3), np.eye(3)]))
    columns = stack_columns(model.effects, probes, {})
    slopes = (columns[0] - columns[1:]).transpose(2, 1, 0)  # (p, 3, 3)
    return np.asarray(np.eye(3) + np.einsum("sp,pij->sij", theta, slopes))


def axes_of_many(matrix: FloatArray) -> FloatArray:
    """T of Angrisano et al. eq. (2), the columns of M (S, 3, 3) over its diagonal, no unit."""
    return np.asarray(matrix / np.einsum("skk->sk", matrix)[:, None, :])


def _joined(stack: FittedStack, sets: Sequence[PoseSet]) -> Conditions:
    """The conditions of all sets, their poses in the order of the stack."""
    equations = stack.equations
    felt_axes = inverses(axes_of_many(equations.start_matrix))
    parts = []
    for i, (poses, order) in enumerate(zip(sets, equations.stack.order, strict=True)):
        start = poses.reading @ equations.start_matrix[i].T + equations.start_offset[i]
        parts.append(poses.conditions(poses.reading, start @ felt_axes[i].T).take(order))
    names = set.intersection(*(set(part.columns) for part in parts))
    return Conditions(
        vector=np.concatenate([part.vector for part in parts]),
        columns={name: np.concatenate([part.columns[name] for part in parts])
                 for name in sorted(names)},
        **{name: np.concatenate([getattr(part, name) for part in parts]) for name in FIELDS},
    )
