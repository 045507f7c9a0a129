"""Predictive quality of a calibration by given rests, the criterion for thresholds.

    |M v_i + c| = m + e_i,    M upper triangular

is fitted to the mean nominal readings v_i of n rests (Tedaldi, Pretto, Menegatti, ICRA 2014, choose
the threshold of the smallest residual). The residual alone favours few rests: here the residual
variance, s² = Σ e² / (n - p) with Student's factor, is propagated to the corrected magnitude in
every direction of the sphere, and its root mean square there is the score. Rests that are few,
badly spread or disturbed all make it larger.
"""

from collections.abc import Sequence

import numpy as np

from calib.poses.attitudes import spread_directions
from calib.poses.imu_log import FloatArray

STEPS = 12  #: numerical limit
SMALLEST_STEP = 1e-12
"""Step of a gain, and of a bias over the magnitude: rounding."""

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
#: Columns are parameters, rows the elements xx xy xz yy yz zz of M and the three of c.
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
    theta = np.array([1.0, 0, 0, 1, 0, 1, 0, 0, 0])
    with np.errstate(over="ignore", invalid="ignore"):  # a diverging iteration ends as not finite
        for _ in range(STEPS):
            length, columns = _magnitude(vectors, theta)
            if not np.isfinite(columns).all():
                return float("inf")
            step = np.linalg.lstsq(columns @ model, length - magnitude)[0]
            theta = theta - model @ step
            if np.abs(step).max() < SMALLEST_STEP * magnitude:
                break
        length, columns = _magnitude(vectors, theta)
        residual = length - magnitude
        variance = float(residual @ residual) / (n - p - 2)
    design = columns @ model
    scale = np.sqrt((design**2).sum(axis=0))
    if not (np.isfinite(variance) and scale.all()):
        return float("inf")
    singular, axes = np.linalg.svd(design / scale, full_matrices=False)[1:]
    if singular[-1] < SINGULAR * singular[0]:
        return float("inf")
    directions = spread_directions(SPHERE_POINTS)
    spread = _columns(directions, magnitude * directions) @ model / scale @ axes.T / singular
    return float(np.sqrt(variance * (spread**2).sum(axis=1).mean()))


def _magnitude(vectors: FloatArray, theta: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Corrected magnitudes (n,) and their derivative by ``theta``, (n, 9)."""
    matrix = np.zeros((3, 3))
    matrix[np.triu_indices(3)] = theta[:6]
    corrected = vectors @ matrix.T + theta[6:]
    length = np.linalg.norm(corrected, axis=1)
    return length, _columns(corrected / length[:, None], vectors)


def _columns(unit: FloatArray, vectors: FloatArray) -> FloatArray:
    """Derivative of ``unit · (M v + c)`` by the six elements of M and the three of c, (n, 9)."""
    rows, columns = np.triu_indices(3)
    return np.column_stack([unit[:, rows] * vectors[:, columns], unit])
