"""The angle error of a label that shows little at one plate angle, for tests of the rate."""

import numpy as np

from vision.geometry import FloatArray


def cut_label(
    angle_rad: FloatArray,
    *,
    jump_rad: float,
    over_rad: float = 0.2,
    at_rad: float = 3.4,
    rng: np.random.Generator | None = None,
) -> FloatArray:
    """Error at each plate angle of a label that the frame's edge cuts, rad.

    It repeats with every turn: it rises by ``jump_rad`` over ``over_rad`` of plate angle at
    ``at_rad`` and creeps back over the rest, unevenly where a generator is passed.
    """
    past = np.mod(angle_rad - at_rad, 2 * np.pi)
    rise = np.clip(past / over_rad, 0, 1)
    fall = (past - over_rad).clip(0) / (2 * np.pi - over_rad)
    if rng is not None:
        fall = fall + rng.uniform(0, 0.1) * np.sin(np.pi * fall + rng.uniform(-0.5, 0.5))
    return np.asarray(jump_rad * (rise - fall - 0.5))
