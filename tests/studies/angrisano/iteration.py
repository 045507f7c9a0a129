"""The iteration of Angrisano et al. to the letter, for the study that reproduces their tables.

Equation (11) without weights, q the residual form of the *linear* system, ``v = H dX - l``, ``q =
vᵀv``, and the stop rule as printed. The product's own solver ``paper``
(:mod:`calib.fit.least_squares.angrisano`) differs in what had to be mended: it weights, and judges
the misclosure itself.
"""

from dataclasses import dataclass

import numpy as np

from calib.fit.least_squares.angrisano import corrected_vectors, jacobian
from calib.poses.imu_log import FloatArray
from tests.studies.angrisano.published import STOP_RULE

MOST_ITERATIONS = 50


@dataclass(frozen=True, eq=False)
class Iterations:
    """X after every iteration, start first, (i + 1, 9); q (i,) and rms of |N| - s (i + 1,)."""

    x: FloatArray
    q: FloatArray
    rms: FloatArray
    stopped: bool

    @property
    def count(self) -> int:
        """Number of iterations."""
        return len(self.q)


def rms_misclosure(x: FloatArray, counts: FloatArray, magnitude: float) -> float:
    """Root mean square of ``|N| - s`` at X, SI."""
    size = np.linalg.norm(corrected_vectors(x, counts), axis=1)
    return float(np.sqrt(np.mean((size - magnitude) ** 2)))


def iterate_as_printed(
    start: FloatArray,
    counts: FloatArray,
    magnitude: float,
    *,
    absolute: bool = False,
    printed_sign: bool = False,
    most: int = MOST_ITERATIONS,
) -> Iterations:
    """Equations (4) to (11) from ``start`` (9,).

    Parameters
    ----------
    start : array, shape (9,)
        X_s of eq. (12) or another.
    counts : array, shape (n, 3)
        Mean readings of the poses.
    magnitude : float
        s, SI.
    absolute : bool
        Take ``|q_{i-1} - q_i| / q_i`` in the stop rule, which the paper prints without the bars.
    printed_sign : bool
        Take eq. (6) as printed, with -k_x for b_x.
    most : int
        Iterations after which it is given up; it is, too, once it has left all bounds.
    """
    x = start
    all_x, all_rms = [x], [rms_misclosure(x, counts, magnitude)]
    all_q: list[float] = []
    stopped = False
    while len(all_q) < most:
        n = corrected_vectors(x, counts)  # eq. (5)
        a = jacobian(x, counts)
        a[:, 0, 3] *= -1 if printed_sign else 1  # the entry of b_x in eq. (6)
        h = np.einsum("ni,nij->nj", n, a)  # rows NᵀA, eq. (10)
        right = ((n**2).sum(axis=1) - magnitude**2) / 2
        size = np.linalg.norm(h, axis=0)
        if not (np.isfinite(right).all() and np.isfinite(size).all() and (size > 0).all()):
            break
        step = np.linalg.lstsq(h / size, right, rcond=None)[0] / size  # eq. (11)
        v = h @ step - right
        x = x + step  # eq. (7)
        all_x.append(x)
        all_q.append(float(v @ v))
        all_rms.append(rms_misclosure(x, counts, magnitude))
        if len(all_q) > 1:
            change = (all_q[-2] - all_q[-1]) / all_q[-1]
            if (abs(change) if absolute else change) <= STOP_RULE:
                stopped = True
                break
    return Iterations(np.array(all_x), np.array(all_q), np.array(all_rms), stopped)
