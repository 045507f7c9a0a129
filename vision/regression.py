"""Least squares with outliers set aside and standard deviations that know about correlation."""

from dataclasses import dataclass

import numpy as np

from vision.geometry import FloatArray
from vision.phase_track import BoolArray

OUTLIER = 5.0  # robust standard deviations
ROUNDS = 8
CLEAR_SPAN = 0.03  # relative singular value; two columns this close are one
BATCHES = 16  # of the residual, for its slow part
RANK_TOLERANCE = 1e-9  # relative singular value of the scaled columns


@dataclass(frozen=True, eq=False)
class LeastSquares:
    """A fit y ≈ X β.

    Attributes
    ----------
    beta : array, shape (k,)
    cov : array, shape (k, k)
        Scaled by the correlation time of the residual.
    residual : array, shape (n,)
        Of all rows, outliers too.
    used : array of bool, shape (n,)
    noise : float
        Standard deviation of the used residuals.
    correlation_time : float
        How many successive residuals carry the information of one; 1 for white noise.
    """

    beta: FloatArray
    cov: FloatArray
    residual: FloatArray
    used: BoolArray
    noise: float
    correlation_time: float

    @property
    def sd(self) -> FloatArray:
        """Standard deviations of β."""
        return np.sqrt(np.diag(self.cov))


def least_squares(x: FloatArray, y: FloatArray) -> LeastSquares:
    """Fit, setting aside rows beyond five robust standard deviations.

    Raises
    ------
    numpy.linalg.LinAlgError
        The columns are linearly dependent.
    """
    scale = np.sqrt((x**2).mean(axis=0))
    scaled = x / np.where(scale > 0, scale, 1.0)
    used = np.ones(len(y), bool)
    for _ in range(ROUNDS):
        beta, _, _, singular = np.linalg.lstsq(scaled[used], y[used])
        if singular[-1] < RANK_TOLERANCE * singular[0]:
            raise np.linalg.LinAlgError("columns are linearly dependent")
        residual = y - scaled @ beta
        spread = 1.4826 * float(np.median(np.abs(residual[used])))
        keep = np.abs(residual) <= OUTLIER * max(spread, 1e-12)
        if np.array_equal(keep, used):
            break
        used = keep
    freedom = max(int(used.sum()) - x.shape[1], 1)
    noise = float(np.sqrt((residual[used] ** 2).sum() / freedom))
    time = correlation_time(residual[used])
    inverse = np.linalg.inv(scaled[used].T @ scaled[used])
    scale = np.where(scale > 0, scale, 1.0)
    cov = noise**2 * time * inverse / np.outer(scale, scale)
    return LeastSquares(beta / scale, cov, residual, used, noise, time)


def independent(x: FloatArray) -> FloatArray:
    """An orthonormal basis of what the columns clearly span, shape (n, rank)."""
    scale = np.sqrt((x**2).mean(axis=0))
    scaled = x / np.where(scale > 0, scale, 1.0)
    # The few columns' own matrix: a singular value decomposition of all rows costs far more.
    squared, axes = np.linalg.eigh(scaled.T @ scaled)
    clear = squared > CLEAR_SPAN**2 * squared[-1]
    return np.asarray(scaled @ axes[:, clear] / np.sqrt(squared[clear]))


def correlation_time(residual: FloatArray) -> float:
    """How many successive residuals carry the information of one; at least 1.

    The larger of two estimates: 1 + 2 Σ ρ_k, summed over pairs of lags while the pairs are
    positive (Geyer, Practical Markov chain Monte Carlo, 1992), which sees short memory; and the
    scatter of batch means against that of single residuals, which sees slow wandering.
    """
    n = len(residual)
    centred = residual - residual.mean()
    spectrum = np.abs(np.fft.rfft(centred, 2 * n)) ** 2
    covariance = np.fft.irfft(spectrum)[:n]
    if covariance[0] <= 0:
        return 1.0
    rho = covariance / covariance[0]
    pairs = rho[1 : n // 2 - 1 : 2] + rho[2 : n // 2 : 2]
    negative = np.flatnonzero(pairs < 0)
    stop = int(negative[0]) if negative.size else len(pairs)
    short = 1 + 2 * float(pairs[:stop].sum())
    length = max(1, n // BATCHES)
    means = centred[: length * (n // length)].reshape(-1, length).mean(axis=1)
    slow = float(means.var()) * length / float(covariance[0] / n)
    return max(1.0, short, slow)
