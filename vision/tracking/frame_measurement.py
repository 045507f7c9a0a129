"""What is measured in every frame; together, a phase track."""

import cv2
import numpy as np
from numpy.typing import NDArray

from vision.geometry import FloatArray, PlateView
from vision.phase_track import PhaseTrack, PlateLayout
from vision.plate.background import repeated
from vision.plate.learn import PlateModel
from vision.plate.mark import MOST_FOLD, find_fixed_mark, find_mark
from vision.tracking.camera_motion import CameraMotion
from vision.tracking.tracker import MeasuredAngles, PlateTracker
from vision.video.reader import ClipReader, Frame, Luma

ROLL_EVERY_S = 0.9  # seconds: a camera moves slowly
THUMBNAIL = 20  # samples across the plate and what is around it, each way
WIDEST = 640  # pixels of the annotated frame
KEPT_BITS = 5  # of its channels
#: Level of its PNG: a third of the time of the library's own choice, for 4 per cent more space.
FAST_PNG = (cv2.IMWRITE_PNG_STRATEGY, cv2.IMWRITE_PNG_STRATEGY_RLE,
            cv2.IMWRITE_PNG_FILTER, cv2.IMWRITE_PNG_FILTER_UP)
PLATE, CENTRE, MARK, FIXED_MARK = (80, 220, 80), (60, 60, 255), (255, 200, 0), (0, 200, 255)  # BGR


