"""A screen of thousands of formulas at one solution: the evidence of each alone, by arrays.

A formula is a factor times a function of logged columns, and a function has one value per pose, or
one per pose and axis if it depends on the reading. So the whitened columns of the factors are
evaluated once, and those of each formula are their products with its values, row by row; the
projection and the evidence are those of the table of hypotheses.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from calib.diagnosis.hypotheses.signature import Projector, whole_columns
from calib.diagnosis.search.evidence import block_log_densities
from calib.diagnosis.search.table_at import alike_in_size
from calib.discovery.functions import Function
from calib.discovery.grammar import FACTORS, Factor, Formula
from calib.discovery.response import READING
from calib.effects.expression import read_expression
from calib.effects.user_defined import Per, user_effect
from calib.fit.least_squares.identifiability import VISIBLE_SHARE
from calib.fit.least_squares.result import Fit
from calib.fit.least_squares.unknown_sd import noise_of
from calib.fit.linear import NORM_FLOOR
from calib.numbers import NO_LENGTH
from calib.poses.imu_log import FloatArray
from calib.poses.past import past_columns

NUMBERS_AT_ONCE = 4_000_000  #: elements of whitened columns held at a time; a limit of memory


class FormulaScreen:
    """Basis on which formulas are weighed: the rows of ``fit`` with its model projected out.

    The effects ``tested`` of the model are on trial: they are not projected out.
    """

    def __init__(self, fit: Fit, tested: Sequence[str] = ()) -> None:
        self.fit = fit
        self.projector = Projector(fit, tested)
        self.noise = noise_of(fit, self.projector.dof)
        self._at = fit.equations.at_reading
        self._rows: dict[tuple[Factor, Per], FloatArray] = {}
        self._values: dict[str, FloatArray] = {}

    def log_densities(self, formulas: Sequence[Formula]) -> FloatArray:
        """Log density of the residual under each formula alone, (m,); -inf of a blind one."""
        density = np.full(len(formulas), -np.inf)
        kinds = [(each.factor, each.per, each.column == READING) for each in formulas]
        for kind in dict.fromkeys(kinds):
            factor, per, of_axis = kind
            rows = self._rows_of(factor, per)
            which = np.flatnonzero([each == kind for each in kinds])
            for some in np.array_split(which, 1 + rows.size * len(which) // NUMBERS_AT_ONCE):
                values = np.array([self._values_of(formulas[i].function) for i in some])
                values = values if of_axis else values[..., :1]
                known = np.isfinite(values).all(axis=(1, 2))
                if known.any():
                    density[some[known]] = self._weighed(rows, values[known])
        return density

    def nothing(self, chi2: float | None = None) -> float:
        """Log density of the residual without a formula, or of one with chi-square ``chi2``."""
        return float(np.logaddexp(*self.noise.nothing(self.projector.chi2 if chi2 is None
                                                      else chi2)))

    def _rows_of(self, factor: Factor, per: Per) -> FloatArray:
        """Whitened columns (k, d) of a factor, nothing projected out."""
        if (factor, per) not in self._rows:
            value = read_expression(FACTORS[factor][0] or "1")
            effect = user_effect(factor, value, per, "1", self.fit.poses.triad)
            root = self.projector.root[: self.projector.data_count]
            self._rows[factor, per] = whole_columns(self.fit, effect).T * root
        return self._rows[factor, per]

    def _values_of(self, function: Function) -> FloatArray:
        """Values (n, 3) of a function in the poses; NaN where it has none."""
        text = function.expression
        if text not in self._values:
            read = read_expression(text)
            more = past_columns(self._at.columns, self._at.time_s, read.pasts)
            at = replace(self._at, columns={**self._at.columns, **more}) if more else self._at
            self._values[text] = read(at)
        return self._values[text]

    def _weighed(self, rows: FloatArray, values: FloatArray) -> FloatArray:
        """Log densities (w,) under blocks of columns: ``rows`` (k, d) times ``values`` (w, n, 1).

        For a function of the reading, ``values`` are (w, n, 3), one for each of three columns.
        """
        d = self.projector.data_count
        full = np.zeros((len(values), len(rows), len(self.projector.residual)))
        full[..., :d] = rows * values.swapaxes(1, 2)[..., self.fit.equations.row_pose]
        norm = np.sqrt((full**2).sum(axis=2))
        together = np.maximum(np.sqrt((norm**2).sum(axis=1, keepdims=True)), NO_LENGTH)
        norm[norm <= NORM_FLOOR * np.maximum(norm.max(axis=1, keepdims=True), NO_LENGTH)] = np.inf
        used = np.maximum(np.isfinite(norm).sum(axis=1), 1)
        signal = np.sqrt(d / used)  # all columns of a block together have one sd in each row
        full *= (signal[:, None] / norm)[..., None]
        full -= (full @ self.projector.model) @ self.projector.model.T
        squared, turns = np.linalg.eigh(full @ full.swapaxes(1, 2))
        visible = squared > (VISIBLE_SHARE * signal[:, None]) ** 2
        alike = np.where(np.isfinite(norm), norm / together * np.sqrt(used)[:, None], 1.0)
        squared, mixed = alike_in_size(squared, turns, visible, np.maximum(alike, VISIBLE_SHARE))
        strength = np.sqrt(np.where(visible, squared, 0.0))
        along = np.einsum("wvu,wku,wk->wv", mixed, turns, full @ self.projector.residual)
        amplitude = np.divide(along, strength, out=np.zeros_like(along), where=strength > 0)
        density = block_log_densities(strength, amplitude, self.projector.chi2, self.noise)
        return np.where(strength.any(axis=1), density, -np.inf)
