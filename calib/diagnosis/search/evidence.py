"""Evidence of a set of hypotheses about what is left in the residual, in closed form.

A block is a hypothesis with columns X; a set of blocks is a covariance of the projected residual:

    r ~ N(0, V K),    K = I + Σ_k tau_k² X_k X_kᵀ

tau_k the root mean square signal of block k in noise units. The columns of one block are
orthogonal, so that the widest block, the last, goes without a solution. With D its squared lengths,
A the products of the other columns with them, G those of the others among themselves, h those with
the residual, S = τ²/(1 + τ² D) for the last and T the sizes of the others, one Cholesky factor

    ⎡ I + T (G - A S Aᵀ) T    T (h - A S h_w) ⎤
    ⎣           .                    ∞        ⎦  =  L Lᵀ

has the determinant of K on its diagonal, and in the last row y by which rᵀ K⁻¹ r = rᵀr - h_wᵀ S h_w
- yᵀy.

The variance V is that of :mod:`calib.fit.noise_size`. Log densities are relative to those of unit
rows without any constant. They are averaged over tau = 1, 2, 4 ... and over V: no threshold is
needed, parameters that buy nothing cost, and nothing ties where p-values underflow. The prior of
tau is a half-Cauchy distribution (Gelman, Bayesian Analysis 1, 2006), whose tail is heavy enough
for any signal.
"""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from calib.diagnosis.constants import CONSTANTS
from calib.fit.least_squares.identifiability import VISIBLE_SHARE
from calib.fit.noise_size import LARGEST_OCTAVE, Noise
from calib.poses.imu_log import BoolArray, FloatArray, IntArray

#: sizes of an effect, noise units, each twice the one before; numerical
TAUS = np.exp2(np.arange(LARGEST_OCTAVE + 1, dtype=float))
HALF_CAUCHY = TAUS / (1.0 + (TAUS / CONSTANTS.typical_size) ** 2)
"""Derived: its density over the logarithm of tau, up to a factor."""

LOG_PRIOR = np.log(HALF_CAUCHY / HALF_CAUCHY.sum())

RIDGE = 1.0 / 64.0**2
"""Inverse square of a size far above the noise: it keeps what no row shows out of the size of a
block. Numerical."""

CACHED = 2**18  #: numbers in a processor's own cache, 2 MB; numerical


def over_sizes(gain: FloatArray) -> FloatArray:
    """Average over tau of log densities ``gain`` (taus, ...), one less axis: (...,)."""
    weighed = gain + LOG_PRIOR.reshape(-1, *(1,) * (gain.ndim - 1))
    most = weighed.max(axis=0)
    return np.asarray(most + np.log(np.exp(weighed - most).sum(axis=0)))


def block_log_densities(
    strength: FloatArray, amplitude: FloatArray, chi2: float | FloatArray, noise: Noise
) -> FloatArray:
    """Log density of the residual under each of m single blocks of orthogonal columns, (m,).

    Parameters
    ----------
    strength, amplitude : array, shape (m, v)
        Signal along each visible direction for unit tau, and the residual along it; both zero
        where a block has fewer directions. A strength of shape (1, v) is that of all m.
    chi2 : float or array, shape (m,)
        Of the whole projected residual, or of that of each block.
    noise : Noise
    """
    signal = (TAUS[:, None, None] * strength) ** 2
    share = signal / (1 + signal)  # (taus, m or 1, v)
    falls = (share[:, 0] @ (amplitude**2).T if len(strength) == 1
             else (amplitude**2 * share).sum(axis=2))
    q = chi2 - falls
    log_det = np.log1p(signal).sum(axis=2)
    stated, larger = noise.log_density(q, log_det, chi2)
    return over_sizes(np.logaddexp(stated, larger))


