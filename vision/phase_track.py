"""The result of the tracking: arrays, numbers and strings only, so that it can be stored.

``PhaseTrack`` is the plate angle as measured in each frame, within one turn; ``PlateAngle`` the
continuous angle that ``vision.rate`` makes of it; ``RateHistory`` the rate from turn to turn.
"""

from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from vision.geometry import FloatArray, PlateView

BoolArray = NDArray[np.bool_]

USUAL_MARK_RADIUS = 0.7  #: plate radii
LUMA = "luma"  #: the usual channel


@dataclass(frozen=True, eq=False)
class PlateLayout:
    """Position of the plate in the frames of a clip, and its recognised features.

    Attributes
    ----------
    view : array, shape (3, 3)
        Plate coordinates to pixels of the reduced frame (``vision.geometry``).
    reduction : int
        Whole factor by which the frames were reduced.
    size_px : (int, int)
        Width and height of the clip as displayed, before the reduction.
    channel : str
        Measured quantity of the frames: "luma", or an axis of colour, "0.99 Cr + 0.12 Cb".
    symmetry : int
        The plate looks the same after a turn of 2π/symmetry.
    mark_azimuth_rad, mark_radius : float
        The mark at plate angle zero, the radius in plate radii; NaN without a mark.
    explained : float
        Share of its variation that rotation about its axis explains; NaN if not measured.
    """

    view: FloatArray
    reduction: int
    size_px: tuple[int, int]
    channel: str
    symmetry: int = 1
    mark_azimuth_rad: float = np.nan
    mark_radius: float = np.nan
    explained: float = np.nan

    @property
    def mark(self) -> tuple[float, float]:
        """Radius, and azimuth at plate angle zero, of the mark; of an arbitrary place without one.
        """
        return (USUAL_MARK_RADIUS, 0.0) if np.isnan(self.mark_azimuth_rad) else (
            self.mark_radius, self.mark_azimuth_rad)

    def mark_row_px(self, angle_rad: FloatArray) -> FloatArray:
        """Distance of the mark below the spindle at plate angles of shape (f,).

        In pixels of the reduced frame, shape (f,). Without a mark, that of its usual place on the
        plate; 0 if the plate looks the same several times per turn, because no frame identifies
        the places.
        """
        if self.symmetry > 1:
            return np.zeros_like(angle_rad)
        (radius, azimuth), view = self.mark, PlateView(self.view)
        _, rows = view.pixels(np.full_like(angle_rad, radius), angle_rad + azimuth)
        return rows - view.centre_px[1]


@dataclass(frozen=True, eq=False)
class PhaseTrack:
    """Plate angle in every frame of a clip.

    Attributes
    ----------
    source : str
        Name of the file, for messages.
    plate : PlateLayout
    time_s : array, shape (f,)
        Time stamps of the container, seconds from the first frame.
    phase_rad : array, shape (f,)
        Refined plate angle in (-π, π], zero where the template has its azimuth zero, at the time
        when the row of the mark was read; NaN if the plate was not seen.
    quality : array, shape (f,)
        Correlation of the frame with the template, -1 to 1.
    duplicate : array of bool, shape (f,)
        The frame repeats the one before.
    coding : array of uint8, shape (f,)
        ASCII code of I, P or B: coded by itself, predicted from frames before it, or from both
        sides; any other if that is not known.
    thumbnail : array of uint8, shape (f, m)
        The luma of a few hundred pixels on and around the plate, for the rate by autocorrelation.
    smear_rad2 : array, shape (f,)
        Variance of the motion blur along the turn beyond that of the template, rad²: the blur
        grows with the exposure time. NaN if the plate was not seen.
    brightness : array, shape (f,)
        Mean luma of those pixels.
    motion : array, shape (f, 3, 3)
        Pixels of the plate's view to pixels of each frame, homogeneous; the identity if the camera
        stood still.
    roll_rad : array, shape (f,)
        Roll of the camera that is left, as what stands around the plate shows it; NaN where it was
        not looked at.
    annotated : array of uint8, shape (b,)
        A PNG of one frame with plate, centre, marks and radii drawn in.
    notes : tuple of str
        Notes for the user about the tracking.
    leaning_frames : float
        Sd of the drift of the angle over the clip, beside the noise of the frames, frame times.
    """

    source: str
    plate: PlateLayout
    time_s: FloatArray
    phase_rad: FloatArray
    quality: FloatArray
    duplicate: BoolArray
    coding: NDArray[np.uint8]
    thumbnail: NDArray[np.uint8]
    smear_rad2: FloatArray
    brightness: FloatArray
    motion: FloatArray
    roll_rad: FloatArray
    annotated: NDArray[np.uint8]
    notes: tuple[str, ...]
    leaning_frames: float = 0.0

    @property
    def apparent_turns(self) -> float:
        """Turns from the first frame to the last, by the shortest way from frame to frame.

        Over frames without an angle the plate is taken to turn at the mean rate of the others.
        """
        step = np.angle(np.exp(1j * np.diff(self.phase_rad)))
        shown = np.isfinite(step)
        lasts = np.diff(self.time_s)
        shown_s = float(lasts[shown].sum())
        if shown_s <= 0:
            return 0.0
        return float(abs(step[shown].sum()) / (2 * np.pi) * lasts.sum() / shown_s)

    def frames(self, chosen: BoolArray) -> "PhaseTrack":
        """Some of the frames, shape (f,); their times stay those of the clip."""
        arrays = {each.name: getattr(self, each.name) for each in fields(self)}
        del arrays["annotated"]
        of_frames: dict[str, Any] = {
            name: array[chosen] for name, array in arrays.items() if isinstance(array, np.ndarray)
        }
        return replace(self, **of_frames)

    @property
    def forward(self) -> BoolArray:
        """Frames predicted from earlier ones, without a bidirectional neighbour; shape (f,)."""
        both = np.pad(self.coding == ord("B"), 1)
        return np.asarray((self.coding == ord("P")) & ~both[:-2] & ~both[2:])


