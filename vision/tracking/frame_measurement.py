"""What is measured in every frame; together, a phase track."""

from dataclasses import replace

import cv2
import numpy as np
from numpy.typing import NDArray

from vision.geometry import FloatArray, PlateView
from vision.phase_track import PhaseTrack
from vision.plate.background import repeated
from vision.plate.learn import PlateModel
from vision.plate.mark import find_fixed_mark, find_mark
from vision.tracking.camera_motion import CameraMotion
from vision.tracking.tracker import PlateTracker
from vision.video import ClipReader, Frame, Luma

WIDEST = 640
PLATE, CENTRE, MARK, FIXED_MARK = (80, 220, 80), (60, 60, 255), (255, 200, 0), (0, 200, 255)  # BGR

ROLL_EVERY_S = 0.9  # a camera moves slowly
THUMBNAIL = 20  # samples across the plate's surroundings, each way


class FrameMeasurements:
    """One row per frame, and what is needed to measure the next."""

    def __init__(self, found: PlateModel, shown: Frame, shown_index: int) -> None:
        """``shown`` is the frame to annotate, ``shown_index`` its place among those added."""
        self._found = found
        grid = found.template.grid
        self._mark = find_mark(found.template)
        self._tracker = PlateTracker(found.template, self._mark, found.rate_rad_s)
        x, y = grid.view.pixels(np.ones(90), np.linspace(0, 2 * np.pi, 90))
        h, w = shown.luma.shape
        self._columns, self._rows = _samples(x, w), _samples(y, h)
        self._camera = CameraMotion(grid.view, found.still)
        self._rolled_s = -np.inf
        self._shown, self._shown_index = shown.bgr, shown_index
        self._image = np.empty((h, w), np.uint8)
        self._thumbnails: list[Luma] = []
        self._coding: list[int] = []
        self._measured: list[FloatArray] = []

    def __len__(self) -> int:
        return len(self._thumbnails)

    @property
    def last_s(self) -> float:
        """Stamp of the latest frame."""
        return float(self._measured[-1][0, -1])

    def add(self, frames: list[Frame]) -> None:
        """Measure the next frames."""
        time_s = np.array([frame.time_s for frame in frames])
        strips = [self._strip(self._found.channel(frame)) for frame in frames]
        self._coding += [frame.coding for frame in frames]
        found = self._tracker.angles(time_s, strips)
        roll = np.full(len(frames), np.nan)
        if time_s[0] >= self._rolled_s + ROLL_EVERY_S:
            roll[0] = self._camera.roll(frames[0].luma)
            self._rolled_s = time_s[0]
        self._measured.append(
            np.array(
                [time_s, found.angle_rad, found.mark_angle_rad, found.match, found.change, roll]
            )
        )

    def _strip(self, image: Luma) -> Luma:
        # Copied into the processor's cache as a whole: the rings jump about in a frame, which
        # was decoded some time ago, and each jump would wait for the memory.
        self._image[:] = image
        self._thumbnails.append(self._image[self._rows, self._columns].ravel())
        return self._found.template.grid.strip(self._image)

    def track(self, clip: ClipReader, notes: tuple[str, ...]) -> PhaseTrack:
        """Everything measured so far; the clip it is from, and words on it."""
        grid = self._found.template.grid
        time_s, phase, seed, quality, change, roll = np.hstack(self._measured)
        mark, resting = self._mark, grid.view.at_rest
        h, w = self._image.shape
        fixed_mark = find_fixed_mark(self._found.still, resting)
        at = None
        if mark is not None:
            at = (mark.radius, mark.azimuth_rad + phase[self._shown_index])
        track = PhaseTrack(
            source=clip.path.name,
            time_s=time_s,
            phase_rad=_wrapped(phase),
            mark_angle_rad=_wrapped(seed),
            quality=quality,
            duplicate=repeated(change),
            coding=np.array(self._coding).astype(np.uint8),
            thumbnail=np.stack(self._thumbnails),
            roll_rad=roll,
            symmetry=self._found.symmetry,
            mark_rad=np.nan if mark is None else mark.azimuth_rad,
            mark_radius=np.nan if mark is None else mark.radius,
            fixed_mark_rad=np.nan if fixed_mark is None else fixed_mark[1],
            fixed_mark_radius=np.nan if fixed_mark is None else fixed_mark[0],
            view=grid.view.matrix,
            size_px=(w * clip.reduction, h * clip.reduction),
            reduction=clip.reduction,
            explained=self._found.template.explained,
            fps_stated=clip.fps_stated,
            annotated=annotate(
                self._shown,
                resting,
                (float(grid.radius[0]), float(grid.radius[-1])),
                at,
                fixed_mark,
            ),
            notes=(*self._found.notes, *notes),
            channel=str(self._found.channel),
        )
        # The template holds for the row of the spindle; every frame is stamped for its own mark.
        turned_on = grid.view.lag_rad_px * track.mark_row_px(phase)
        return replace(
            track,
            phase_rad=_wrapped(phase + turned_on),
            mark_angle_rad=_wrapped(track.mark_angle_rad + turned_on),
        )


def _samples(reach: FloatArray, size: int) -> slice:
    """Evenly spaced pixels across the plate, one coordinate."""
    low, high = max(0, int(reach.min())), min(size, int(reach.max()) + 1)
    return slice(low, high, max(1, (high - low) // THUMBNAIL))


def _wrapped(angle_rad: FloatArray) -> FloatArray:
    return np.asarray(np.angle(np.exp(1j * angle_rad)))


def annotate(
    image: NDArray[np.uint8],
    view: PlateView,
    rings: tuple[float, float],
    mark: tuple[float, float] | None,
    fixed_mark: tuple[float, float] | None,
) -> NDArray[np.uint8]:
    """Plate, spindle, used radii and marks in colour over a frame, shape (h, w, 3).

    Parameters
    ----------
    image : array of uint8, shape (h, w, 3)
        Blue-green-red.
    view : View
    rings : (inner, outer)
        Radii between which the angle was measured.
    mark, fixed_mark : (radius, azimuth in rad), optional
        As they stand in this frame.
    """
    scale = min(1.0, WIDEST / image.shape[1])
    if scale < 1:
        size = (round(image.shape[1] * scale), round(image.shape[0] * scale))
        image = np.asarray(cv2.resize(image, size, interpolation=cv2.INTER_AREA), np.uint8)
    canvas = image.copy()

    def point(radius: float, azimuth: float) -> tuple[int, int]:
        x, y = view.pixels(np.array(radius), np.array(azimuth))
        return round(float(x) * scale), round(float(y) * scale)

    for radius, thickness in ((1.0, 2), (rings[0], 1), (rings[1], 1)):
        outline = [point(radius, a) for a in np.linspace(0, 2 * np.pi, 181)]
        cv2.polylines(canvas, [np.array(outline, np.int32)], True, PLATE, thickness, cv2.LINE_AA)
    centre = point(0.0, 0.0)
    cv2.drawMarker(canvas, centre, CENTRE, cv2.MARKER_CROSS, 15, 2, cv2.LINE_AA)
    for spot, colour in ((mark, MARK), (fixed_mark, FIXED_MARK)):
        if spot is not None:
            at = point(*spot)
            cv2.line(canvas, centre, at, colour, 1, cv2.LINE_AA)
            cv2.circle(canvas, at, 9, colour, 2, cv2.LINE_AA)
    return np.asarray(canvas, np.uint8)
