"""Whether the poses determine the model, judged before a number is given.

A residual says nothing about it: nine poses fit nine parameters exactly, and an unseen direction
leaves the residual small while the parameters run away. What counts are the number of rows, the
rank, and the condition number of the column-scaled Jacobian.
"""

from typing import TYPE_CHECKING

import numpy as np

from calib.coverage import list_directions, uncovered
from calib.errors import Undetermined
from calib.imu_log import FloatArray

if TYPE_CHECKING:
    from calib.equations import Equations, Rows

RANK_TOLERANCE = 1e-9
CONDITION_LIMIT = 25.0
"""The 18 wedge poses give 1.4, ten usable free-hand poses up to 8; from 25 on the worst
combination of parameters is known twenty times worse than the best."""

FEWEST_SPARE_ROWS = 1


def scaled_condition(jacobian: FloatArray) -> tuple[float, FloatArray]:
    """Condition number of the column-scaled Jacobian and its weakest combination (p,)."""
    scale = np.sqrt((jacobian**2).sum(axis=0))
    if (scale == 0).any():
        return np.inf, (scale == 0).astype(float)
    _, singular, combinations = np.linalg.svd(jacobian / scale, full_matrices=False)
    if singular[-1] < RANK_TOLERANCE * singular[0]:
        return np.inf, np.asarray(combinations[-1])
    return float(singular[0] / singular[-1]), np.asarray(combinations[-1])


def require_enough(equations: "Equations") -> None:
    """Refuse poses too few to check the fit with; raises :class:`Undetermined`."""
    triad, model, poses = equations.poses.triad, equations.model, equations.poses
    if equations.data_count - model.size < FEWEST_SPARE_ROWS:
        raise Undetermined(
            f"{triad}: {len(poses)} poses give {equations.data_count} equations for {model.size} "
            f"parameters ({', '.join(model.names)}), which leaves nothing to check the fit with; "
            f"at least {model.size + FEWEST_SPARE_ROWS} are needed and 18 are recommended. "
            f"{_advice(equations)}"
        )


def require_determined(equations: "Equations", rows: "Rows") -> None:
    """Refuse, in words, poses that cannot determine the model; ``rows`` at the solution.

    Raises
    ------
    Undetermined
        A rank loss, or a condition number above ``CONDITION_LIMIT``.
    """
    triad, model, poses = equations.poses.triad, equations.model, equations.poses
    data = rows.jacobian[: equations.data_count, : model.size]
    condition, weakest = scaled_condition(data)
    base_only = len(equations.reading_index) == model.size
    limit = CONDITION_LIMIT if base_only else CONDITION_LIMIT**2
    if condition <= limit:
        return
    number = "without limit (rank deficient)" if np.isinf(condition) else f"{condition:.0f}"
    raise Undetermined(
        f"{triad}: these {len(poses)} poses do not determine {_involved(equations, weakest)}: the "
        f"condition number is {number}, at most {limit:.0f} is accepted (the 18 wedge poses give "
        f"1.4). The residual would be small and the parameters worthless. {_advice(equations)}"
    )


def _involved(equations: "Equations", combination: FloatArray) -> str:
    names = [
        f"{effect.name} {parameter}"
        for effect in equations.model.effects
        for parameter in effect.parameters
    ]
    strong = np.abs(combination) > 0.35 * np.abs(combination).max()
    return ", ".join(name for name, is_strong in zip(names, strong, strict=True) if is_strong)


def _advice(equations: "Equations") -> str:
    poses = equations.poses
    turning = ~poses.reference.is_null
    if not turning.any():
        return "Poses on the turning plate are missing."
    vectors = poses.reading[turning]
    missing = uncovered(vectors)
    if len(missing) == 0:
        return "Every face and edge is covered: repeat the poses, or take an effect out."
    return f"Directions with no pose within 25°: {list_directions(missing, most=18)}. Add those."
