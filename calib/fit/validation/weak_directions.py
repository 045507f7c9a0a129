"""Directions that the poses of a calibration hardly determine, and poses that nothing checks."""

import numpy as np

from calib.fit.least_squares.result import Fit
from calib.fit.triad.calibration import TriadCalibration
from calib.fit.validation.leave_one_out import free_shares
from calib.numbers import NO_LENGTH
from calib.poses.attitudes import natural_directions
from calib.poses.imu_log import FloatArray

LARGEST_TO_POSE = 1.5
"""Ratio of the sd in a direction to that of one pose there, from which such a pose would nearly
halve it (:func:`times_a_pose`). 18 wedge poses stay at 0.8; without those of one face and the edges
beside it 2. A judgement."""

MOST_WANTED = 8
"""Number of directions that an advice lists; if more are missing, as many again come with the next
run. A judgement."""

LEAST_REDUNDANCY = 0.01
"""Share of a pose's own error that its residual shows. Derived: an error is noticed (in 8 of 10
cases at 1 in 1000) from 4.1/√share of the pose's sds on (Baarda, *A Testing Procedure for Use in
Geodetic Networks*, 1968): at 0.01 from 41, while the rest of it enters the parameters."""


def times_a_pose(
    gradients: FloatArray, calibration: TriadCalibration, pose_sd: float
) -> tuple[FloatArray, list[int]]:
    """Ratio of the sd to that of one pose in every direction (m, d), and where poses would mend it.

    A pose of the sd σ takes the part v of a variance ``v + c`` that poses do not share to
    ``v σ²/(v + σ²)`` and leaves c, that of the errors that the references have in common. The ratio
    t is √v/σ without these, and with them what halves as much:

        1 + t² = (v + c) / (v σ²/(v + σ²) + c)

    The directions are natural ones, each the worst given those before it, which enter as one more
    pose: ``cov - cov g (σ² + gᵀ cov g)⁻¹ gᵀ cov``. ``gradients`` (m, d, p) at every magnitude.
    """
    cov, natural = calibration.noise_cov, len(natural_directions())
    shared = np.maximum(variances_along(gradients, calibration.fit.cov - cov), 0.0)

    def times() -> FloatArray:
        single = np.maximum(variances_along(gradients, cov), NO_LENGTH)
        mended = single / (1 + single / pose_sd**2)
        return np.asarray(np.sqrt((single - mended) / (mended + shared)))

    first, wanted = times(), list[int]()
    for _ in range(MOST_WANTED):
        now = times()
        if now.max() <= LARGEST_TO_POSE:
            break
        at, worst = np.unravel_index(np.argmax(now[:, :natural]), (len(gradients), natural))
        pull = cov @ gradients[at, worst]
        cov = cov - np.outer(pull, pull) / (pose_sd**2 + gradients[at, worst] @ pull)
        wanted.append(int(worst))
    return first, wanted


def variances_along(gradients: FloatArray, cov: FloatArray) -> FloatArray:
    """Variances (m, d), SI, along ``gradients`` (m, d, p)."""
    return np.asarray(np.einsum("mdp,pq,mdq->md", gradients, cov, gradients))


def unchecked_poses(fit: Fit) -> tuple[str, ...]:
    """The poses whose errors would pass into the parameters unnoticed."""
    return tuple(label for label, share in zip(fit.poses.label, free_shares(fit), strict=True)
                 if share < LEAST_REDUNDANCY)
