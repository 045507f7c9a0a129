"""Predictive quality of a calibration by given rests, the criterion for thresholds.

    yᵀQ y - 2 vᵀy = 1

is fitted to the mean readings y of n rests over the magnitude that all of them have, an ellipsoid
through them (Tedaldi, Pretto, Menegatti, ICRA 2014, choose the threshold of the smallest residual).
The residual alone favours few rests: here the residual variance, s² = Σ e² / (n - p) with Student's
factor, is propagated to the corrected magnitude in every direction of the sphere, and its root mean
square there is the score; an error of the equation is twice that of a magnitude. Rests that are
few, badly spread or disturbed all make it larger.
"""

from collections.abc import Sequence

import numpy as np

from calib.poses.attitudes import spread_directions
from calib.poses.imu_log import FloatArray

SINGULAR = 1e-9
"""Singular value of unit columns over the largest, below which rests determine nothing: numerical,
far above rounding, far below what any rests of use have."""

SPARE = 3
"""Rests beyond the number of parameters. Derived: Student's factor ν/(ν - 2) needs three."""

WORTHLESS = 0.03
"""Part of the magnitude. Uncalibrated parts are within ±3 % by their data sheets (MPU-6050), so a
calibration that predicts worse has nothing to say about thresholds. Fact."""

ALIKE = 0.1
"""Relative difference of equivalent scores: the residual of 20 rests scatters by a sixth. Half of
it loses 1 % of the stops in ``tests.bench.study_static_intervals``, twice of it changes nothing.
Tuned."""

SPHERE_POINTS = 200  #: numerical: directions of the mean over the sphere

_EYE = np.eye(9)  #: all nine parameters, each by itself
#: Columns are parameters, rows the elements xx xy xz yy yz zz of Q and the three of v.
MODELS: tuple[FloatArray, ...] = (
    _EYE,
    _EYE[:, [0, 3, 5, 6, 7, 8]],
    np.column_stack([_EYE[:, [0, 3, 5]].sum(axis=1), _EYE[:, 6:]]),
)
"""The whole model, one without misalignment, and one with a common scale: all thresholds are
compared by the first that the rests of any of them determine."""


def best_threshold(rests: Sequence[FloatArray], magnitude: float) -> int | None:
    """Index of the set of rests that predicts best; None where none calibrates.

    Parameters
    ----------
    rests : sequence of array, shape (n, 3)
        Mean nominal readings of the rests that each threshold gives, SI, the lowest first; of
        thresholds alike (ALIKE) the one with most rests is taken, of these the lowest.
    magnitude : float
        What every one of them should measure, SI.

    Returns
    -------
    int or None
        The index of the set.
    """
    for model in MODELS:
        errors = np.array([prediction_error(each, magnitude, model) for each in rests])
        if errors.min() < WORTHLESS * magnitude:
            alike = np.flatnonzero(errors <= (1 + ALIKE) * errors.min())
            return int(max(alike, key=lambda i: len(rests[int(i)])))
    return None


def prediction_error(
    vectors: FloatArray, magnitude: float, model: FloatArray = MODELS[0]
) -> float:
    """Rms over the sphere of the sd of a corrected magnitude, SI; inf where nothing determines it.

    ``vectors`` (n, 3) are the mean readings of rests, ``model`` (9, p) one of :data:`MODELS`.
    """
    n, p = len(vectors), model.shape[1]
    if n < p + SPARE:
        return float("inf")
    design = _columns(vectors / magnitude) @ model
    scale = np.sqrt((design**2).sum(axis=0))
    if not scale.all():
        return float("inf")
    basis, singular, axes = np.linalg.svd(design / scale, full_matrices=False)
    if singular[-1] < SINGULAR * singular[0]:
        return float("inf")
    residual = 1 - basis @ basis.sum(axis=0)
    variance = float(residual @ residual) / (n - p - 2) / 4
    spread = _columns(spread_directions(SPHERE_POINTS)) @ model / scale @ axes.T / singular
    return magnitude * float(np.sqrt(variance * (spread**2).sum(axis=1).mean()))


def _columns(unit: FloatArray) -> FloatArray:
    """Derivative of ``yᵀQ y - 2 vᵀy`` by the six elements of Q and the three of v, (n, 9)."""
    rows, columns = np.triu_indices(3)
    return np.column_stack([unit[:, rows] * unit[:, columns], -2 * unit])
