"""Plate angle of successive frames, against the template.

With D the frame along the rings less the background, the angle is the zero of

    g(θ) = Σ w ∂T/∂φ(φ - θ) (D(φ) - T(φ - θ)),

the matched filter, which for white frame noise of standard deviation σ reaches the bound
σ²/Σ w (∂T/∂φ)². The template is held at an eighth of a sample, so that the last step, taken
linearly, is below 0.03° and does not lock to the samples. If the expected angle does not lead to
a good match, the whole turn is searched by correlation.

If a part of the plate is outside the frame or covered, Σ runs over the rest. At angles at which the
mark is not in that rest, hardly anything depends on θ: the frame shows that the mark is invisible,
but no angle.

A longer exposure blurs the plate along the rings. A blur whose variance is larger by s changes T
into T + s/2 ∂²T/∂φ², and s is fitted together with the contrast at that angle.
"""

from collections.abc import Sequence
from dataclasses import dataclass, fields

import cv2
import numpy as np
from numpy.typing import NDArray

from vision.geometry import FloatArray
from vision.plate.polar import Strips, ring_spectra
from vision.plate.template import Template
from vision.video.reader import Luma

SUBSTEPS = 8  # of a sample of azimuth
LINEAR = 0.75 / SUBSTEPS  # of a sample: smaller steps are taken without another evaluation
STEPS = 4  # of Newton's method
SOFT_PX = 3.0  # at the rim: the blur is measured on longer waves


# Limits of the tracker's expectation. Tuned on tests.bench.vision_films.
GOOD_MATCH = 0.75  #: share of the usual correlation below which the whole turn is searched
HIDDEN_MATCH = 0.5
"""Share of the usual correlation below which something is in the way; the expectation is kept."""
SHOWN = 0.25
"""Share of the largest information on the angle, Σ w (∂T/∂φ)² over the visible part, below which a
frame shows no angle. Derived: from a quarter on its sd is at most twice the least."""
MEMORY = 0.05  #: weight of the newest frame in the running rate and the usual correlation


@dataclass(frozen=True, eq=False)
class MeasuredAngles:
    """Measurements of the plate in some frames, each array of shape (f,).

    Attributes
    ----------
    angle_rad : array
        Continuous by the expected angle; NaN if the frame shows none.
    match : array
        Correlation with the template at that angle.
    change : array
        Mean change of luma since the previous frame; infinite for the very first.
    smear_rad2 : array
        Variance of the blur along the rings beyond that of the template, rad²; NaN if the frame
        does not show the plate.
    """

    angle_rad: FloatArray
    match: FloatArray
    change: FloatArray
    smear_rad2: FloatArray

    @classmethod
    def joined(cls, parts: Sequence["MeasuredAngles"]) -> "MeasuredAngles":
        """The frames of all parts, in order."""
        return cls(*(
            np.concatenate([getattr(part, field.name) for part in parts]) for field in fields(cls)
        ))