class FrameMeasurements:
    """The measurements of all frames so far, and what is needed to measure the next.

    Parameters
    ----------
    plate : PlateModel
    shown : Frame
        The frame to annotate.
    shown_index : int
        Its place among the frames added.
    """

    def __init__(self, plate: PlateModel, shown: Frame, shown_index: int) -> None:
        self._plate = plate
        view = plate.template.grid.view
        self._mark = find_mark(plate.template) if plate.symmetry <= MOST_FOLD else None
        self._tracker = PlateTracker(plate.template, plate.rate_rad_s)
        x, y = view.pixels(np.ones(90), np.linspace(0, 2 * np.pi, 90))
        h, w = shown.luma.shape
        self._columns, self._rows = _samples(x, w), _samples(y, h)
        self._camera = CameraMotion(view, plate.background)
        self._roll_measured_s = -np.inf
        self._shown, self._shown_index = shown.bgr, shown_index
        self._image = np.empty((h, w), np.uint8)
        self._thumbnails: list[Luma] = []
        self._coding: list[int] = []
        self._time_s: list[float] = []
        self._roll_rad: list[float] = []
        self._brightness: list[float] = []
        self._motion: list[FloatArray] = []
        self._angles: list[MeasuredAngles] = []

    def __len__(self) -> int:
        return len(self._time_s)

    @property
    def last_s(self) -> float:
        """Stamp of the latest frame."""
        return self._time_s[-1]

    @property
    def camera_moved(self) -> bool:
        """What lies around the plate did not stay where it was while the plate was learned."""
        return self._camera.moved

    def add(self, frames: list[Frame]) -> None:
        """Measure the next frames."""
        time_s = np.array([frame.time_s for frame in frames])
        strips = [self._strip(self._plate.channel(frame)) for frame in frames]
        self._angles.append(self._tracker.angles(time_s, strips))
        roll = np.full(len(frames), np.nan)
        if time_s[0] >= self._roll_measured_s + ROLL_EVERY_S:
            roll[0] = self._camera.roll(frames[0].luma)
            self._roll_measured_s = time_s[0]
        self._time_s += time_s.tolist()
        self._roll_rad += roll.tolist()
        self._coding += [frame.coding for frame in frames]
        self._motion += [frame.motion for frame in frames]
        part = self._rows, self._columns
        around = np.stack([frame.luma[part] for frame in frames])
        self._brightness += around.mean(axis=(1, 2)).tolist()

    def _strip(self, image: Luma) -> Luma:
        # Copied into the processor's cache as a whole: the rings jump about in a frame, which
        # was decoded some time ago, and each jump would wait for the memory.
        self._image[:] = image
        self._thumbnails.append(self._image[self._rows, self._columns].ravel())
        return self._plate.template.grid.strip(self._image)

    def track(self, clip: ClipReader, notes: tuple[str, ...]) -> PhaseTrack:
        """Everything measured so far, with the clip it is from and notes on it."""
        angles = MeasuredAngles.joined(self._angles)
        layout = self._layout(clip)
        # The template holds for the row of the spindle; every frame is stamped for its own mark.
        lag_rad_px = self._plate.template.grid.view.lag_rad_px
        turned_on = lag_rad_px * layout.mark_row_px(angles.angle_rad)
        return PhaseTrack(
            source=clip.path.name,
            plate=layout,
            time_s=np.array(self._time_s),
            phase_rad=_wrapped(angles.angle_rad + turned_on),
            quality=angles.match,
            duplicate=repeated(angles.change) & np.isfinite(angles.angle_rad),
            coding=np.array(self._coding).astype(np.uint8),
            thumbnail=np.stack(self._thumbnails),
            smear_rad2=angles.smear_rad2,
            brightness=np.array(self._brightness),
            roll_rad=np.array(self._roll_rad),
            motion=np.stack(self._motion),
            annotated=self._annotated(layout, angles.angle_rad[self._shown_index]),
            notes=(*self._plate.notes, *notes),
        )

    def _layout(self, clip: ClipReader) -> PlateLayout:
        template, mark = self._plate.template, self._mark
        fixed_mark = find_fixed_mark(self._plate.background, template.grid.view.at_rest)
        h, w = self._image.shape
        return PlateLayout(
            view=template.grid.view.matrix,
            reduction=clip.reduction,
            size_px=(w * clip.reduction, h * clip.reduction),
            channel=str(self._plate.channel),
            symmetry=self._plate.symmetry,
            explained=template.explained,
            mark_azimuth_rad=np.nan if mark is None else mark.azimuth_rad,
            mark_radius=np.nan if mark is None else mark.radius,
            fixed_mark_azimuth_rad=np.nan if fixed_mark is None else fixed_mark[1],
            fixed_mark_radius=np.nan if fixed_mark is None else fixed_mark[0],
        )

    def _annotated(self, layout: PlateLayout, angle_rad: float) -> NDArray[np.uint8]:
        grid = self._plate.template.grid
        return annotate(
            self._shown,
            grid.view.at_rest,
            (float(grid.radius[0]), float(grid.radius[-1])),
            _point(layout.mark_radius, layout.mark_azimuth_rad + angle_rad),
            _point(layout.fixed_mark_radius, layout.fixed_mark_azimuth_rad),
        )


def _point(radius: float, azimuth_rad: float) -> tuple[float, float] | None:
    return (radius, azimuth_rad) if np.isfinite([radius, azimuth_rad]).all() else None


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
    """Draw plate, spindle, measured rings and marks in colour over a frame.

    Parameters
    ----------
    image : array of uint8, shape (h, w, 3)
        Blue-green-red.
    view : View
    rings : (inner, outer)
        Radii between which the angle is measured, plate radii.
    mark, fixed_mark : (radius, azimuth in rad), optional
        As they stand in this frame; radius in plate radii.

    Returns
    -------
    array of uint8, shape (b,)
        The bytes of a PNG, at most 640 pixels wide.
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
    return png(canvas)


def png(image: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """Encode an image (h, w, 3), blue-green-red, as the bytes (b,) of a PNG.

    Every channel keeps its ``KEPT_BITS`` highest bits: the noise of a frame is most of what a PNG
    has to store, and without the lowest bits it takes a third of the space.
    """
    step = 1 << (8 - KEPT_BITS)
    coarse = (image & (256 - step)) | (step // 2)
    _, data = cv2.imencode(".png", coarse, FAST_PNG)
    return np.asarray(data, np.uint8).ravel()
