"""A pattern that repeats around the plate: strobe dots, the ribs of a mat.

Turned by one of its N equal parts the plate looks the same, and the low angular orders, which
``vision.plate.rotation`` sums, show nothing. But the same number of parts passes every place per
second, f = N ω / 2π: a line in the spectrum over time,

    D(r, φ, t) = Re X(r, φ) exp(2πift) + …,        arg X = ∓N φ_plate + const.

Along a ring about the spindle the phase of X winds N times, from any viewpoint of the camera; its
direction is the sense of rotation. It is N times the azimuth on the plate, so its difference from
N times the azimuth of the ring shows the error of the view,

    φ_plate - φ = (u sin φ - v cos φ) / r + s sin 2φ - h cos 2φ,

shift (u, v), stretch s and shear h as in ``PlateView.adjusted``. The frames show the angle up to
multiples of 2π/N, and the rate up to multiples of 2π/N per frame: the smallest is taken here.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from vision.geometry import VIEW_PARAMETERS, FloatArray, PlateView
from vision.numbers import median
from vision.plate.evidence import believed
from vision.plate.low_orders import ORDERS
from vision.plate.polar import Grid, Strips
from vision.plate.rotation import CoarseRotation

ROUNDS = 6  #: rounds of the view at most; numerical
SETTLED = 0.1  # of a part: smaller changes of the view are not made
THINNED = 64  # azimuths at least, at which the line is searched
#: Frames in which a line is searched at first. Derived: a lasting line has the same share in some
#: of the frames as in all, and noise a tenth of the share of a line.
GLIMPSE = 64
FIRST_LOOK = 256  # azimuths for the test whether there are parts at all
FEWEST_PARTS = ORDERS + 1  # fewer parts show in the orders that are summed for any plate
LARGEST_STEP = 0.1  # of the radius, largest change of the view per round


@dataclass(frozen=True, eq=False)
class EqualParts:
    """A plate of equal parts.

    Attributes
    ----------
    view : PlateView
    rotation : CoarseRotation
        At the smallest of its possible rates.
    count : int
        N.
    """

    view: PlateView
    rotation: CoarseRotation
    count: int


@dataclass(frozen=True, eq=False)
class _Line:
    """Variation at one frequency: X, shape (r, n), and its share of all variation."""

    hertz: float
    wave: NDArray[np.complex64]
    share: float


def equal_parts(
    view: PlateView, sample: Callable[[PlateView, int, slice], tuple[Grid, Strips]],
    azimuths: int, time_s: FloatArray,
) -> EqualParts | None:
    """The parts that pass around the spindle of a view, and the view determined from them.

    Parameters
    ----------
    view : PlateView
    sample : callable
        Samples frames less the background along rings of a view at n azimuths: the grid, and an
        array of shape (f, r, n).
    azimuths : int
        Enough to resolve every part.
    time_s : array, shape (f,)
    """
    first = max(0, len(time_s) - GLIMPSE) // 2
    glimpse = slice(first, first + GLIMPSE)
    grid, strips = sample(view, THINNED, glimpse)
    line = _strongest_line(strips - strips.mean(axis=0), grid.weight(), time_s[glimpse])
    if not believed(line.share, len(strips), parameters=2):
        return None
    for looked_at in (FIRST_LOOK, *[azimuths] * ROUNDS):
        grid, strips = sample(view, looked_at, slice(None))
        varying = strips - strips.mean(axis=0)
        line = _strongest_line(varying, grid.weight(), time_s)
        count = round(_steps_around(line, grid.weight()).sum() / (2 * np.pi))
        if not believed(line.share, GLIMPSE, parameters=2) or abs(count) < FEWEST_PARTS:
            return None
        if looked_at == FIRST_LOOK:
            continue
        change = _view_change(line, grid, count)
        if np.abs(change).max() < SETTLED / abs(count):
            break
        view = view.adjusted(change)
    if not believed(line.share * _in_step(line, grid, count), GLIMPSE, parameters=2):
        return None
    return EqualParts(view, _rotation(varying, grid.weight(), time_s, line, count), abs(count))


def _strongest_line(varying: Strips, weight: NDArray[np.float32], time_s: FloatArray) -> _Line:
    f, r, n = varying.shape
    span_s, frame_s = float(np.ptp(time_s)), float(median(np.diff(time_s)))
    trial = np.arange(1, int(span_s / frame_s) + 1) / (2 * span_s)
    thin = varying[:, :, :: n // THINNED] * np.sqrt(weight)[:, None]
    wave = _at(trial, time_s)
    along = np.concatenate([wave.real, wave.imag]) @ thin.reshape(f, -1)
    power = np.einsum("ij,ij->i", along, along).reshape(2, -1).sum(axis=0)
    best = int(power.argmax())
    wave = (_at(trial[best : best + 1], time_s) @ varying.reshape(f, -1)).reshape(r, n)
    share = 2 * float(power[best]) / f / max(float((thin**2).sum()), 1e-9)
    return _Line(float(trial[best]), wave, share)


def _at(hertz: FloatArray, time_s: FloatArray) -> NDArray[np.complex64]:
    return np.asarray(np.exp(-2j * np.pi * np.outer(hertz, time_s)), np.complex64)


def _steps_around(line: _Line, weight: NDArray[np.float32]) -> FloatArray:
    """Change of the phase between azimuths, rad, shape (n,); stronger rings have more weight."""
    following = np.roll(line.wave, -1, axis=1) * np.conj(line.wave)
    return np.asarray(np.angle(weight @ following), float)


def _rotation(
    varying: Strips, weight: NDArray[np.float32], time_s: FloatArray, line: _Line, count: int
) -> CoarseRotation:
    seen = np.einsum("frn,rn,r->f", varying, np.conj(line.wave), weight)
    phase = 2 * np.pi * line.hertz * time_s
    phase += np.unwrap(np.angle(seen * np.exp(-1j * phase)))
    angle = -(phase - phase[0]) / count
    return CoarseRotation(angle, line.share, slice(0, len(varying)))


def _view_change(line: _Line, grid: Grid, count: int) -> FloatArray:
    """The shift, stretch and shear of the module's equation by weighted least squares."""
    azimuth = np.arange(grid.azimuths) * 2 * np.pi / grid.azimuths
    step = _steps_around(line, grid.weight()) / count - azimuth[1]
    beyond = np.concatenate([[0.0], np.cumsum(step)[:-1]])
    power = np.abs(line.wave) ** 2 * grid.weight()[:, None]
    strength = power.sum(axis=0)
    radius = np.maximum((grid.radius @ power) / np.maximum(strength, 1e-12), grid.radius[0])
    x = np.stack([
        np.sin(azimuth) / radius, -np.cos(azimuth) / radius,
        np.sin(2 * azimuth), -np.cos(2 * azimuth), np.ones_like(azimuth)], axis=1)
    root = np.sqrt(strength)
    change = np.zeros(VIEW_PARAMETERS)
    change[:4] = np.linalg.lstsq(x * root[:, None], beyond * root)[0][:4]
    return np.asarray(change * min(1.0, LARGEST_STEP / max(float(np.abs(change).max()), 1e-12)))


def _in_step(line: _Line, grid: Grid, count: int) -> float:
    """Share of the line's energy that turns with the parts."""
    azimuth = np.arange(grid.azimuths) * 2 * np.pi / grid.azimuths
    together = np.abs(line.wave @ np.exp(-1j * count * azimuth)) ** 2 / grid.azimuths
    every = grid.weight() @ (np.abs(line.wave) ** 2).sum(axis=1)
    return float(grid.weight() @ together / every)
