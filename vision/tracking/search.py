"""The stretch of a clip in which a plate is found, and its appearance there."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from itertools import chain
from pathlib import Path
from typing import TYPE_CHECKING

from vision.errors import NoSuchPart, NothingMoves, RateRefused, UnreadableVideo, more_telling
from vision.geometry import PlateOverride
from vision.tracking.stretch import Stretch, next_stretch
from vision.video.reader import ClipReader, Frame

if TYPE_CHECKING:
    from vision.plate.learn import PlateModel

FEWEST = 12  # least number of frames for any result


@dataclass(frozen=True)
class ClipTask:
    """A clip to track, and the receiver of its progress."""

    path: Path
    rim: PlateOverride | None
    from_s: float
    on_progress: Callable[[int, int | None], None] | None

    def report(self, clip: ClipReader, count: int) -> None:
        """Report the number of frames of the clip that are done."""
        if self.on_progress is not None:
            self.on_progress(count, clip.frames_stated)


def learned_plate(
    task: ClipTask,
    clip: ClipReader,
    batches: Iterator[list[Frame]],
    on_frames: Callable[[int], None],
    *,
    colours: bool,
    camera_moves: bool,
) -> "tuple[PlateModel, Stretch]":
    """The plate, and the frames from which it was learned.

    In their colours or their brightness; if the camera is known to move, without its motion.
    """
    from vision.plate.channel import Brightness, axes_of_colour
    from vision.plate.learn import learn

    rim = task.rim.view(clip.reduction) if task.rim else None
    batches, skipped = _frames_after(task.from_s, batches)
    refusal: RateRefused | None = None
    while True:  # the first stretch in which something moves decides
        on_step = partial(on_frames, skipped)
        stretch = next_stretch(batches, skipped, on_step)
        if task.from_s > 0 and len(stretch.frames) < FEWEST and refusal is None:
            raise NoSuchPart(
                f"{task.path.name}: choose a part within the clip: {len(stretch.frames)} of its "
                f"{skipped + stretch.read} frames come after {task.from_s:.1f} s.")
        if not stretch.frames or (refusal is not None and len(stretch.frames) < FEWEST):
            break
        if len(stretch.frames) < FEWEST:
            raise UnreadableVideo(
                f"{task.path}: {len(stretch.frames)} frame(s) found, at least {FEWEST} expected; a "
                f"rate needs a clip of the turning plate, at best a minute long."
            )
        stretch = stretch.with_fields().steadied(camera_moves=camera_moves)
        seen = axes_of_colour(stretch.frames) if colours else [Brightness()]
        try:
            plate = learn(task.path.name, stretch.frames, seen, rim, on_step)
            return plate, stretch
        except NothingMoves as error:
            refusal = more_telling(refusal, error)
            skipped += stretch.read
    raise refusal or UnreadableVideo(
        f"{task.path}: the file has a video stream, but not one frame could be decoded; copy it "
        f"from the camera again or convert it to H.264."
    )


def _frames_after(
    from_s: float, batches: Iterator[list[Frame]]
) -> tuple[Iterator[list[Frame]], int]:
    """The frames after a time of the clip, and the number of frames before it."""
    skipped = 0
    for batch in batches:
        later = [frame for frame in batch if frame.time_s >= from_s]
        skipped += len(batch) - len(later)
        if later:
            return chain([later], batches), skipped
    return batches, skipped
