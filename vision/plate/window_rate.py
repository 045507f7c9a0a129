"""The rate at which the variation in a window of frames turns together.

A pattern turning at rate ω gives its k-th angular Fourier coefficient the phase -kωt. The energy
that adds up coherently for a trial rate, over all orders and rings,

    P(ω) = Σ_r w_r Σ_k |Σ_i F_i(r, k) exp(ikωt_i)|²,

is a share of the whole energy close to one at the true rate. Light that varies in place (flicker,
reflections, the blocks of a compressed clip) is a real amplitude times a pattern and has the same
power at ω and -ω; a turning pattern has it at one of them. So P(ω) - P(-ω) is used.

All trial rates are multiples of one step, and the times are placed on an even grid, with gaps for
missing frames. The rings enter only through their products of two frames: the sum over all pairs
that are l steps apart is a covariance C_k(l), and one Fourier transform over l gives

    P(ω) - P(-ω) = 2 Re Σ_k Σ_l i Im C_k(l) exp(ikωl)

for every trial rate. Two equal marks have even orders alone, and turn as well by half a turn more
per frame; of rates that noise alone separates the smallest is taken.
"""


import numpy as np
from numpy.typing import NDArray

from vision.geometry import FloatArray
from vision.numbers import median
from vision.plate.low_orders import ORDERS, Orders

#: Largest distance of a stamp from an even grid, frame times. Derived: at the eighth order and
#: 0.5 rad per frame its phase errs by 0.2 rad, which costs 2 % of the power.
EVEN = 0.05
FINER = 4  #: slots per frame of the grid for stamps farther from it
SLOTS = 16  #: the length of the grid is a multiple of it, for the transform


# Limit for rotation in a window. Tuned on tests.bench.vision_scenes.
LEAST_SHOWN = 0.5  #: least share of the energy that shows a direction, however slow the plate
AS_HIGH = 0.98
"""Power of a peak over the largest, from which noise alone separates them. A judgement: a single
mark has half of its power in odd orders, two equal ones have next to nothing."""


class WindowRate:
    """Search for the best rate of a window of frames, about several axes in turn.

    Parameters
    ----------
    time_s : array, shape (f,)
    limit_rad_s : float
        The highest trial rate.
    """

    def __init__(self, time_s: FloatArray, limit_rad_s: float) -> None:
        slot, step_s = _slots(time_s)
        # Half a cycle of the highest order across the window between trial rates.
        self._length = 2 * ORDERS * SLOTS * -(-int(slot[-1] + 1) // SLOTS)
        between = 2 * np.pi / (self._length * step_s)
        trial = np.arange(-int(limit_rad_s / between), int(limit_rad_s / between) + 1)
        order = np.arange(1, ORDERS + 1)
        self._time_s = time_s - time_s.mean()
        self._trial_rad_s = np.asarray(trial * between, float)
        each = self._length * (order - 1)[:, None]
        self._at_trial = np.outer(order, trial) % self._length + each
        self._apart = (np.subtract.outer(slot, slot) % self._length + each[:, None]).ravel()

    def best(self, spectra: Orders, weight: NDArray[np.float32]) -> tuple[float, float]:
        """The best rate, rad/s, and the share of the varying energy that turns at it.

        Parameters
        ----------
        spectra : array of complex64, shape (orders, r, f)
            In luma steps.
        weight : array, shape (r,)
            Weights of the rings, no unit.
        """
        varying = spectra - spectra.mean(axis=-1, keepdims=True)
        varying *= np.sqrt(weight)[:, None]
        power = self._one_way_power(varying)
        best = self._slowest_of_the_best(power)
        rate = float(self._trial_rad_s[best])
        if 0 < best < len(power) - 1:
            low, at, high = power[best - 1 : best + 2]
            step = float(self._trial_rad_s[1] - self._trial_rad_s[0])
            if low + high < 2 * at:  # frames that are all alike have no power at any rate
                rate += 0.5 * float((low - high) / (low - 2 * at + high)) * step
        energy = (np.abs(varying) ** 2).sum(axis=(1, 2))
        turning = float(energy @ _share_of_rotation(rate, self._time_s))
        if_all_turned = max(turning, LEAST_SHOWN * float(energy.sum()), 1e-9)
        return rate, float(power[best]) / len(self._time_s) / if_all_turned

    def _slowest_of_the_best(self, power: FloatArray) -> int:
        """The index of the slowest rate whose power is a maximum as high as any."""
        beside = np.pad(power, 1, constant_values=-np.inf)
        peaks = np.flatnonzero((power >= AS_HIGH * power.max())
                               & (power >= beside[:-2]) & (power >= beside[2:]))
        return int(peaks[np.abs(self._trial_rad_s[peaks]).argmin()])

    def _one_way_power(self, varying: Orders) -> FloatArray:
        """P(ω) - P(-ω) at the trial rates."""
        half = varying.imag.swapaxes(1, 2) @ varying.real  # (orders, f, f)
        imaginary = half - half.swapaxes(1, 2)  # part of the products of every two frames
        covariance = np.bincount(self._apart, imaginary.ravel(), ORDERS * self._length)
        transform = np.fft.fft(covariance.reshape(ORDERS, -1), axis=-1).imag
        return np.asarray(2 * transform.ravel()[self._at_trial].sum(axis=0))


def _slots(time_s: FloatArray) -> tuple[NDArray[np.intp], float]:
    """Slots of times on an even grid that begins with the first, and its step, s."""
    frame_s = max(float(median(np.diff(time_s))), 1e-4)
    for step_s in (frame_s, frame_s / FINER):
        place = (time_s - time_s[0]) / step_s
        slot = np.round(place).astype(np.intp)
        if np.abs(place - slot).max() < EVEN:
            break
    return slot, step_s


def _share_of_rotation(rate: float, time_s: FloatArray) -> FloatArray:
    """(P(ω) - P(-ω)) / (f Σ|F|²) of a pure rotation, for each order.

    One, except for a plate so slow that a window shows only a part of a turn: part of its wave is
    removed with the mean, and part turns backwards as well.
    """
    turn = np.exp(1j * rate * np.outer(np.arange(1, ORDERS + 1), time_s))
    mean, of_twice = turn.mean(axis=1), (turn**2).mean(axis=1)
    after_mean = np.maximum(1 - np.abs(mean) ** 2, 1e-9)
    return np.asarray(after_mean - np.abs(of_twice - mean**2) ** 2 / after_mean)