@dataclass(frozen=True, eq=False)
class Sets:
    """B sets of k blocks about one residual, the columns of the last block orthogonal.

    Parameters
    ----------
    gram : array, shape (B, a, a + w)
        Products of the columns of all blocks but the last with all columns; zero where a set has
        fewer than a of these, or w of the last.
    squared : array, shape (B, w)
        Squared lengths of the columns of the last block.
    product : array, shape (B, a + w)
        h.
    block : array of int, shape (B, a)
        Which block each of the first columns is of.
    seen : array of int, shape (B, k)
        How many columns each block has.
    chi2 : float
        rᵀr.
    noise : Noise
    """

    gram: FloatArray
    squared: FloatArray
    product: FloatArray
    block: IntArray
    seen: IntArray
    chi2: float
    noise: Noise

    @property
    def _parts(self) -> tuple[FloatArray, ...]:
        """Products of the first columns with themselves and with the last, of both with r."""
        a = self.gram.shape[1]
        return self.gram[..., :a], self.gram[..., a:], self.product[:, :a], self.product[:, a:]

    @cached_property
    def _fitted(self) -> tuple[FloatArray, FloatArray]:
        """Columns fitted to the residual (B, a + w), and what that leaves of chi-square (B,)."""
        inside, across, first, last = self._parts
        length = self.squared + RIDGE
        share = across / length[:, None, :]
        matrix = inside + RIDGE * np.eye(inside.shape[1]) - share @ across.swapaxes(1, 2)
        mine = np.linalg.solve(matrix, first[..., None] - share @ last[..., None])
        other = (last - (across.swapaxes(1, 2) @ mine)[..., 0]) / length
        solution = np.concatenate([mine[..., 0], other], axis=1)
        return solution, self.chi2 - (self.product * solution).sum(axis=1)

    def likeliest_sizes(self) -> FloatArray:
        """The tau of every block (B, k) near which the density is highest; no unit."""
        solution, unexplained = self._fitted
        a, count = self.gram.shape[1], self.seen.shape[1]
        least = 1.0 if self.noise.is_known else np.finfo(float).tiny
        variance = np.maximum(
            unexplained / np.maximum(self.noise.dof - self.seen.sum(axis=1), 1), least)
        square = solution**2
        total = np.stack([*((square[:, :a] * (self.block == k)).sum(axis=1)
                            for k in range(count - 1)), square[:, a:].sum(axis=1)], axis=1)
        return np.asarray(
            np.clip(np.sqrt(total / self.seen / variance[:, None]), TAUS[0], TAUS[-1]))

    def at_most(self) -> FloatArray:
        """Upper bound of the log density (B,), no unit: that of the residual fitted at no cost."""
        return np.logaddexp(*self.noise.log_density(self._fitted[1], 0.0, self.chi2))

    def take(self, which: IntArray | slice) -> "Sets":
        """The sets ``which`` alone."""
        return replace(self, gram=self.gram[which], squared=self.squared[which],
                       product=self.product[which], block=self.block[which], seen=self.seen[which])

    @property
    def are_apart(self) -> BoolArray:
        """Whether every combination of the columns shows ``VISIBLE_SHARE`` of itself, (B,).

        What is less is the error of a formula. More columns than rows are never apart, and no
        member is known by one of them alone.
        """
        inside, across, _, _ = self._parts
        if not inside.shape[1]:
            return np.ones(len(inside), dtype=bool)
        length = np.sqrt(np.einsum("baa->ba", inside))
        length[length == 0] = 1.0
        inside = inside / (length[:, :, None] * length[:, None, :])
        np.einsum("baa->ba", inside)[:] = 1.0 - VISIBLE_SHARE**2
        last = np.where(self.squared > 0, self.squared, 1.0)
        across = across / (
            length[:, :, None] * np.sqrt(last * (1 - VISIBLE_SHARE**2))[:, None])
        least = np.linalg.eigvalsh(inside - across @ across.swapaxes(1, 2))[:, 0]
        return np.asarray((least > 0) | (self.seen.sum(axis=1) > self.noise.dof))

    def averaged(self) -> FloatArray:
        """Log density (B,), every size averaged with the others at their likeliest, and V."""
        if not self.gram.shape[1]:
            strength = np.sqrt(self.squared)
            along = self.product / np.where(strength > 0, strength, 1.0)
            return block_log_densities(strength, along, self.chi2, self.noise)
        taus = self.likeliest_sizes()
        density, average = np.zeros((2, len(taus)))
        last = taus.shape[1] - 1
        solved = self._without_last(taus[None, :, last:])
        for k in range(last + 1):
            gain = self._log_densities(k, taus, *solved) if k < last else self._of_last(taus)
            best = gain.argmax(axis=0)
            taus[:, k] = TAUS[best]
            density = gain[best, np.arange(len(best))]
            average += over_sizes(gain) - density
        return np.asarray(density + average)

    def _of_last(self, taus: FloatArray) -> FloatArray:
        """Log density (sizes, B) for every size of the last block, those of others in ``taus``.

        So many sets at once as stay in the cache: their matrices are as many as sizes.
        """
        step = max(1, CACHED // (len(TAUS) * self.gram[0].size))
        some = [slice(first, first + step) for first in range(0, len(taus), step)]
        return np.concatenate([
            part._log_densities(taus.shape[1] - 1, taus[one],
                                *part._without_last(TAUS[:, None, None]))
            for one, part in ((one, self.take(one)) for one in some)], axis=1)

    def _without_last(self, size: FloatArray) -> tuple[FloatArray, FloatArray]:
        """The matrix (sizes, B, a + 1, a + 1) less the last block of ``size`` (sizes, B or 1, 1).

        And the logarithm (sizes, B) of that block's determinant.
        """
        inside, across, along, of_last = self._parts
        a, squares = inside.shape[1], size**2
        signal = squares * self.squared
        share = squares / (1 + signal)
        log_det = np.log1p(signal).sum(axis=-1)
        held = across * share[:, :, None, :]
        matrix = np.empty((*held.shape[:2], a + 1, a + 1))
        matrix[..., :a, :a] = inside - held @ across.swapaxes(1, 2)
        matrix[..., a, :a] = matrix[..., :a, a] = along - (held @ of_last[..., None])[..., 0]
        matrix[..., a, a] = self.chi2 - (share * of_last**2).sum(axis=-1)
        return matrix, log_det

    def _log_densities(
        self, k: int, taus: FloatArray, matrix: FloatArray, log_det: FloatArray
    ) -> FloatArray:
        """Log density (sizes, B) for every size of block ``k``, the others' as of ``taus`` (B, k).

        ``matrix`` and ``log_det`` as of :meth:`_without_last`.
        """
        last, a = taus.shape[1] - 1, self.block.shape[1]
        size = np.take_along_axis(taus, self.block, axis=1)[None]
        if k < last:
            size = np.where(self.block == k, TAUS[:, None, None], size)
            order = np.argsort(self.block == k, axis=1, kind="stable")
            size = np.take_along_axis(size, order[None], axis=2)
            fixed = a - int((self.block == k).sum(axis=1).max())
            order = np.pad(order, ((0, 0), (0, 1)), constant_values=a)
            sets = np.arange(len(order))[:, None, None]
            matrix = matrix[0, sets, order[:, :, None], order[:, None, :]]
            side = matrix[:, :fixed, :] * size[0, :, :fixed, None]
            others = np.eye(fixed) + side[..., :fixed] * size[0, :, None, :fixed]
            side = side[..., fixed:]
            matrix = (matrix[:, fixed:, fixed:]
                      - side.swapaxes(1, 2) @ np.linalg.solve(others, side))[None]
            log_det = log_det + np.linalg.slogdet(others)[1]
            size = size[..., fixed:]
        a = size.shape[2]
        scale = np.concatenate([size, np.ones((*size.shape[:2], 1))], axis=2)
        matrix = matrix * scale[..., :, None] * scale[..., None, :]
        q = matrix[..., a, a].copy()
        np.einsum("...aa->...a", matrix)[...] += 1
        matrix[..., a, a] += self.chi2  # more than yᵀy
        lower = np.linalg.cholesky(matrix)
        log_det = log_det + 2 * np.log(np.einsum("...aa->...a", lower)[..., :a]).sum(axis=-1)
        return np.logaddexp(*self.noise.log_density(
            q - (lower[..., a, :a] ** 2).sum(axis=-1), log_det, self.chi2))


def width_for(seen: int) -> int:
    """The width to which a block of so many columns is filled up: few widths are few groups.

    >>> [width_for(seen) for seen in (1, 3, 5, 12, 33, 98)]
    [3, 3, 12, 12, 36, 108]
    """
    width = 12 if seen > 3 else 3
    while width < seen:
        width *= 3
    return width
