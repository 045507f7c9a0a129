"""Least squares with outliers set aside and standard deviations that include correlation."""

from dataclasses import dataclass

import numpy as np

from vision.geometry import FloatArray
from vision.numbers import SD_PER_MAD, median
from vision.phase_track import BoolArray

ROUNDS = 8  #: rounds of the weights; numerical limit
SLOW_WAVES = 4  # over the rows: slower ones act on the slope
RANK_TOLERANCE = 1e-9  # relative singular value of the scaled columns


@dataclass(frozen=True)
class FitThresholds:
    """Limits for outliers and dependent columns.

    Attributes
    ----------
    outlier : float
        Robust sds. Derived: of 10⁵ Gaussian rows less than one lies beyond 4.5.
    clear_span : float
        Relative singular value below which two columns count as one. Tuned on
        ``tests.bench.vision_films mixed`` (fast plates with few frames per turn).
    """

    outlier: float = 5.0
    clear_span: float = 0.03


THRESHOLDS = FitThresholds()


@dataclass(frozen=True, eq=False)
class LeastSquares:
    """A fit y ≈ X β.

    Attributes
    ----------
    beta : array, shape (k,)
    cov : array, shape (k, k)
        Scaled by the correlation time of the residual.
    residual : array, shape (n,)
        Residual of all rows, including outliers.
    used : array of bool, shape (n,)
    noise : float
        Standard deviation of the used residuals.
    correlation_time : float
        Number of successive residuals with the information of one; 1 for white noise.
    """

    beta: FloatArray
    cov: FloatArray
    residual: FloatArray
    used: BoolArray
    noise: float
    correlation_time: float

    @property
    def sd(self) -> FloatArray:
        """Standard deviations of β, (k,), in its units."""
        return np.sqrt(np.diag(self.cov))


def least_squares(x: FloatArray, y: FloatArray) -> LeastSquares:
    """Fit, setting aside rows beyond five robust standard deviations.

    Parameters
    ----------
    x : array, shape (n, k)
    y : array, shape (n,)

    Raises
    ------
    numpy.linalg.LinAlgError
        The columns are linearly dependent.
    """
    scaled, scale = columns_of_unit_rms(x)
    used = np.ones(len(y), bool)
    for _ in range(ROUNDS):
        beta, _, _, singular = np.linalg.lstsq(scaled[used], y[used])
        if singular[-1] < RANK_TOLERANCE * singular[0]:
            raise np.linalg.LinAlgError("columns are linearly dependent")
        residual = y - scaled @ beta
        spread = SD_PER_MAD * float(median(np.abs(residual[used])))
        keep = np.abs(residual) <= THRESHOLDS.outlier * max(spread, 1e-12)
        if np.array_equal(keep, used):
            break
        used = keep
    freedom = max(int(used.sum()) - x.shape[1], 1)
    noise = float(np.sqrt((residual[used] ** 2).sum() / freedom))
    time = correlation_time(residual[used])
    inverse = np.linalg.inv(scaled[used].T @ scaled[used])
    cov = noise**2 * time * inverse / np.outer(scale, scale)
    return LeastSquares(beta / scale, cov, residual, used, noise, time)


def columns_of_unit_rms(x: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Columns (n, k) of any unit over their root mean squares, and these (k,), 1 for a zero
    column.
    """
    rms = np.sqrt((x**2).mean(axis=0))
    scale = np.where(rms > 0, rms, 1.0)
    return np.asarray(x / scale), np.asarray(scale)


def independent(x: FloatArray) -> FloatArray:
    """An orthonormal basis of the clear span of the columns, shape (n, rank)."""
    scaled, _ = columns_of_unit_rms(x)
    # From the small normal matrix: a singular value decomposition of all rows costs far more.
    squared, axes = np.linalg.eigh(scaled.T @ scaled)
    clear = squared > THRESHOLDS.clear_span**2 * squared[-1]
    return np.asarray(scaled @ axes[:, clear] / np.sqrt(squared[clear]))


def correlation_time(residual: FloatArray) -> float:
    """Number of successive residuals with the information of one; at least 1.

    The larger of two estimates: 1 + 2 Σ ρ_k, summed over pairs of lags while the pairs are
    positive (Geyer, Practical Markov chain Monte Carlo, 1992), for short correlations; and the
    power of the slowest waves over the mean power, for wandering over seconds: a clip is encoded in
    groups of some hundred frames, and each group has a small common error.
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
    waves = np.arange(1, min(SLOW_WAVES, (n - 1) // 2) + 1)
    # The fitted line removed its share of them: its own k-th wave is 1/k, in sine only.
    rest = len(waves) - 0.5 * 6 / np.pi**2 * float((1.0 / waves**2).sum())
    slow = float(spectrum[2 * waves].sum()) / rest / covariance[0] if len(waves) else 1.0
    return max(1.0, short, slow)
