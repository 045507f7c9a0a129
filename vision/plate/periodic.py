"""Every pixel as a periodic function of one phase: no rim, no spindle, no view.

A plate seen from the side, from near by or in part shows in every pixel p a function of its angle
with the period of a turn,

    V_p(t) = f_p(θ_t) + noise,      f_p(θ) = a_p0 + Σ_k a_pk cos kθ + b_pk sin kθ,

for any lens, rim and light. The angles θ_t and the coefficients are estimated in turn: the
coefficients by least squares for given angles, each order shrunk to its share above the noise
(Wiener), and the angles by Newton's step θ → θ + Σ_p V' f'/Σ_p f'².

With N frames in a turn an order N - k looks like k, except for the advance of N θ against the
frames. A mark that is narrow against the angle between two frames has such orders; if every turn
shows the same angles, |⟨e^(iNθ)⟩| near 1, nothing separates them, and the angle is biased towards
N whole frames per turn. The drift of a plate in the clip is then known to a frame time, uniformly.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from vision.geometry import FloatArray
from vision.image_return import NOISE_FROM
from vision.numbers import SD_PER_MAD, median

FEW_ROUNDS, ROUNDS = 2, 4  #: rounds of angles and coefficients; numerical
VARYING, VARYING_FROM = 3, 50  # times the pixels wanted, by their variation in so many frames
THINNED = 1000  # pixels, for the refinement of the period
SHOWN = 0.05  # of the usual information on the angle: a frame with less shows none
FEWEST_EVEN = 1.5  # turns, from which waves in a turn are separated from the line
MISFIT = 3.0  # times the usual residual: something is in the way
PER_STEP = 0.42  #: orders per frame of a turn: half is the limit of sampling
MOST_ORDERS = 48  #: a limit of time
FEW_ORDERS = 8  #: orders for the refinement of the period; numerical
LONGEST_STEP = 0.3  #: rad, of one round; numerical
REACH = 3.0  #: sds of the period to both sides


@dataclass(frozen=True, eq=False)
class PeriodicPixels:
    """The angle of every frame.

    Attributes
    ----------
    angle_rad : array, shape (f,)
        Continuous, growing with time; a turn of the picture is 2π.
    match : array, shape (f,)
        Correlation of the frame with the expected values at that angle.
    smear_rad2 : array, shape (f,)
        Variance of the motion blur along the turn beyond the mean one, rad².
    leaning_frames : float
        Sd of the drift of the angle over the clip by orders that no frame separates, frame times.
    """

    angle_rad: FloatArray
    match: FloatArray
    smear_rad2: FloatArray
    leaning_frames: float


class PeriodicFit:
    """The fit of the pixels: a few orders in a few rounds at first, enough to see what turns.

    Parameters
    ----------
    values : array of uint8, shape (f, p)
        Values of the pixels.
    time_s : array, shape (f,)
    period_s, period_sd_s : float
        Approximate period of the picture.
    """

    def __init__(
        self, values: NDArray[np.uint8], time_s: FloatArray, period_s: float, period_sd_s: float
    ) -> None:
        self._time_s = time_s
        self._shown = values.astype(np.float32)
        light = self._shown.mean(axis=1, keepdims=True)
        self._shown *= light.mean() / np.maximum(light, 1.0)
        self._shown -= self._shown.mean(axis=0)
        self._frame_s = float(median(np.diff(time_s)))
        self._most = max(
            2, int(min(MOST_ORDERS, len(time_s) / 8, PER_STEP * period_s / self._frame_s)))
        self._few = min(FEW_ORDERS, self._most)
        self._angle = _exact_period(self._shown, time_s, period_s, period_sd_s, self._few)
        self._used = np.ones(len(time_s), bool)
        self._noise: NDArray[np.float32] = np.ones(self._shown.shape[1], np.float32)
        for _ in range(FEW_ROUNDS):
            fit = self._step(self._few)
        self.coefficients = fit.coefficients  #: mean, cosines and sines, (2k + 1, p)

    def _step(self, orders: int) -> "_HarmonicFit":
        fit = _HarmonicFit(self._shown, self._angle, orders, self._used, self._noise)
        self._angle = np.asarray(self._angle + fit.step)
        self._used, self._noise = fit.clear, fit.noise
        return fit

    def pixels(self) -> PeriodicPixels:
        """The angle in every frame, by all orders."""
        for _ in range(ROUNDS):
            fit = self._step(self._most)
        angle = _even(self._angle, self._time_s, self._used, self._few)
        per_turn = 2 * np.pi * np.ptp(self._time_s) / self._frame_s / np.ptp(angle)
        leaning = 0.0
        if self._most >= int(PER_STEP * per_turn):  # otherwise orders that look alike are far apart
            same = abs(complex(np.exp(1j * round(per_turn) * angle).mean()))
            leaning = same * float(np.sqrt(fit.highest_shown / 12))
        return PeriodicPixels(angle, fit.match, fit.smear, leaning)


def informative(
    values: NDArray[np.uint8], time_s: FloatArray, period_s: float, most: int
) -> NDArray[np.intp]:
    """The pixels with most information on the angle, at most ``most``, in order.

    Parameters
    ----------
    values : array of uint8, shape (f, p)
    time_s : array, shape (f,)
    period_s : float
    most : int
    """
    varying = values[:: len(values) // VARYING_FROM + 1].std(axis=0, dtype=np.float32)
    some = np.sort(np.argpartition(varying, -min(VARYING * most, len(varying)))[-VARYING * most :])
    values = values[:, some]
    waves = _waves(2 * np.pi * time_s / period_s, FEW_ORDERS)
    normal = waves.T @ waves
    together = waves.T @ values.astype(np.float32)
    free = np.linalg.solve(normal + 1e-3 * len(waves) * np.eye(len(normal)), together)
    squares = np.einsum("fp,fp->p", values, values, dtype=np.float32)
    rest = squares - ((2 * together - normal @ free) * free).sum(axis=0)
    noise = np.maximum(rest / len(waves), 1.0)
    k = np.concatenate([[0], *[np.arange(1, FEW_ORDERS + 1)] * 2])[:, None]
    beyond = np.maximum(free**2 - noise * np.diag(np.linalg.inv(normal))[:, None], 0)
    information = (k**2 * beyond).sum(axis=0) / noise
    return some[np.sort(np.argsort(information)[-most:])]


def _even(
    angle: FloatArray, time_s: FloatArray, used: NDArray[np.bool_], orders: int
) -> FloatArray:
    """The same angles on the scale on which the turns are uniform.

    Any function of the angle that grows by a turn per turn would fit equally well: these pixels
    cannot show the rate within a turn.
    """
    turns = float(np.ptp(angle)) / (2 * np.pi)
    if turns < FEWEST_EVEN:
        return angle
    x = np.column_stack([time_s - time_s.mean(), _waves(angle, orders)])
    beta = np.linalg.lstsq(x[used], angle[used])[0]
    return np.asarray(angle - x[:, 2:] @ beta[2:])


def _waves(angle: FloatArray, orders: int) -> NDArray[np.float32]:
    turned = np.outer(angle, np.arange(1, orders + 1))
    waves = [np.ones((len(angle), 1)), np.cos(turned), np.sin(turned)]
    return np.concatenate(waves, axis=1).astype(np.float32)


def _exact_period(
    shown: NDArray[np.float32], time_s: FloatArray, period_s: float, sd_s: float, orders: int
) -> FloatArray:
    """The angles of an even rotation, with the period at which the orders explain most."""
    turns = float(np.ptp(time_s)) / period_s
    step = 1 / (8 * turns * orders)
    reach = max(1, int(np.ceil(REACH * sd_s / period_s / step)))
    time = time_s - time_s[0]
    tried = period_s * (1 + step * np.arange(-reach, reach + 1))
    thin = shown[:, :: max(1, shown.shape[1] // THINNED)]
    explained = [
        float(((np.linalg.qr(_waves(2 * np.pi * time / period, orders))[0].T @ thin) ** 2).sum())
        for period in tried]
    return np.asarray(2 * np.pi * time / tried[int(np.argmax(explained))])


class _HarmonicFit:
    """The coefficients for given angles, and the deviation of the frames from them."""

    def __init__(
        self, shown: NDArray[np.float32], angle: FloatArray, orders: int,
        used: NDArray[np.bool_], noise: NDArray[np.float32],
    ) -> None:
        waves = _waves(angle, orders)
        k = np.concatenate([[0], *[np.arange(1, orders + 1)] * 2]).astype(np.float32)[:, None]
        rows = waves[used]
        count = len(rows)
        normal = rows.T @ rows + 1e-3 * count / 2 * np.eye(len(k), dtype=np.float32)
        free = np.linalg.solve(normal, rows.T @ shown[used])
        # Power of each order over the noise of its coefficients, for all pixels together.
        power = ((free / noise) ** 2).mean(axis=1)
        power[1:] = np.tile(power[1 : orders + 1] + power[orders + 1 :], 2) / 2
        floor = np.diag(np.linalg.inv(normal))
        kept = np.maximum(1 - floor / np.maximum(power, 1e-12), 0)
        kept[0] = 1
        self.highest_shown = float(kept[orders])  # share of its power that is not noise
        self.coefficients = np.asarray(free * kept[:, None], np.float32)
        swapped = np.concatenate([np.zeros_like(free[:1]), self.coefficients[orders + 1 :],
                                  -self.coefficients[1 : orders + 1]])
        at = waves @ self.coefficients
        rest = shown - at
        some = np.abs(rest[:: max(1, len(rest) // NOISE_FROM)])
        self.noise = np.asarray(SD_PER_MAD * median(some, axis=0) + 1, np.float32)
        weight = 1 / self.noise**2
        slope = waves @ (k * swapped)
        information = slope**2 @ weight
        pull = (rest * slope) @ weight / np.maximum(information, 1e-12)
        self.step = np.clip(pull, -LONGEST_STEP, LONGEST_STEP).astype(float)
        misfit = np.abs(rest) @ np.sqrt(weight)
        self.clear = (information >= SHOWN * median(information)) & (
            misfit <= MISFIT * median(misfit))
        bend = -waves @ (k**2 * self.coefficients)
        a, d, b = at**2 @ weight, bend**2 @ weight, (at * bend) @ weight
        one, two = (shown * at) @ weight, (shown * bend) @ weight
        self.match = one / np.sqrt(np.maximum(a * (shown**2 @ weight), 1e-12))
        contrast = one * d - two * b
        self.smear = np.where(contrast > 0, 2 * (two * a - one * b) / np.where(
            contrast > 0, contrast, 1), np.nan)
