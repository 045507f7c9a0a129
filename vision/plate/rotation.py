"""Whether and how fast something turns about a proposed axis: rough rate in short windows.

A pattern turning at rate ω gives its k-th angular Fourier coefficient the phase -kωt. The energy
that adds up coherently for a trial rate, over all orders and rings,

    P(ω) = Σ_r w_r Σ_k |Σ_i F_i(r, k) exp(ikωt_i)|²,

is a share of the whole energy close to one at the true rate. What brightens and fades in place, as
flicker, reflections and the blocks of a compressed clip do, is a real amplitude times a pattern and
has the same power at ω and -ω; what turns has it at one of them. So P(ω) - P(-ω) is looked at. No
mark, no first guess, no memory of earlier frames.

All trial rates are multiples of one step, and the times are put onto an even grid, with gaps where
frames are missing: then one Fourier transform over time gives every |Σ_i F_i exp(ikωt_i)|².
"""

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from vision.geometry import FloatArray, PlateView

WINDOW = 48  # frames
#: Frame times that a stamp may lie off an even grid. Derived: at the eighth order and 0.5 rad per
#: frame its phase errs by 0.2 rad, which costs 2 % of the power.
EVEN = 0.05
FINER = 4  #: slots per frame of the grid for stamps that do
SLOTS = 16  #: the grid is as long as a multiple of it, for the sake of the transform
NEARNESS = (0.1, 0.2, 0.3)  # 1/D tried, D the distance of the camera in plate radii
COARSE_SAMPLES = 128  #: azimuths that the frames are sampled at for it
ORDERS = 8  # angular orders 1 ... that are added up


@dataclass(frozen=True)
class RotationThresholds:
    """When something turns about an axis. Tuned on tests.bench.vision_scenes but where stated.

    Attributes
    ----------
    calm : float
        Mean square change, luma steps squared, that is rounding of the transforms. Derived: single
        precision of 8 bits.
    least_shown : float
        Of the energy, that shows a direction however slow the plate.
    favour_slow : float
        Share of the power taken off the fastest trial rate, for a symmetric plate to have the
        slowest of its aliases.
    steep_rad : float
        Tilt from which the spindle is sought beside the middle of the rim's ellipse. Derived: at 8°
        from three radii away it is 5 % of the radius off.
    same_spindle : float
        Of the smaller radius: views closer than this in centre are of one plate.
    """

    calm: float = 1e-06
    least_shown: float = 0.5
    favour_slow: float = 0.1
    steep_rad: float = math.radians(8)
    same_spindle: float = 0.1


THRESHOLDS = RotationThresholds()


@dataclass(frozen=True, eq=False)
class CoarseRotation:
    """Rough motion about an axis.

    Attributes
    ----------
    angle_rad : array, shape (f,)
        Plate angle at each frame, zero at the first, continuous.
    coherence : float
        Share of the varying energy that turns together, what would as well turn the other way not
        counted; median over the windows, 0 to 1.
    varying : float
        Energy that varies, whether it turns or not: luma steps squared times the samples' weight.
    clearest : slice
        Frames of the window that turns together best. Between windows frames may be missing,
        and the angle with them.
    """

    angle_rad: FloatArray
    coherence: float
    varying: float
    clearest: slice


