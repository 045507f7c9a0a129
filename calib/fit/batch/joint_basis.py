"""Which combinations of parameters the poses of each set can see: a stack of
:func:`calib.fit.least_squares.identifiability.visible_basis`."""

import numpy as np

from calib.effects.effect import Effect
from calib.effects.variation import about_mean
from calib.fit.batch.joint_axes import JointAxes
from calib.fit.batch.joint_equations import JointEquations, Shapes
from calib.fit.batch.joint_rows import JointRows
from calib.fit.column_scaling import orthonormal_bases
from calib.fit.least_squares.identifiability import ROUNDING, VISIBLE_SHARE
from calib.numbers import NO_LENGTH
from calib.poses.imu_log import BoolArray, FloatArray


def visible_bases(
    equations: JointEquations, rows: JointRows, shapes: Shapes
) -> list[FloatArray | None]:
    """Combinations (p, visible) of every set, its bias, scale and misalignment whole.

    Parameters
    ----------
    equations : JointEquations
        Of S sets under a model of p parameters.
    rows : JointRows
        Finite, where the fits start.
    shapes : mapping of str to array, shape (S,)

    Returns
    -------
    list of array or None
        None where the poses are blind to an added effect.
    """
    one, model = equations.one, equations.one.model
    sets, p = len(equations), model.size
    jacobian = rows.jacobian[:, : one.data_count, :p]
    slices = model.slices()
    known = orthonormal_bases(jacobian[:, :, one.reading_index])
    blocks = np.tile(np.eye(p), (sets, 1, 1))
    is_blind = np.zeros(sets, dtype=bool)
    is_used = np.ones((sets, p), dtype=bool)
    for effect in model.effects:
        if effect.acts_on == "reading":
            continue
        where = slices[effect.name]
        columns = jacobian[:, :, where]
        columns = np.where(_is_rounding(equations, rows, shapes, effect)[:, None], 0.0, columns)
        norm = np.sqrt((_varying(equations, rows, shapes, effect, columns) ** 2).sum(axis=1))
        columns = np.where(norm[:, None] > 0, columns, 0.0)
        norm = np.maximum(norm, NO_LENGTH)
        remainder = _beside(known, columns / norm[:, None])
        _, share, combinations = np.linalg.svd(remainder, full_matrices=False)
        lost = (share <= VISIBLE_SHARE).sum(axis=1)
        seen, kept = _perpendicular(combinations, norm, lost)
        blocks[:, where, where] = seen
        is_used[:, where] = kept
        is_blind |= lost == norm.shape[1]
        known = np.concatenate([known, orthonormal_bases(_beside(known, columns @ seen))], axis=2)
    return [None if blind else block[:, used]
            for blind, block, used in zip(is_blind, blocks, is_used, strict=True)]


def _varying(
    equations: JointEquations, rows: JointRows, shapes: Shapes, effect: Effect, columns: FloatArray
) -> FloatArray:
    """Columns (S, d, k) of ``effect`` about their mean."""
    one, sets, n = equations.one, len(equations), rows.vector.shape[1]
    varying = about_mean(effect, one.model.names, sets)
    if varying is effect:
        return columns
    held = equations.held(rows.vector)
    if effect.acts_on == "reference":
        at = equations.at_start.with_vector(held.reshape(-1, 3))
        errors = varying.evaluate(at).reshape(sets, n, -1)[:, one.magnitude]
        whitened = np.zeros_like(columns)
        whitened[:, : errors.shape[1]] = errors / equations.magnitude_sd[:, :, None]
        return whitened
    axes = JointAxes(rows.to_orthogonal, rows.to_sensed, np.ones((sets, 3)))
    vectors = equations.columns((varying,), held, shapes, axes)
    return equations.whitened(vectors, rows.vector) * columns.any(axis=1, keepdims=True)


def _perpendicular(
    combinations: FloatArray, norm: FloatArray, lost: FloatArray
) -> tuple[FloatArray, BoolArray]:
    """What is perpendicular to the last ``lost`` (S,) of the combinations (S, m, k), in the
    parameters' own unit: columns (S, k, k), and which of them (S, k) are used.
    """
    sets, k = norm.shape
    seen = np.tile(np.eye(k), (sets, 1, 1))
    kept = np.ones((sets, k), dtype=bool)
    for count in map(int, np.unique(lost)):
        if not 0 < count < k:
            continue
        some = np.flatnonzero(lost == count)
        directions = combinations[some, -count:] / norm[some, None]
        seen[some] = 0.0
        seen[some, :, : k - count] = np.linalg.svd(directions)[2][:, count:].swapaxes(1, 2)
        kept[some, k - count :] = False
    return seen, kept


def _beside(known: FloatArray, columns: FloatArray) -> FloatArray:
    """What bases (S, d, m) leave of columns (S, d, k)."""
    return np.asarray(columns - known @ (known.swapaxes(1, 2) @ columns))


def _is_rounding(
    equations: JointEquations, rows: JointRows, shapes: Shapes, effect: Effect
) -> BoolArray:
    """Which parameters (S, k) of ``effect`` only err across the readings: no length shows them."""
    if effect.acts_on == "reference":
        return np.zeros((len(equations), len(effect.parameters)), dtype=bool)
    axes = JointAxes(rows.to_orthogonal, rows.to_sensed, np.ones((len(equations), 3)))
    columns = equations.columns((effect,), equations.held(rows.vector), shapes, axes)
    n = rows.vector / np.maximum(np.linalg.norm(rows.vector, axis=2, keepdims=True), NO_LENGTH)
    shown = (n[:, :, None] @ columns)[:, :, 0]
    null = equations.one.null
    shown[:, null] = np.sqrt((columns[:, null] ** 2).sum(axis=2))
    whole = np.sqrt((columns**2).sum(axis=(1, 2)))
    return np.asarray(np.sqrt((shown**2).sum(axis=1)) < ROUNDING * whole)
