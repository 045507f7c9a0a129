"""The measurements of every frame; together, a phase track."""

import numpy as np

from vision.drawing import annotated
from vision.geometry import FloatArray
from vision.phase_track import PhaseTrack, PlateLayout
from vision.plate.background import repeated
from vision.plate.learn import PlateModel
from vision.plate.mark import MOST_FOLD, find_mark
from vision.tracking.roll_gauge import RollGauge
from vision.tracking.stretch import Stretch
from vision.tracking.tracker import MeasuredAngles, PlateTracker
from vision.video.reader import ClipReader, Frame, Luma

LOOKED_EVERY_S = 0.9  # seconds: a camera moves slowly
THUMBNAIL = 20  # samples across the plate and its surroundings, each way


class FrameMeasurements:
    """The measurements of all frames so far, and the state for the next ones.

    Parameters
    ----------
    plate : PlateModel
    stretch : Stretch
        The frames from which it was learned; the one in the middle is annotated.
    """

    def __init__(self, plate: PlateModel, stretch: Stretch) -> None:
        self._plate = plate
        view = plate.template.grid.view
        self._mark = find_mark(plate.template) if plate.symmetry <= MOST_FOLD else None
        self._tracker = PlateTracker(plate.template, plate.rate_rad_s)
        x, y = view.pixels(np.ones(90), np.linspace(0, 2 * np.pi, 90))
        middle = len(stretch.frames) // 2
        shown = stretch.frames[middle]
        h, w = shown.luma.shape
        self._part = _samples(y, h), _samples(x, w)
        self._around, self._looked_s = stretch.around, -np.inf
        self._gauge = RollGauge([frame.luma for frame in stretch.frames], view)
        self._shown, self._shown_index = shown.bgr, stretch.skipped + middle * stretch.stride
        self._image = np.empty((h, w), np.uint8)
        self._thumbnails: list[Luma] = []
        self._coding: list[int] = []
        self._time_s: list[float] = []
        self._brightness: list[float] = []
        self._motion: list[FloatArray] = []
        self._roll_rad: list[float] = []
        self._angles: list[MeasuredAngles] = []

    def __len__(self) -> int:
        return len(self._time_s)

    @property
    def last_s(self) -> float:
        """Stamp of the latest frame."""
        return self._time_s[-1]

    @property
    def camera_moved(self) -> bool:
        """Whether the surroundings of the plate moved after the plate was learned."""
        return self._around is not None and self._around.moved

    def add(self, frames: list[Frame]) -> None:
        """Measure the next frames."""
        time_s = np.array([frame.time_s for frame in frames])
        strips = [self._strip(self._plate.channel(frame)) for frame in frames]
        self._angles.append(self._tracker.angles(time_s, strips))
        self._roll_rad += [np.nan] * len(frames)
        if time_s[0] >= self._looked_s + LOOKED_EVERY_S:
            self._roll_rad[len(self)] = self._gauge.roll_rad(frames[0].luma)
            if self._around is not None:
                self._around.look(frames[0].luma)
            self._looked_s = time_s[0]
        self._time_s += time_s.tolist()
        self._coding += [frame.coding for frame in frames]
        self._motion += [frame.motion for frame in frames]
        around = np.stack([frame.luma[self._part] for frame in frames])
        self._brightness += around.mean(axis=(1, 2)).tolist()

    def _strip(self, image: Luma) -> Luma:
        # Copied into the processor's cache as a whole: the rings access a frame at scattered
        # places, and since it was decoded some time ago, each access would wait for the memory.
        self._image[:] = image
        self._thumbnails.append(self._image[self._part].ravel())
        return self._plate.template.grid.strip(self._image)

    def track(self, clip: ClipReader, notes: tuple[str, ...]) -> PhaseTrack:
        """All measurements so far, with their clip and notes on it."""
        angles = MeasuredAngles.joined(self._angles)
        layout = self._layout(clip)
        # The template holds for the row of the spindle; a frame is stamped at the row of its mark.
        lag_rad_px = self._plate.template.grid.view.lag_rad_px
        turned_on = lag_rad_px * layout.mark_row_px(angles.angle_rad)
        return PhaseTrack(
            source=clip.path.name,
            plate=layout,
            time_s=np.array(self._time_s),
            phase_rad=np.angle(np.exp(1j * (angles.angle_rad + turned_on))),
            quality=angles.match,
            duplicate=repeated(angles.change) & np.isfinite(angles.angle_rad),
            coding=np.array(self._coding).astype(np.uint8),
            thumbnail=np.stack(self._thumbnails),
            smear_rad2=angles.smear_rad2,
            brightness=np.array(self._brightness),
            motion=np.stack(self._motion),
            roll_rad=np.array(self._roll_rad),
            annotated=annotated(self._shown, layout, float(angles.angle_rad[self._shown_index])),
            notes=(*self._plate.notes, *notes),
        )

    def _layout(self, clip: ClipReader) -> PlateLayout:
        template, mark = self._plate.template, self._mark
        h, w = self._image.shape
        return PlateLayout(
            view=template.grid.view.matrix,
            reduction=clip.reduction,
            size_px=(w * clip.reduction, h * clip.reduction),
            channel=str(self._plate.channel),
            symmetry=self._plate.symmetry,
            mark_azimuth_rad=np.nan if mark is None else mark.azimuth_rad,
            mark_radius=np.nan if mark is None else mark.radius,
            explained=template.explained,
        )


def _samples(reach: FloatArray, size: int) -> slice:
    """Evenly spaced pixels across the plate, one coordinate."""
    low, high = max(0, int(reach.min())), min(size, int(reach.max()) + 1)
    return slice(low, high, max(1, (high - low) // THUMBNAIL))