def coarse_rotation(
    spectra: NDArray[np.complex64], weight: NDArray[np.float32], time_s: FloatArray
) -> CoarseRotation:
    """Rough plate angles from angular spectra, shape (frames, rings, orders)."""
    frames = len(time_s)
    window = min(WINDOW, frames)
    starts = np.linspace(0, frames - window, max(1, -(-frames // window))).astype(int)
    limit = np.pi / max(float(np.median(np.diff(time_s))), 1e-4)
    rates, shares, energies, middles = [], [], [], []
    for start in starts:
        part = slice(start, start + window)
        rate, share, energy = _window_rate(spectra[part], weight, time_s[part], limit)
        rates.append(rate)
        shares.append(share)
        energies.append(energy)
        middles.append(float(time_s[part].mean()))
    rate_at = np.interp(time_s, middles, _without_strays(np.array(rates)))
    step = 0.5 * (rate_at[1:] + rate_at[:-1]) * np.diff(time_s)
    angle = np.concatenate([[0.0], np.cumsum(step)])
    clearest = int(starts[int(np.argmax(shares))])
    return CoarseRotation(
        angle,
        float(np.median(shares)),
        float(np.median(energies)),
        slice(clearest, clearest + window),
    )


def seek_spindle(
    view: PlateView, spin_about: Callable[[PlateView], CoarseRotation], certain: float
) -> tuple[PlateView, CoarseRotation]:
    """The view with the spindle where most turns together, and that spin.

    From D radii away, at a tilt α, the spindle appears off the middle of the rim's ellipse by
    sin α / D radii of the plate, on the minor axis. About the middle a label may turn, a rim seen
    steeply does not. Not sought where the coherence is ``certain`` at once.
    """
    best, rotation = view, spin_about(view)
    if rotation.coherence > certain or view.tilt_rad < THRESHOLDS.steep_rad:
        return best, rotation
    squeezed = np.linalg.svd(view.jacobian_at_centre())[2][1]  # direction on the plate
    for side in (1, -1):
        for nearness in NEARNESS:
            u, v = side * nearness * np.sin(view.tilt_rad) * squeezed
            x, y = view.pixels(np.hypot(u, v), np.arctan2(v, u))
            other = view.about(float(x), float(y))
            turning = spin_about(other)
            if turning.coherence <= rotation.coherence:
                break
            best, rotation = other, turning
    return best, rotation


def same_spindle(smaller: PlateView, larger: PlateView) -> bool:
    """A label turns with a larger share of what changes inside it than its plate does."""
    (x1, y1), (x2, y2) = smaller.centre_px, larger.centre_px
    return float(np.hypot(x1 - x2, y1 - y2)) < THRESHOLDS.same_spindle * smaller.radius_px


def _slots(time_s: FloatArray) -> tuple[NDArray[np.intp], float]:
    """Places of times on an even grid that begins with the first, and its step, s."""
    frame_s = max(float(np.median(np.diff(time_s))), 1e-4)
    for step_s in (frame_s, frame_s / FINER):
        place = (time_s - time_s[0]) / step_s
        slot = np.round(place).astype(np.intp)
        if np.abs(place - slot).max() < EVEN:
            break
    return slot, step_s


def _power(
    varying: NDArray[np.complex64], time_s: FloatArray, limit: float
) -> tuple[FloatArray, FloatArray]:
    """Trial rates from -limit to limit and P(ω) at each; coefficients (orders, rings, f)."""
    orders = len(varying)
    slot, step_s = _slots(time_s)
    # Half a cycle of the highest order across the window between trial rates.
    length = 2 * orders * SLOTS * -(-int(slot[-1] + 1) // SLOTS)
    on_grid = np.zeros((*varying.shape[:2], length), np.complex64)
    on_grid[:, :, slot] = varying
    # NumPy takes six times as long for the transform without the factor 1/n.
    parts = np.fft.ifft(on_grid, axis=-1).view(np.float32)  # real and imaginary side by side
    square = np.einsum("orp,orp->op", parts, parts)
    power = length**2 * (square[:, ::2] + square[:, 1::2])
    between = 2 * np.pi / (length * step_s)
    trial = np.arange(-int(limit / between), int(limit / between) + 1)
    place = np.outer(np.arange(1, orders + 1), trial) % length
    at_trial = np.take_along_axis(power, place, axis=1).sum(axis=0, dtype=float)
    return np.asarray(trial * between, float), np.asarray(at_trial)


def _without_strays(rate: FloatArray) -> FloatArray:
    """Each rate replaced by the median with its neighbours."""
    if len(rate) < 3:
        return rate
    padded = np.concatenate([rate[:1], rate, rate[-1:]])
    return np.asarray(np.median(np.stack([padded[:-2], padded[1:-1], padded[2:]]), axis=0))


def _window_rate(
    spectra: NDArray[np.complex64],
    weight: NDArray[np.float32],
    time_s: FloatArray,
    limit: float,
) -> tuple[float, float, float]:
    """Best rate, the share of the varying energy that turns with it, the varying energy."""
    orders = min(ORDERS, spectra.shape[-1] - 1)
    varying = spectra[:, :, 1 : orders + 1]
    varying = (varying - varying.mean(axis=0)) * np.sqrt(weight)[None, :, None]
    weighted = np.ascontiguousarray(varying.transpose(2, 1, 0))  # (orders, rings, f)
    time = time_s - time_s.mean()
    trial, power = _power(weighted, time, limit)
    power -= power[::-1]
    # A plate that looks the same twice per turn ties with its aliases; take the slowest always.
    best = int((power * (1 - THRESHOLDS.favour_slow * np.abs(trial) / limit)).argmax())
    rate = float(trial[best])
    if 0 < best < len(trial) - 1:
        low, at, high = power[best - 1 : best + 2]
        rate += 0.5 * float((low - high) / (low - 2 * at + high)) * float(trial[1] - trial[0])
    energy = (np.abs(weighted) ** 2).sum(axis=(1, 2))
    total = float(energy.sum())
    azimuths = 2 * (spectra.shape[-1] - 1)
    calm = THRESHOLDS.calm * azimuths**2 * len(time) * float(weight.sum()) / 2
    turning = float(energy @ _one_way(rate, time, orders))
    if_all_turned = max(turning, THRESHOLDS.least_shown * total, calm)
    return rate, float(power[best]) / len(time) / if_all_turned, total


def _one_way(rate: float, time_s: FloatArray, orders: int) -> FloatArray:
    """(P(ω) - P(-ω)) / (f Σ|F|²) of something that does nothing but turn, for each order.

    One, but for a plate so slow that a window sees only a part of a turn: a part of its wave is
    taken off with the mean, and a part turns backwards as well.
    """
    turn = np.exp(1j * rate * np.outer(np.arange(1, orders + 1), time_s))
    mean, of_twice = turn.mean(axis=1), (turn**2).mean(axis=1)
    after_mean = np.maximum(1 - np.abs(mean) ** 2, 1e-9)
    return np.asarray(after_mean - np.abs(of_twice - mean**2) ** 2 / after_mean)
