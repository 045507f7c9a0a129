"""Whether and how fast something turns about a proposed axis: rough rate in short windows.

No mark, no first guess, no memory of earlier frames: in each window the rate is the one at which
most of what varies adds up (``vision.plate.window_rate``).
"""

import math
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from vision.geometry import FloatArray, PlateView
from vision.plate.low_orders import Orders
from vision.plate.window_rate import WindowRate

WINDOW = 48  # frames
NEARNESS = (0.1, 0.2, 0.3)  # 1/D tried, D the distance of the camera in plate radii


@dataclass(frozen=True)
class RotationThresholds:
    """Where the axis is. Tuned on tests.bench.vision_scenes but where stated.

    Attributes
    ----------
    steep_rad : float
        Tilt from which the spindle is sought beside the middle of the rim's ellipse. Derived: at 8°
        from three radii away it is 5 % of the radius off.
    """

    steep_rad: float = math.radians(8)


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


class RotationSearch:
    """Finds the rough motion of the same frames about one axis after the other.

    Parameters
    ----------
    time_s : array, shape (f,)
    """

    def __init__(self, time_s: FloatArray) -> None:
        frames = len(time_s)
        window = min(WINDOW, frames)
        starts = np.linspace(0, frames - window, max(1, -(-frames // window))).astype(int)
        limit = np.pi / max(float(np.median(np.diff(time_s))), 1e-4)
        self._time_s = time_s
        self._parts = [slice(start, start + window) for start in starts]
        self._windows = [WindowRate(time_s[part], limit) for part in self._parts]
        self._middles_s = [float(time_s[part].mean()) for part in self._parts]

    def about(self, spectra: Orders, weight: NDArray[np.float32]) -> CoarseRotation:
        """Rough plate angles about an axis.

        Parameters
        ----------
        spectra : array of complex64, shape (orders, r, f)
            Angular orders 1 ... of every ring and frame, in luma steps.
        weight : array, shape (r,)
            Of the rings, no unit.
        """
        results = [window.best(spectra[:, :, part], weight)
                   for window, part in zip(self._windows, self._parts, strict=True)]
        rates, shares, energies = np.array(results).T
        rate_at = np.interp(self._time_s, self._middles_s, _without_strays(rates))
        step = 0.5 * (rate_at[1:] + rate_at[:-1]) * np.diff(self._time_s)
        return CoarseRotation(
            np.concatenate([[0.0], np.cumsum(step)]),
            float(np.median(shares)),
            float(np.median(energies)),
            self._parts[int(shares.argmax())],
        )

    def share(self, spectra: Orders, weight: NDArray[np.float32], part: slice) -> float:
        """The share of the energy that turns together in one of the windows, 0 to 1.

        Parameters
        ----------
        spectra : array of complex64, shape (orders, r, f)
            Of the frames of the window.
        weight : array, shape (r,)
        part : slice
            The ``clearest`` of a ``CoarseRotation``.
        """
        return self._windows[self._parts.index(part)].best(spectra, weight)[1]


class Spinning(Protocol):
    """Frames in which something may turn about an axis."""

    def rotation(self, view: PlateView) -> CoarseRotation:
        """Rough motion about the spindle of a view."""
        ...

    def share(self, view: PlateView, part: slice) -> float:
        """What turns together about it in one window, of what varies, 0 to 1."""
        ...


def seek_spindle(
    view: PlateView, frames: Spinning, certain: float
) -> tuple[PlateView, CoarseRotation]:
    """The view with the spindle where most turns together, and that rotation.

    From D radii away, at a tilt α, the spindle appears off the middle of the rim's ellipse by
    sin α / D radii of the plate, on the minor axis. About the middle a label may turn, a rim seen
    steeply does not. Not sought where the coherence is ``certain`` at once; the places tried are
    compared in the window that is clearest about the middle.
    """
    about_middle = frames.rotation(view)
    if about_middle.coherence > certain or view.tilt_rad < THRESHOLDS.steep_rad:
        return view, about_middle
    clearest = about_middle.clearest
    best, most = view, frames.share(view, clearest)
    squeezed = np.linalg.svd(view.jacobian_at_centre())[2][1]  # direction on the plate
    for side in (1, -1):
        for nearness in NEARNESS:
            u, v = side * nearness * np.sin(view.tilt_rad) * squeezed
            x, y = view.pixels(np.hypot(u, v), np.arctan2(v, u))
            other = view.about(float(x), float(y))
            share = frames.share(other, clearest)
            if share <= most:
                break
            best, most = other, share
    if best is view:
        return view, about_middle
    about_best = frames.rotation(best)
    better = about_best.coherence > about_middle.coherence
    return (best, about_best) if better else (view, about_middle)


def _without_strays(rate: FloatArray) -> FloatArray:
    """Each rate replaced by the median with its neighbours."""
    if len(rate) < 3:
        return rate
    padded = np.concatenate([rate[:1], rate, rate[-1:]])
    return np.asarray(np.median(np.stack([padded[:-2], padded[1:-1], padded[2:]]), axis=0))
