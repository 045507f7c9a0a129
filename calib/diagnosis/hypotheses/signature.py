"""Signature of an effect in the residual of a fit, and the part of it that these poses can see.

The columns of a candidate, whitened like the rows and with everything the fitted model can absorb
projected out, are its signature. A candidate with less than ``VISIBLE_SHARE`` of its size left is
blind: the model would absorb it. Two effects whose signatures span the same space are aliases.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from calib.diagnosis.constants import CONSTANTS
from calib.effects.effect import Effect
from calib.effects.variation import about_mean
from calib.fit.least_squares.identifiability import ROUNDING, VISIBLE_SHARE
from calib.fit.least_squares.result import Fit
from calib.fit.least_squares.square_start import square_columns
from calib.fit.linear import NORM_FLOOR, orthonormal_columns
from calib.fit.rows.problem import with_common
from calib.fit.rows.sensitive_axes import evaluate_for, sensor_columns
from calib.fit.rows.shape_derivatives import shape_derivatives
from calib.numbers import NO_LENGTH
from calib.poses.imu_log import BoolArray, FloatArray


@dataclass(frozen=True, eq=False)
class Signature:
    """The visible part of a set of columns after the fitted model is projected out.

    Parameters
    ----------
    name : str
    columns : array, shape (r, k)
        Change of the whitened residual per unit of minus each parameter, nothing projected out.
    basis : array, shape (r, v)
        Orthonormal directions that are visible.
    strength : array, shape (v,)
        Root mean square signal over the rows along each, for columns of unit size.
    """

    name: str
    columns: FloatArray
    basis: FloatArray
    strength: FloatArray

    @property
    def is_blind(self) -> bool:
        """Whether the fitted model absorbs all of it."""
        return len(self.strength) == 0

    @property
    def seen(self) -> int:
        """Number of parameter combinations that these poses can see."""
        return len(self.strength)


def positions_of(fit: Fit, names: Sequence[str]) -> list[int]:
    """Indices in theta of the parameters of these effects."""
    slices = fit.model.slices()
    return [i for name in names for i in range(slices[name].start, slices[name].stop)]


def untested_columns(fit: Fit, tested: Sequence[str]) -> FloatArray:
    """Whitened columns (r, k) along which the model was fitted, without the effects ``tested``.

    Combinations of parameters that the fit holds absorb nothing; shape parameters do.
    """
    where = positions_of(fit, tested)
    basis = fit.basis[:, ~fit.basis[where].any(axis=0)]
    columns = fit.rows.jacobian @ with_common(basis, len(fit.eta))
    shaped = [name for name, sd in fit.log_shape_sd.items()
              if name not in tested and not np.isnan(sd)]
    if shaped:
        slope = shape_derivatives(
            fit.equations, fit.theta, fit.eta, fit.shapes, fit.rows, shaped).slope
        columns = np.hstack([columns, slope])
    return np.asarray(columns * np.sqrt(fit.weight)[:, None])


class Projector:
    """Projects the fitted model out of whitened rows.

    ``tested`` names the effects of the model that are on trial: their columns are kept out of what
    is projected, and what they explained is put back into the residual. ``model`` (r, k) is an
    orthonormal basis of the other columns.
    """

    def __init__(self, fit: Fit, tested: Sequence[str] = ()) -> None:
        self.root = np.sqrt(fit.weight)
        residual, self.dof = fit.rows.residual, fit.dof
        if tested:
            where = positions_of(fit, tested)
            residual = residual - fit.rows.jacobian[:, where] @ fit.theta[where]
            # For each effect, combinations of its own parameters are fitted.
            self.dof += int(fit.basis[where].any(axis=0).sum())
            self.dof += sum(name in fit.shapes for name in tested)
        self.model = orthonormal_columns(untested_columns(fit, tested))
        self.residual = self(residual * self.root)
        self.chi2 = float(self.residual @ self.residual)
        self.data_count = fit.equations.data_count

    def __call__(self, rows: FloatArray) -> FloatArray:
        return np.asarray(rows - self.model @ (self.model.T @ rows))

    def signature(self, name: str, columns: FloatArray) -> Signature:
        """The visible part of ``columns`` (d, k) over the data rows."""
        full = np.zeros((len(self.residual), columns.shape[1]))
        full[: len(columns)] = columns
        full *= self.root[:, None]
        norm = np.sqrt((full**2).sum(axis=0))
        used = norm > NORM_FLOOR * max(float(norm.max(initial=0.0)), NO_LENGTH)
        nothing = Signature(name, columns, np.zeros((len(full), 0)), np.zeros(0))
        if not used.any():
            return nothing
        unit = full[:, used] / norm[used]
        remainder = self(unit) * np.sqrt(self.data_count / used.sum())
        # Directions below VISIBLE_SHARE are dropped, so that squaring in leftᵀ left loses nothing.
        squared, directions = np.linalg.eigh(remainder.T @ remainder)
        visible = squared > VISIBLE_SHARE**2 * self.data_count / used.sum()  # as the fit judges
        strength = np.sqrt(squared[visible])
        return Signature(name, columns, remainder @ (directions[:, visible] / strength), strength)


def effect_columns(
    fit: Fit, effect: Effect, shape: float | None = None
) -> FloatArray:
    """Columns (..., d, k) of ``effect`` over the data rows of a fit, or of many, whitened.

    Of an effect that is a bias or a gain where nothing varies, those of how it varies
    (:func:`calib.effects.variation.about_mean`). Their sign is that of the effect: a residual of
    ``columns @ theta`` is what theta would leave.
    """
    sets = int(np.prod(fit.rows.residual.shape[:-1]))
    return whole_columns(fit, about_mean(effect, fit.model.names, sets), shape)


def whole_columns(
    fit: Fit, effect: Effect, shape: float | None = None
) -> FloatArray:
    """Whitened columns (..., d, k) of ``effect`` as its formula is, a bias or a gain included."""
    if effect.acts_on == "reference":
        return reference_columns(fit, effect)
    return with_waves(fit, vector_columns(fit, _whole_vectors(fit, effect, shape)), effect, shape)


def with_waves(
    fit: Fit, columns: FloatArray, effect: Effect, shape: float | None = None
) -> FloatArray:
    """``columns`` (..., d, k) with what it leaves in the waves of a leaning plate, in sds."""
    waves = fit.equations.waves
    if waves is not None:
        columns[..., -waves.count :, :] = waves.columns(fit.rows, effect, shape)
    return columns


def _whole_vectors(fit: Fit, effect: Effect, shape: float | None) -> FloatArray:
    equations, lead = fit.equations, fit.rows.residual.shape[:-1]
    shapes = {} if shape is None else {effect.name: np.full(lead, shape)}
    if effect.acts_on == "reading":
        return evaluate_for(lead, effect, equations.at_reading, shapes)
    at = equations.conditions(fit.rows.vector)
    return sensor_columns((effect,), at, shapes, fit.rows.axes)


def square_vectors(fit: Fit, effect: Effect) -> FloatArray:
    """Errors (n, 3, k), SI, by the products of parameters that the length shows squared only."""
    equations = fit.equations
    n, s = equations.magnitude, fit.rows.vector
    columns = square_columns(equations, effect, equations.conditions(s))
    vectors = np.zeros((*s.shape, columns.shape[1]))
    direction = s[n] / np.linalg.norm(s[n], axis=1, keepdims=True)
    vectors[n] = direction[:, :, None] * columns[:, None, :]
    return vectors


def reference_columns(fit: Fit, effect: Effect) -> FloatArray:
    """Whitened columns (..., d, k) of an effect on the reference."""
    equations, lead = fit.equations, fit.rows.residual.shape[:-1]
    return equations.of_reference(
        evaluate_for(lead, effect, equations.conditions(fit.rows.vector), {}))


def vector_columns(fit: Fit, vectors: FloatArray) -> FloatArray:
    """Whitened columns (..., d, k) of errors (..., n, 3, k) ahead of what follows the vector."""
    pose = fit.equations.row_pose
    directions = fit.equations.directions(fit.rows.vector, fit.rows.slope)
    rows = np.einsum("...di,...dik->...dk", directions, vectors[..., pose, :, :])
    shown, whole = (rows**2).sum(axis=-2), (vectors**2).sum(axis=(-3, -2))
    rounding = is_rounding(fit, shown, whole)
    return np.where(rounding[..., None, :], 0.0, rows) if rounding.any() else np.asarray(rows)


def is_rounding(fit: Fit, shown: FloatArray, whole: FloatArray) -> BoolArray:
    """Whether columns are rounding, not a signal, (..., k).

    A rotation is perpendicular to every reading: its rows show next to nothing of it.

    Parameters
    ----------
    fit : Fit
    shown : array, shape (..., k)
        Sum of the squares of the whitened rows.
    whole : array, shape (..., k)
        Sum of the squares of the vectors' errors, SI.
    """
    typical = np.median(fit.equations.row_sd, axis=-1)[..., None]
    return np.asarray(np.sqrt(shown) < ROUNDING * np.sqrt(whole) / typical)


def contains(larger: Signature, smaller: Signature) -> bool:
    """Whether all of ``smaller`` lies in the space that ``larger`` spans."""
    if smaller.is_blind or larger.seen < smaller.seen:
        return False
    overlap = smaller.basis.T @ larger.basis
    if (overlap**2).sum() < smaller.seen * CONSTANTS.alias_correlation**2:
        return False
    correlation = np.linalg.svd(overlap, compute_uv=False)
    return bool(correlation[: smaller.seen].min() > CONSTANTS.alias_correlation)


def are_aliases(a: Signature, b: Signature) -> bool:
    """Whether two signatures span the same space: smallest canonical correlation over 0.99."""
    return a.seen == b.seen and contains(a, b)
