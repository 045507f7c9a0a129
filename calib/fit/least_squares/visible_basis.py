"""Combinations of the parameters that the poses of each set can see."""

from collections.abc import Mapping

import numpy as np

from calib.effects.effect import Effect
from calib.errors import Undetermined
from calib.fit.least_squares.identifiability import (
    ROUNDING,
    VISIBLE_SHARE,
    Refusals,
    varying_columns,
)
from calib.fit.linear import orthonormal_bases
from calib.fit.rows.residuals import Equations
from calib.fit.rows.sensitive_axes import sensor_columns
from calib.fit.rows.whitened_rows import WhitenedRows
from calib.numbers import NO_LENGTH
from calib.poses.imu_log import BoolArray, FloatArray, IntArray


def visible_bases(
    equations: Equations, rows: WhitenedRows, shapes: Mapping[str, FloatArray]
) -> tuple[FloatArray, Refusals]:
    """Combinations of the parameters that the poses can see, in their units.

    Bias, scale and misalignment are kept whole: what they lack is refused. Of every added effect
    only the combinations are fitted that leave ``VISIBLE_SHARE`` or more of their signal after
    everything before them; the others stay at zero, and no sd is stated for them. Cross-coupling
    on wedge poses is the common case: x·y·z is zero in all of them.

    Parameters
    ----------
    equations : Equations
        Of S sets.
    rows : WhitenedRows
        Where the fits start, finite.
    shapes : mapping of effect name to array, shape (S,)
        The shape parameters there.

    Returns
    -------
    basis : array, shape (S, p, v)
        The last columns are zero in a set that sees fewer combinations than others.
    refusals : dict of int to CalibrationError
        Of sets that are blind to an added effect: it leaves nothing at all.
    """
    terms, model = equations.terms, equations.model
    sets, p = len(rows.residual), model.size
    blocks, used = np.tile(np.eye(p), (sets, 1, 1)), np.ones((sets, p), dtype=bool)
    refusals: Refusals = {}
    if terms.is_linear_form:
        return blocks, refusals
    jacobian = rows.jacobian[:, : equations.data_count, :p]
    known = orthonormal_bases(jacobian[:, :, terms.reading.index])
    slices = model.slices()
    for effect in (e for e in model.effects if e.acts_on != "reading"):
        where = slices[effect.name]
        if effect.drawn:  # no row depends on the size of a drawn effect
            blocks[:, where], used[:, where] = 0.0, False
            continue
        columns = np.where(_is_rounding(equations, rows, effect)[:, None], 0.0,
                           jacobian[:, :, where])
        norm = np.sqrt((varying_columns(equations, rows, shapes, effect, columns) ** 2).sum(axis=1))
        columns = np.where(norm[:, None] > 0, columns, 0.0)
        norm = np.maximum(norm, NO_LENGTH)
        _, share, combinations = np.linalg.svd(_beside(known, columns / norm[:, None]),
                                               full_matrices=False)
        lost = (share <= VISIBLE_SHARE).sum(axis=1)
        for k in np.flatnonzero(lost == norm.shape[1]):
            refusals.setdefault(int(k), _blind(equations.take(int(k)), effect))
        seen = _perpendicular(combinations, norm, lost)
        blocks[:, where, where], used[:, where] = seen, seen.any(axis=1)
        known = np.concatenate([known, orthonormal_bases(_beside(known, columns @ seen))], axis=2)
    order = np.argsort(~used, axis=1, kind="stable")[:, : int(used.sum(axis=1).max())]
    return np.take_along_axis(blocks, order[:, None], axis=2), refusals


def _blind(equations: Equations, effect: Effect) -> Undetermined:
    return Undetermined(
        f"{equations.poses.triad}: these poses cannot see '{effect.name}': bias, "
        f"scale, misalignment and the effects before it take up all of it. What "
        f"separates it: {effect.page.separates}."
    )


def _beside(known: FloatArray, columns: FloatArray) -> FloatArray:
    """Part of columns (S, d, k) that is orthogonal to bases (S, d, m)."""
    return np.asarray(columns - known @ (known.swapaxes(1, 2) @ columns))


def _perpendicular(combinations: FloatArray, norm: FloatArray, lost: IntArray) -> FloatArray:
    """Directions orthogonal to the last ``lost`` (S,) of the combinations (S, m, k), (S, k, k).

    In the parameters' own unit: for x·y·z on three axes the sum is fitted, and parameters that are
    seen by themselves are left alone. The last columns are zero where something is lost.
    """
    sets, k = norm.shape
    seen = np.tile(np.eye(k), (sets, 1, 1))
    for i in np.flatnonzero(lost):
        seen[i] = 0.0
        directions = combinations[i, combinations.shape[1] - lost[i] :] / norm[i]
        seen[i, :, : k - lost[i]] = np.linalg.svd(directions)[2][lost[i] :].T
    return seen


def _is_rounding(equations: Equations, rows: WhitenedRows, effect: Effect) -> BoolArray:
    """Parameters of ``effect`` (S, k) that err only across the readings: no length shows them."""
    if effect.acts_on == "reference" or effect.in_square:
        return np.zeros((len(rows.residual), len(effect.parameters)), dtype=bool)
    columns = sensor_columns((effect,), equations.conditions(rows.vector), {}, rows.axes)
    n = rows.vector / np.maximum(np.linalg.norm(rows.vector, axis=-1, keepdims=True), NO_LENGTH)
    seen = np.einsum("sni,snik->snk", n, columns)
    seen[:, equations.null] = np.linalg.norm(columns[:, equations.null], axis=2)
    whole = np.sqrt((columns**2).sum(axis=(1, 2)))
    return np.asarray(np.sqrt((seen**2).sum(axis=1)) < ROUNDING * whole)
