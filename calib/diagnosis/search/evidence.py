"""Evidence of a set of hypotheses about what is left in the residual, in closed form.

A block is a hypothesis with columns X; a set of blocks is a covariance of the projected residual:

    r ~ N(0, V K),    K = I + Σ_k tau_k² X_k X_kᵀ

tau_k the root mean square signal of block k in noise units. With D = diag(tau) over the columns of
all blocks, G = XᵀX and h = Xᵀr, one Cholesky factor of a small matrix gives both parts of it:

    [ I + D G D    D h  ]      log det K = log det (I + D G D)
    [ (D h)ᵀ      rᵀr+1 ]      Q = rᵀK⁻¹r = last pivot - 1

The columns of one block are orthogonal, so that its part of this matrix is diagonal: that of the
last, widest block is eliminated beforehand, and the factor is of the others alone.

The variance V is that of :mod:`calib.fit.noise_size`. Log densities are relative to those of unit
rows without any constant. They are averaged over tau = 1, 2, 4 ... and over V: no threshold is
needed, parameters that buy nothing cost, and nothing ties where p-values underflow. The prior of
tau is a half-Cauchy distribution (Gelman, Bayesian Analysis 1, 2006), whose tail is heavy enough
for any signal.
"""

from dataclasses import dataclass

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
    return np.asarray(np.logaddexp.reduce(weighed, axis=0))


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

    def likeliest_sizes(self) -> FloatArray:
        """The tau of every block (B, blocks) near which the density is highest; no unit."""
        a = self.gram.shape[1]
        length = self.squared + RIDGE
        share = self._across / length[:, None, :]
        matrix = self._inside + RIDGE * np.eye(a) - share @ self._across.swapaxes(1, 2)
        rest = self.product[:, :a] - (share @ self.product[:, a:, None])[:, :, 0]
        first = np.linalg.solve(matrix, rest[:, :, None])
        last = (self.product[:, a:] - (self._across.swapaxes(1, 2) @ first)[:, :, 0]) / length
        solution = np.concatenate([first[:, :, 0], last], axis=1)
        unexplained = self.chi2 - (self.product * solution).sum(axis=1)
        least = 1.0 if self.noise.is_known else np.finfo(float).tiny
        variance = np.maximum(
            unexplained / np.maximum(self.noise.dof - self.seen.sum(axis=1), 1), least)
        begin = np.cumsum((0, *self.widths[:-1]))
        mean = np.add.reduceat(solution**2, begin, axis=1) / self.seen
        return np.asarray(np.clip(np.sqrt(mean / variance[:, None]), TAUS[0], TAUS[-1]))

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

    def density_at(self, taus: FloatArray) -> FloatArray:
        """Log density (B,) with these sizes (B, blocks), V averaged."""
        a = self.gram.shape[1]
        d = np.repeat(taus, self.widths, axis=1)
        signal = d[:, a:] ** 2 * self.squared
        beside = np.concatenate(
            [self._across * d[:, :a, None], self.product[:, None, a:]], axis=1)
        matrix = -(beside * (d[:, a:] ** 2 / (1 + signal))[:, None, :]) @ beside.swapaxes(1, 2)
        matrix[:, :a, :a] += self._inside * d[:, :a, None] * d[:, None, :a]
        matrix[:, a, :a] += self.product[:, :a] * d[:, :a]
        matrix[:, range(a), range(a)] += 1.0
        matrix[:, a, a] += self.chi2 * (1 + 1e-12) + 1.0
        pivots = np.einsum("baa->ba", np.linalg.cholesky(matrix))  # by the lower triangle
        log_det = 2 * np.log(pivots[:, :a]).sum(axis=1) + np.log1p(signal).sum(axis=1)
        stated, larger = self.noise.log_density(pivots[:, a] ** 2 - 1.0, log_det, self.chi2)
        return np.logaddexp(stated, larger)

    def screened(self) -> FloatArray:
        """Log density (B,), the average over each size by its width at the likeliest ones.

        A size of v columns is known to 1/√(2v) of itself (the Fisher information of a variance).
        """
        taus = self.likeliest_sizes()
        width = np.minimum(np.sqrt(np.pi / self.seen) / np.log(2), len(TAUS))
        prior = taus / (1.0 + (taus / CONSTANTS.typical_size) ** 2) / HALF_CAUCHY.sum()
        return np.asarray(self.density_at(taus) + np.log(prior * width).sum(axis=1))

    def averaged(self) -> FloatArray:
        """Log density (B,), every size averaged with the others at their likeliest."""
        taus = self.likeliest_sizes()
        density, average = np.zeros(len(taus)), np.zeros(len(taus))
        for k in range(len(self.widths)):
            grid = np.repeat(taus[None], len(TAUS), axis=0)
            grid[:, :, k] = TAUS[:, None]
            gain = self._on(grid)
            best = gain.argmax(axis=0)
            taus[:, k] = TAUS[best]
            density = gain[best, np.arange(len(best))]
            average += over_sizes(gain) - density
        return np.asarray(density + average)

    def _on(self, grid: FloatArray) -> FloatArray:
        """:meth:`density_at` for many sizes of each set (taus, B, blocks), (taus, B)."""
        n = len(grid)
        many = Sets(np.tile(self.gram, (n, 1, 1)), np.tile(self.squared, (n, 1)),
                    np.tile(self.product, (n, 1)), self.chi2, self.noise, self.widths,
                    np.tile(self.seen, (n, 1)))
        return many.density_at(grid.reshape(-1, grid.shape[2])).reshape(n, -1)


def width_for(seen: int) -> int:
    """The width to which a block of so many columns is filled up: few widths are few groups.

    >>> [width_for(seen) for seen in (1, 3, 5, 7, 33)]
    [3, 3, 6, 12, 48]
    """
    return 3 << max(-(-seen // 3) - 1, 0).bit_length()
