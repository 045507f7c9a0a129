"""Evidence of a set of hypotheses about what is left in the residual, in closed form.

A block is a hypothesis with columns X; a set of blocks is a covariance of the projected residual:

    r ~ N(0, V K),    K = I + Σ_k tau_k² X_k X_kᵀ

tau_k the root mean square signal of block k in noise units. With G = XᵀX and h = Xᵀr the block and
the others are eliminated one after another,

    G_kk - G_ko (G_oo + 1/tau_o²)⁻¹ G_ok,    h_k - G_ko (G_oo + 1/tau_o²)⁻¹ h_o,

and along the eigenvectors of what is left of block k its density is a product for every tau_k. The
columns of one block are orthogonal, so that the last, widest block goes without a solution.

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
TAUS = 2.0 ** np.arange(LARGEST_OCTAVE + 1)
HALF_CAUCHY = TAUS / (1.0 + (TAUS / CONSTANTS.typical_size) ** 2)
"""Derived: its density over the logarithm of tau, up to a factor."""

LOG_PRIOR = np.log(HALF_CAUCHY / HALF_CAUCHY.sum())

RIDGE = 1.0 / 64.0**2
"""Inverse square of a size far above the noise: it keeps what no row shows out of the size of a
block. Numerical."""


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

    Its part of every matrix is diagonal, so that it costs next to nothing however wide it is.

    Parameters
    ----------
    gram : array, shape (B, a, a + w)
        Products of the columns of all blocks but the last with all columns; zero where a block is
        filled up to its width.
    squared : array, shape (B, w)
        Squared lengths of the columns of the last block.
    product : array, shape (B, a + w)
        h.
    chi2 : float
        rᵀr.
    noise : Noise
    widths : tuple of int, length k
        Columns of each block, the same in all sets; the last is w.
    seen : array of int, shape (B, k)
        How many of them are its own.
    """

    gram: FloatArray
    squared: FloatArray
    product: FloatArray
    chi2: float
    noise: Noise
    widths: tuple[int, ...]
    seen: IntArray

    @property
    def _inside(self) -> FloatArray:
        return self.gram[:, :, : self.gram.shape[1]]

    @property
    def _across(self) -> FloatArray:
        return self.gram[:, :, self.gram.shape[1] :]

    @cached_property
    def _fitted(self) -> tuple[FloatArray, FloatArray]:
        """Columns fitted to the residual (B, a + w), and what that leaves of chi-square (B,)."""
        a = self.gram.shape[1]
        length = self.squared + RIDGE
        share = self._across / length[:, None, :]
        matrix = self._inside + RIDGE * np.eye(a) - share @ self._across.swapaxes(1, 2)
        rest = self.product[:, :a] - (share @ self.product[:, a:, None])[:, :, 0]
        first = np.linalg.solve(matrix, rest[:, :, None])
        last = (self.product[:, a:] - (self._across.swapaxes(1, 2) @ first)[:, :, 0]) / length
        solution = np.concatenate([first[:, :, 0], last], axis=1)
        return solution, self.chi2 - (self.product * solution).sum(axis=1)

    def likeliest_sizes(self) -> FloatArray:
        """The tau of every block (B, blocks) near which the density is highest; no unit."""
        solution, unexplained = self._fitted
        least = 1.0 if self.noise.is_known else np.finfo(float).tiny
        variance = np.maximum(
            unexplained / np.maximum(self.noise.dof - self.seen.sum(axis=1), 1), least)
        begin = np.cumsum((0, *self.widths[:-1]))
        mean = np.add.reduceat(solution**2, begin, axis=1) / self.seen
        return np.asarray(np.clip(np.sqrt(mean / variance[:, None]), TAUS[0], TAUS[-1]))

    def at_most(self) -> FloatArray:
        """Upper bound of the log density (B,), no unit: that of the residual fitted at no cost."""
        return np.logaddexp(*self.noise.log_density(self._fitted[1], 0.0, self.chi2))

    def take(self, which: IntArray) -> "Sets":
        """The sets ``which`` alone."""
        return replace(self, gram=self.gram[which], squared=self.squared[which],
                       product=self.product[which], seen=self.seen[which])

    @property
    def are_apart(self) -> BoolArray:
        """Whether every combination of the columns shows ``VISIBLE_SHARE`` of itself, (B,).

        What is less is the error of a formula. More columns than rows are never apart, and no
        member is known by one of them alone.
        """
        if len(self.widths) == 1:
            return np.ones(len(self.gram), dtype=bool)
        length = np.sqrt(np.einsum("baa->ba", self._inside))
        length[length == 0] = 1.0
        inside = self._inside / (length[:, :, None] * length[:, None, :])
        np.einsum("baa->ba", inside)[:] = 1.0 - VISIBLE_SHARE**2
        last = np.where(self.squared > 0, self.squared, 1.0)
        across = self._across / (
            length[:, :, None] * np.sqrt(last * (1 - VISIBLE_SHARE**2))[:, None])
        least = np.linalg.eigvalsh(inside - across @ across.swapaxes(1, 2))[:, 0]
        return np.asarray((least > 0) | (self.seen.sum(axis=1) > self.noise.dof))

    def averaged(self) -> FloatArray:
        """Log density (B,), every size averaged with the others at their likeliest, and V."""
        if len(self.widths) == 1:
            strength = np.sqrt(self.squared)
            along = self.product / np.where(strength > 0, strength, 1.0)
            return block_log_densities(strength, along, self.chi2, self.noise)
        taus = self.likeliest_sizes()
        density, average = np.zeros(len(taus)), np.zeros(len(taus))
        for k in range(len(self.widths)):
            gain = self._over_sizes_of(k, taus)
            best = gain.argmax(axis=0)
            taus[:, k] = TAUS[best]
            density = gain[best, np.arange(len(best))]
            average += over_sizes(gain) - density
        return np.asarray(density + average)

    def _over_sizes_of(self, k: int, taus: FloatArray) -> FloatArray:
        """Log density (taus, B) for every size of block ``k``, the others' as of ``taus``."""
        n, sets = len(TAUS), len(taus)
        if k < len(self.widths) - 1 or self.widths[k] < max(n, 2 * self.gram.shape[1]):
            return self._of_sizes(k, taus, np.asarray(TAUS[:, None]))
        # The last block is large and diagonal, the matrix of all others at most half as large.
        many = np.tile(taus, (n, 1))
        many[:, k] = np.repeat(TAUS, sets)
        every = self.take(np.tile(np.arange(sets), n))
        return every._of_sizes(0, many, many[None, :, 0]).reshape(n, sets)

    def _of_sizes(self, k: int, taus: FloatArray, mine: FloatArray) -> FloatArray:
        """Log density (t, B) for sizes ``mine`` (t, B or 1) of block ``k``."""
        gram, product, chi2, log_det = self._beside(k, taus)
        squared, turns = np.linalg.eigh(gram)
        along = (turns.swapaxes(1, 2) @ product[:, :, None])[:, :, 0] ** 2
        size = mine[:, :, None] ** 2
        signal = size * np.maximum(squared, 0.0)
        fall = (along * size / (1 + signal)).sum(axis=2)
        stated, larger = self.noise.log_density(
            chi2 - fall, log_det + np.log1p(signal).sum(axis=2), self.chi2)
        return np.logaddexp(stated, larger)

    def _beside(self, k: int, taus: FloatArray) -> tuple[FloatArray, ...]:
        """Rest of block ``k`` beside the others of sizes ``taus`` (B, blocks).

        The products of its columns (B, v, v), those with the residual (B, v), its chi-square and
        the log determinant of the others, each (B,).
        """
        a, sizes = self.gram.shape[1], np.repeat(taus, self.widths, axis=1) ** 2
        gram, product, log_det = self._inside, self.product[:, :a], np.zeros(len(taus))
        chi2 = np.full(len(taus), self.chi2)
        if k < len(self.widths) - 1:  # the last block, which is diagonal, goes first
            signal, along = sizes[:, a:] * self.squared, self.product[:, a:]
            share = sizes[:, a:] / (1 + signal)
            held = self._across * share[:, None, :]
            gram = gram - held @ self._across.swapaxes(1, 2)
            product = product - (held @ along[:, :, None])[:, :, 0]
            chi2 = chi2 - (share * along**2).sum(axis=1)
            log_det = np.log1p(signal).sum(axis=1)
        else:
            across, product = self._across, self.product
            gram = np.block([[gram, across],
                             [across.swapaxes(1, 2), self.squared[:, :, None] * np.eye(
                                 self.squared.shape[1])]])
        begin = sum(self.widths[:k])
        mine = np.arange(begin, begin + self.widths[k])
        rest = np.delete(np.arange(gram.shape[1]), mine)
        across, along = gram[:, rest[:, None], mine], product[:, rest, None]
        others = gram[:, rest[:, None], rest] + np.eye(len(rest)) / sizes[:, None, rest]
        solved = np.linalg.solve(others, np.concatenate([across, along], axis=2))
        less = across.swapaxes(1, 2) @ solved
        return (gram[:, mine[:, None], mine] - less[:, :, :-1], product[:, mine] - less[:, :, -1],
                chi2 - (along * solved[:, :, -1:]).sum(axis=(1, 2)),
                log_det + np.linalg.slogdet(others)[1] + np.log(sizes[:, rest]).sum(axis=1))


def width_for(seen: int) -> int:
    """The width to which a block of so many columns is filled up: few widths are few groups.

    What a wide block costs grows with the cube of its width.

    >>> [width_for(seen) for seen in (1, 3, 5, 7, 33, 98)]
    [3, 3, 6, 12, 36, 108]
    """
    return min(3 << max(-(-seen // 3) - 1, 0).bit_length(), 12 * -(-seen // 12))