@dataclass(frozen=True, eq=False)
class PlateAngle:
    """The continuous angle, on the usable frames.

    Attributes
    ----------
    time_s, angle_rad : array, shape (u,)
        Positive angle counter-clockwise as filmed; time by the time base.
    index : array of int, shape (u,)
        Frame number.
    dropped : array, shape (u,)
        Frame times that the stamps lack between the previous frame and this one: whole ones of
        frames dropped silently, any of a clock that stepped.
    stepped : array of bool, shape (u,)
        Whether the clock stepped there.
    frame_s : float
        Usual time from frame to frame.
    """

    time_s: FloatArray
    angle_rad: FloatArray
    index: NDArray[np.intp]
    dropped: FloatArray
    stepped: BoolArray
    frame_s: float

    @property
    def repaired_time_s(self) -> FloatArray:
        """Time with the time of the dropped frames added, shape (u,)."""
        return np.asarray(self.time_s + self.frame_s * np.cumsum(self.dropped))

    def without(self, some: BoolArray) -> "PlateAngle":
        """The angle without some frames, shape (u,); frames dropped before them stay counted."""
        kept = ~some
        return replace(
            self,
            time_s=self.time_s[kept],
            angle_rad=self.angle_rad[kept],
            index=self.index[kept],
            dropped=np.diff(np.cumsum(self.dropped)[kept], prepend=0),
            stepped=np.diff(np.cumsum(self.stepped)[kept], prepend=0) > 0,
        )


@dataclass(frozen=True, eq=False)
class RateHistory:
    """Rate from turn to turn, for a plate that does not turn steadily.

    Attributes
    ----------
    time_s, rate_rad_s : array, shape (m,)
        Middle of about one turn, and the mean rate over it; signed.
    angle : PlateAngle
    phase_noise_rad : float
        White noise of a single angle, from third differences, free of smooth motion.
    """

    time_s: FloatArray
    rate_rad_s: FloatArray
    angle: PlateAngle
    phase_noise_rad: float

    @property
    def revolutions(self) -> float:
        """Turns from the first frame to the last, unsigned."""
        return float(abs(self.angle.angle_rad[-1] - self.angle.angle_rad[0]) / (2 * np.pi))

    @property
    def rate_so_far_rad_s(self) -> FloatArray:
        """Rate from the angles up to each frame, unsigned, shape (u,); NaN before the first turn.

        It is the slope of the straight line through them; the measured rate also fits the waves
        once and twice per turn.
        """
        time_s = self.angle.repaired_time_s - self.angle.repaired_time_s[0]
        turned = np.abs(self.angle.angle_rad - self.angle.angle_rad[0])
        n = np.arange(1.0, len(time_s) + 1)
        t, a = np.cumsum(time_s), np.cumsum(turned)
        spread = np.cumsum(time_s**2) - t**2 / n
        slope = (np.cumsum(time_s * turned) - t * a / n) / np.where(spread > 0, spread, np.nan)
        return np.where(turned >= 2 * np.pi, slope, np.nan)
