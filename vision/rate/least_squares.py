"""Least squares with outliers set aside and standard deviations that include correlation."""

from dataclasses import dataclass

import numpy as np

from vision.geometry import FloatArray
from vision.numbers import SD_PER_MAD, median
from vision.phase_track import BoolArray

ROUNDS = 8  #: rounds of the weights; numerical limit
SLOW_WAVES = 4  # over the rows: slower ones act on the slope
LEAST = 1e-12  #: variance of a row over that of all rows; numerical
RANK_TOLERANCE = 1e-9  # relative singular value of the scaled columns


# Limit for outliers.
OUTLIER = 5.0  #: robust sds. Derived: of 10⁵ Gaussian rows less than one lies beyond 4.5


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


def least_squares(
    x: FloatArray, y: FloatArray, usual: FloatArray | None = None,
    stray: BoolArray | None = None,
) -> LeastSquares:
    """Fit, setting aside rows beyond five robust standard deviations.

    Parameters
    ----------
    x : array, shape (n, k)
    y : array, shape (n,)
    usual : array, shape (k,), optional
        Sd of each parameter before the data, about zero; infinite if nothing is known of it.
    stray : array of bool, shape (n,), optional
        Rows that are set aside in any case.

    Raises
    ------
    numpy.linalg.LinAlgError
        The columns are linearly dependent, and nothing is known of their parameters.
    """
    rms = np.sqrt((x**2).mean(axis=0))
    scale = np.where(rms > 0, rms, 1.0)
    scaled = x / scale
    known = np.zeros(x.shape[1]) if usual is None else 1 / (usual * scale)
    possible = np.ones(len(y), bool) if stray is None else ~stray
    used = possible
    for _ in range(ROUNDS):
        prior = known * np.sqrt(LEAST * float(y.var()))
        for _ in range(1 + bool(known.any())):  # the noise is that of a fit that hardly knows them
            # What is known of a parameter before the data is one row more, as sure as the others.
            rows = np.concatenate([scaled[used], np.diag(prior)])
            beta, _, _, singular = np.linalg.lstsq(rows, np.append(y[used], np.zeros_like(prior)))
            if singular[-1] < RANK_TOLERANCE * singular[0]:
                raise np.linalg.LinAlgError("columns are linearly dependent")
            inverse = np.linalg.inv(rows.T @ rows)
            residual = y - scaled @ beta
            determined = len(prior) - float(prior**2 @ np.diag(inverse))
            noise = np.sqrt((residual[used] ** 2).sum() / max(used.sum() - determined, 1))
            time = correlation_time(residual[used])
            prior = known * max(noise * np.sqrt(time), np.sqrt(LEAST * float(y.var())))
        spread = SD_PER_MAD * float(median(np.abs(residual[used])))
        keep = possible & (np.abs(residual) <= OUTLIER * max(spread, 1e-12))
        if np.array_equal(keep, used):
            break
        used = keep
    cov = noise**2 * time * inverse / np.outer(scale, scale)
    return LeastSquares(beta / scale, cov, residual, used, float(noise), time)


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
