"""The frames of a clip from which the plate is learned, and the treatment of later frames."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from vision.video.reader import Frame

if TYPE_CHECKING:
    from vision.plate.fields import Interlacing
    from vision.tracking.registration import Registration

LEARN_FROM = (150, 300)  # frames, at least and at most
LEARN_BYTES = 96_000_000  #: bytes of the frames for learning the plate; a limit of memory


# Limits for the frames to learn from.
LEARN_FOR_S = 7.2  #: seconds to learn the plate from. Derived: two turns at 16 2/3 rpm
FAST_S = 2.0
"""Duration of the frames to learn from below which the camera is fast. Tuned on the 240 fps clip of
tests.vision.test_clips."""


@dataclass(frozen=True, eq=False)
class Stretch:
    """Frames to learn from.

    Every ``stride``-th of the ``read`` frames that follow the first ``skipped`` of the clip; their
    fields if they are interlaced, registered to one of them if the camera moves; ``around`` the
    surroundings of the plate, if they are visible and do not move.
    """

    frames: list[Frame]
    stride: int
    read: int
    skipped: int
    interlacing: "Interlacing | None" = None
    camera: "Registration | None" = None
    around: "Registration | None" = None

    def with_fields(self) -> "Stretch":
        """Interlaced frames split into their fields."""
        from vision.plate.fields import interlacing

        fields = interlacing(self.frames)
        return self if fields is None else replace(
            self, frames=fields.split(self.frames), interlacing=fields)

    def steadied(self, *, camera_moves: bool) -> "Stretch":
        """Without the motion of the camera, if it moves or is known to move."""
        from vision.tracking.registration import registration

        camera = registration(self.frames)
        if camera is None or not (camera_moves or camera.moves):
            return replace(self, around=camera)
        return replace(self, frames=[camera.back(frame) for frame in self.frames], camera=camera)

    def prepared(self, batches: Iterator[list[Frame]]) -> Iterator[list[Frame]]:
        """Further frames of the clip, treated like these."""
        if self.interlacing is not None:
            batches = self.interlacing.fields(batches)
        return batches if self.camera is None else self.camera.steadied(batches)


def next_stretch(
    batches: Iterator[list[Frame]], skipped: int, on_step: Callable[[], object]
) -> Stretch:
    """The next frames to learn from; none at the end of the clip.

    Parameters
    ----------
    batches : iterator of lists of Frame
    skipped : int
        Number of frames of the clip before them.
    on_step : callable
        Called for every batch.
    """
    frames: list[Frame] = []
    read = 0
    stride = 1
    fewest, most = LEARN_FROM
    for batch in batches:
        on_step()
        frames += batch[-read % stride :: stride]
        read += len(batch)
        span_s = frames[-1].time_s - frames[0].time_s
        if len(frames) >= fewest and span_s >= LEARN_FOR_S:
            break
        if len(frames) >= most or len(frames) * frames[0].nbytes > LEARN_BYTES:
            if span_s >= FAST_S:
                break
            frames, stride = frames[::2], 2 * stride
    return Stretch(frames, stride, read, skipped)