class PlateTracker:
    """Tracker of successive frames, in order, with the expected rate and match for the next.

    Parameters
    ----------
    template : Template
    rate_rad_s : float
        Rough initial rate.
    """

    def __init__(self, template: Template, rate_rad_s: float) -> None:
        self.template = template
        self._rate = rate_rad_s
        grid = template.grid
        self._n = grid.azimuths
        self._weight = grid.weight()
        weight = self._weight[:, None]
        spectrum = np.fft.rfft(template.turning, axis=1)
        k = np.arange(spectrum.shape[1])
        shifts = np.exp(-2j * np.pi * k * np.arange(SUBSTEPS)[:, None] / (SUBSTEPS * self._n))
        shifted = spectrum[None] * shifts[:, None, :].astype(np.complex64)
        image = np.fft.irfft(shifted, self._n, axis=-1)
        along = (1j * k).astype(np.complex64)  # ∂/∂φ of the order k
        slope = np.fft.irfft(along * shifted, self._n, axis=-1)
        self._image = np.concatenate([image, image], axis=-1)
        self._filter = np.concatenate([weight * slope] * 2, axis=-1)
        self._seen = grid.seen
        self._partly = not bool(self._seen.all())
        self._background = template.background
        self._difference = np.empty_like(template.background)
        self._search = (weight * np.conj(spectrum)).astype(np.complex64)
        # For rings partly hidden or outside the frame: sums over the template itself, by angle.
        self._information = _by_angle(weight * slope**2, self._seen)
        self._shows = self._information >= SHOWN * self._information.max()
        self._offset = _by_angle(weight * slope * image, self._seen)
        self._energy = _by_angle(weight * image**2, self._seen)
        # The blur is fitted at whole samples, parts of one hardly change it; and on waves above the
        # noise of the template, or ∂²T/∂φ² would be that noise.
        soft = np.exp(-((k * SOFT_PX / grid.view.radius_px) ** 2) / 2)
        even, bend = np.fft.irfft(np.stack([soft, -soft * k**2])[:, None] * spectrum, self._n)
        self._smear_filter = np.stack([np.concatenate([weight * part] * 2, axis=-1)
                                       for part in (even, bend)]).astype(np.float32)
        pairs = np.stack([weight * one * other for one in (even, bend)
                          for other in (image[0], np.fft.irfft(-(k**2) * spectrum, self._n))])
        self._smear_normal = _by_angle(pairs, self._seen).reshape(2, 2, self._n)
        self._time: float | None = None
        self._angle = 0.0
        self._usual = 0.0
        self._before: Luma | None = None

    def angles(self, time_s: FloatArray, strips: Sequence[Luma]) -> MeasuredAngles:
        """The plate angle in the next frames.

        Parameters
        ----------
        time_s : array, shape (f,)
        strips : sequence of arrays of uint8, shape (r, n)
            The frames along the template's rings.
        """
        f = len(time_s)
        angle, match, change, smear = np.empty((4, f))
        for i, strip in enumerate(strips):
            before, self._before = self._before, strip
            change[i] = np.inf if before is None else cv2.norm(strip, before, cv2.NORM_L1)
            difference = self._less_background(strip)
            angle[i], match[i] = self._angle_of(difference, float(time_s[i]))
            smear[i] = self._smear(difference, angle[i]) if np.isfinite(angle[i]) else np.nan
        return MeasuredAngles(angle, match, change / self._seen.size, smear)

    def _less_background(self, strip: Luma) -> NDArray[np.float32]:
        cv2.subtract(strip, self._background, dst=self._difference, dtype=cv2.CV_32F)
        if self._partly:
            self._difference *= self._seen
        return self._difference

    def _angle_of(self, difference: NDArray[np.float32], time_s: float) -> tuple[float, float]:
        """Angle of one frame, NaN if it shows none, and its correlation with the template."""
        expected = self._angle
        if self._time is not None:
            expected += self._rate * (time_s - self._time)
        energy = np.vecdot(difference, difference) @ self._weight
        size = float(np.sqrt(energy))
        angle, match, settled = self._refine(difference, expected, size)
        if self._time is None or not settled or match < GOOD_MATCH * self._usual:
            start = self._whole_turn(difference, expected)
            other_angle, other_match, _ = self._refine(difference, start, size)
            if other_match > match:
                angle, match = other_angle, other_match
        fine = round(angle * self._n * SUBSTEPS / (2 * np.pi))
        whole, part = divmod(fine, SUBSTEPS)
        if not self._shows[part, whole % self._n]:
            return np.nan, match
        self._remember(time_s, angle, match)
        return angle, match

    def _remember(self, time_s: float, angle: float, match: float) -> None:
        if self._time is None:
            self._time, self._angle, self._usual = time_s, angle, match
            return
        if match < HIDDEN_MATCH * self._usual:
            # Something is in the way: keep the expectation.
            self._usual += MEMORY * (match - self._usual)
            return
        elapsed = time_s - self._time
        surprise = angle - self._angle - self._rate * elapsed
        if elapsed > 0:
            self._rate += 2 * MEMORY * surprise / elapsed
        self._time, self._angle = time_s, angle
        self._usual += MEMORY * (match - self._usual)

    def _refine(
        self, difference: NDArray[np.float32], start_rad: float, size: float
    ) -> tuple[float, float, bool]:
        """Newton's zero of g(θ) from a start; its angle, correlation, and whether it converged.

        The sharper a mark is, the nearer to it Newton's method must begin.
        """
        sample = 2 * np.pi / self._n
        angle = start_rad
        settled = False
        for _ in range(STEPS):
            fine = round(angle / sample * SUBSTEPS)
            whole, part = divmod(fine, SUBSTEPS)
            turn = whole % self._n
            column = slice(self._n - turn, 2 * self._n - turn)
            held = fine * sample / SUBSTEPS
            pull = np.vecdot(self._filter[part][:, column], difference).sum()
            # T(φ - θ) falls by ∂T/∂φ as θ grows.
            step = -float(pull - self._offset[part, turn]) / float(self._information[part, turn])
            angle = held + step
            if settled := abs(step) < LINEAR * sample:
                break
        like = np.vecdot(self._image[part][:, column], difference) @ self._weight
        match = float(like) / max(size * float(np.sqrt(self._energy[part, turn])), 1e-9)
        return angle, match, settled

    def _smear(self, difference: NDArray[np.float32], angle_rad: float) -> float:
        """s of D ≈ c (T + s/2 ∂²T/∂φ²) at an angle, contrast c and s by least squares."""
        turn = round(angle_rad * self._n / (2 * np.pi)) % self._n
        column = slice(self._n - turn, 2 * self._n - turn)
        shown = np.vecdot(self._smear_filter[:, :, column], difference).sum(axis=1)
        (a, b), (c, d) = self._smear_normal[:, :, turn]
        contrast = shown[0] * d - shown[1] * b
        return float(2 * (shown[1] * a - shown[0] * c) / contrast) if contrast > 0 else np.nan

    def _whole_turn(self, difference: NDArray[np.float32], expected_rad: float) -> float:
        """The best angle of the whole turn, next to the expected one."""
        cross = (ring_spectra(difference) * self._search).sum(axis=0)
        best = int(np.fft.irfft(cross, self._n).argmax()) * 2 * np.pi / self._n
        return float(expected_rad + np.angle(np.exp(1j * (best - expected_rad))))


def _by_angle(plate: NDArray[np.floating], seen: Strips) -> NDArray[np.float64]:
    """Σ over the visible part of plate-fixed images (steps, r, n), for turns by whole samples.

    Shape (steps, n): one row for each of the images, which are a fraction of a sample apart.
    """
    if seen.all():
        whole = plate.sum(axis=(1, 2), dtype=float)
        return np.broadcast_to(whole[:, None], (len(plate), plate.shape[2]))
    cross = np.einsum("srk,rk->sk", np.conj(np.fft.rfft(plate, axis=2)), np.fft.rfft(seen, axis=1))
    return np.fft.irfft(cross, plate.shape[2], axis=1)
