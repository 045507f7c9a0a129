"""Signature of an effect in the residual of a fit, and the part of it that these poses can see.

The columns of a candidate, whitened like the rows and with everything the fitted model can absorb
projected out, are its signature. A candidate with less than ``VISIBLE_SHARE`` of its size left is
blind: the model would absorb it. Two effects whose signatures span the same space are aliases.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from calib.diagnosis.constants import CONSTANTS
from calib.effects.effect import Effect
from calib.effects.variation import about_mean
from calib.errors import FitFailed
from calib.fit.least_squares.identifiability import ROUNDING, VISIBLE_SHARE
from calib.fit.least_squares.result import Fit
from calib.fit.least_squares.square_start import square_columns
from calib.fit.linear import NORM_FLOOR, orthonormal_columns, times
from calib.fit.rows.problem import Estimate, with_common
from calib.fit.rows.readings import Readings
from calib.fit.rows.sensitive_axes import evaluate_for, sensor_columns
from calib.numbers import NO_LENGTH
from calib.poses.conditions import Conditions
from calib.poses.imu_log import FloatArray

SMALL_MISFIT = VISIBLE_SHARE / 4
"""Misfit over the readings. Derived: four columns make up what shows four times as much of itself.
"""
ROUNDS = 2
"""Number of rounds towards the expected readings, each closer by the factor of the errors of gain,
some per cent. Numerical."""


@dataclass(frozen=True, eq=False)
class Signature:
    """The visible part of a set of columns after the fitted model is projected out.

    Parameters
    ----------
    name : str
    basis : array, shape (r, v)
        Orthonormal directions that are visible.
    strength : array, shape (v,)
        Root mean square signal over the rows along each, for columns of unit size.
    """

    name: str
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
        columns = np.hstack([columns, fit.at.shape_derivatives(fit.equations, shaped).slope])
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
        nothing = Signature(name, np.zeros((len(full), 0)), np.zeros(0))
        if not used.any():
            return nothing
        unit = full[:, used] / norm[used]
        remainder = self(unit) * np.sqrt(self.data_count / used.sum())
        # Directions below VISIBLE_SHARE are dropped, so that squaring in leftᵀ left loses nothing.
        squared, directions = np.linalg.eigh(remainder.T @ remainder)
        visible = squared > VISIBLE_SHARE**2 * self.data_count / used.sum()  # as the fit judges
        strength = np.sqrt(squared[visible])
        return Signature(name, remainder @ (directions[:, visible] / strength), strength)


def at_expected_readings(fit: Fit) -> Fit:
    """``fit`` with its derivatives at the readings that its model expects, the residual as it is.

    At the readings themselves columns hold the residual: a gain of -1 beside a reference that is
    nothing makes up all of it. A small one hides behind ``VISIBLE_SHARE``, and nothing changes.
    """
    if fit.relative_misfit < SMALL_MISFIT:
        return fit
    equations, vector = fit.equations, fit.rows.vector
    n, expected = equations.magnitude, fit.rows.vector.copy()
    share = 1 - times(equations.row_common, fit.eta)[: len(n)]
    length = equations.whitening.stated / share
    expected[n] *= (length / np.linalg.norm(vector[n], axis=1))[:, None]
    at, reading = fit.at, equations.readings.reading
    for _ in range(ROUNDS):
        reading = reading + expected - at.rows.vector
        readings = Readings.of(reading, equations.surroundings, fit.model)
        equations = replace(equations, readings=readings)
        try:
            at = Estimate.of(equations, fit.theta, fit.eta, fit.shapes)
        except FitFailed:  # effects so large that these readings have no vectors
            return fit
    rows = replace(at.rows, residual=fit.rows.residual)
    return replace(fit, equations=equations, at=replace(at, rows=rows))


class Linearisation:
    """What the columns of effects are taken from at ``fit``, or at each of a stack of fits."""

    def __init__(self, fit: Fit) -> None:
        self.fit = fit
        self.sets = int(np.prod(fit.rows.residual.shape[:-1]))

    @cached_property
    def corrected(self) -> Conditions:
        """Conditions with the corrected vectors; a pose at rest is held at its expected reading."""
        return self.fit.equations.conditions(self.fit.rows.vector)

    @cached_property
    def directions(self) -> FloatArray:
        """Sensitivity of every data row to an error of its vector, per SI unit, (..., d, 3)."""
        return self.fit.equations.directions(self.fit.rows.vector, self.fit.rows.slope)

    def varying(self, effect: Effect) -> Effect:
        """Variation of an effect that is a bias or a gain where nothing varies."""
        return about_mean(effect, self.fit.model.names, self.corrected, self.sets)

    def vectors(self, effect: Effect, shape: float | None = None) -> FloatArray:
        """Errors of the vectors by an effect, (..., n, 3, k), SI per unit of each parameter."""
        lead = self.fit.rows.residual.shape[:-1]
        shapes = {} if shape is None else {effect.name: np.full(lead, shape)}
        if effect.acts_on == "reading":
            return evaluate_for(lead, effect, self.fit.equations.at_reading, shapes)
        return sensor_columns((effect,), self.corrected, shapes, self.fit.rows.axes)

    def squares(self, effect: Effect) -> FloatArray:
        """Errors (n, 3, k), SI, by products of parameters that the length shows squared only."""
        equations, s = self.fit.equations, self.fit.rows.vector
        columns, n = square_columns(equations, effect, self.corrected), equations.magnitude
        vectors = np.zeros((*s.shape, columns.shape[1]))
        direction = s[n] / np.linalg.norm(s[n], axis=1, keepdims=True)
        vectors[n] = direction[:, :, None] * columns[:, None, :]
        return vectors

    def rows(self, vectors: FloatArray) -> FloatArray:
        """Whitened columns (..., d, k) of errors (..., n, 3, k) ahead of what follows them."""
        of_rows = vectors[..., self.fit.equations.row_pose, :, :]
        rows = np.einsum("...di,...dik->...dk", self.directions, of_rows)
        return self.without_rounding(rows, (vectors**2).sum(axis=(-3, -2)))

    def without_rounding(self, rows: FloatArray, whole: FloatArray) -> FloatArray:
        """Whitened columns (..., d, k), those that are rounding and no signal zero.

        A rotation is perpendicular to every reading: its rows show next to nothing of the errors
        of the vectors, whose squares, SI, add up to ``whole`` (..., k).
        """
        typical = np.median(self.fit.equations.row_sd, axis=-1)[..., None]
        rounding = np.sqrt((rows**2).sum(axis=-2)) < ROUNDING * np.sqrt(whole) / typical
        return np.where(rounding[..., None, :], 0.0, rows) if rounding.any() else np.asarray(rows)

    def of_reference(self, effect: Effect) -> FloatArray:
        """Whitened columns (..., d, k) of an effect on the reference."""
        lead = self.fit.rows.residual.shape[:-1]
        return self.fit.equations.of_reference(evaluate_for(lead, effect, self.corrected, {}))

    def with_waves(
        self, columns: FloatArray, effect: Effect, shape: float | None = None
    ) -> FloatArray:
        """``columns`` (..., d, k) with what it leaves in the waves of a leaning plate, in sds."""
        waves = self.fit.equations.waves
        if waves is not None:
            columns[..., -waves.count :, :] = waves.columns(self.fit.rows, effect, shape)
        return columns


def whole_columns(fit: Fit, effect: Effect, shape: float | None = None) -> FloatArray:
    """Whitened columns (..., d, k) of ``effect`` over the data rows of a fit, or of many.

    As its formula is, a bias or a gain included. Their sign is that of the effect: a residual of
    ``columns @ theta`` is what theta would leave.
    """
    at = Linearisation(fit)
    if effect.acts_on == "reference":
        return at.of_reference(effect)
    return at.with_waves(at.rows(at.vectors(effect, shape)), effect, shape)


def effect_columns(fit: Fit, effect: Effect, shape: float | None = None) -> FloatArray:
    """Whitened columns (..., d, k) of how an effect varies about what a bias or a gain would hold.
    """
    return whole_columns(fit, Linearisation(fit).varying(effect), shape)


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
