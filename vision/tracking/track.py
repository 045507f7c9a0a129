"""From a clip to the plate's angle in every frame, in one pass.

The first frames are kept until the plate has been found and learned from them; they and all that
follow are then measured as they come, so that memory does not grow with the clip. Where a camera is
so fast that the frames of a turn are too many to keep, some of them are learned from and the clip
is read again; and where the camera is seen to move after that, it is read again with its motion
taken out.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, TypeGuard

import cv2

from vision.errors import RateRefused, UnreadableVideo
from vision.geometry import PlateOverride
from vision.video import BATCH, ClipReader, Frame

if TYPE_CHECKING:
    from vision.phase_track import PhaseTrack
    from vision.plate.fields import Interlacing
    from vision.plate.learn import PlateModel
    from vision.tracking.frame_measurement import FrameMeasurements
    from vision.tracking.registration import Registration

FEWEST = 12  # frames from which anything can be said
LEARN_FROM = (150, 300)  # frames, at least and at most
LEARN_BYTES = 96_000_000
ATTEMPTS = 12  # stretches of the clip in which a plate is looked for


@dataclass(frozen=True)
class ClipThresholds:
    """How much of a clip is needed.

    Attributes
    ----------
    learn_for_s : float
        Seconds to learn the plate from. Derived: two turns at 16 2/3 rpm.
    fast_s : float
        Frames to learn from that pass in less seconds are from a fast camera. Tuned on the 240 fps
        clip of tests.vision.test_clips.
    fewest_turns : float
        Apparent turns; with less, a mark of colour may be the better one. Derived: no rate comes
        from less.
    whole : float
        Of the stated length; less was cut short.
    """

    learn_for_s: float = 7.2
    fast_s: float = 2.0
    fewest_turns: float = 1.0
    whole: float = 0.9


THRESHOLDS = ClipThresholds()


def track_phase(
    path: Path | str,
    *,
    plate: PlateOverride | None = None,
    on_progress: Callable[[int, int | None], None] | None = None,
) -> "PhaseTrack":
    """Track the plate of a clip, by its colour where the brightness shows nothing that turns.

    Parameters
    ----------
    path : path
    plate : PlateOverride, optional
        The rim as the user measured it, instead of looking for it.
    on_progress : callable (frames done, frames stated or None), optional
        Called often, also while the plate is being learned; what it raises ends the work.

    Returns
    -------
    PhaseTrack
        Angles in rad, times in s, of shape (f,).

    Raises
    ------
    UnreadableVideo
        The file is no clip, or has fewer than a dozen frames.
    RateRefused
        Nothing in the clip turns about a fixed axis, in brightness or in colour.
    """
    cv2.setNumThreads(1)  # the other cores decode
    task = _Task(Path(path), plate, on_progress)
    by_luma = _track_or_refusal(task, colours=False)
    if _turns(by_luma):
        return by_luma
    by_colour = _track_or_refusal(task, colours=True)
    if _turns(by_colour):
        return by_colour
    if isinstance(by_luma, RateRefused):
        raise by_luma
    return by_luma


@dataclass(frozen=True)
class _Task:
    """What to track, and whom to tell."""

    path: Path
    rim: PlateOverride | None
    on_progress: Callable[[int, int | None], None] | None


def _turns(result: "PhaseTrack | RateRefused") -> "TypeGuard[PhaseTrack]":
    return not isinstance(result, RateRefused) and result.apparent_turns >= THRESHOLDS.fewest_turns


def _track_or_refusal(task: _Task, *, colours: bool) -> "PhaseTrack | RateRefused":
    try:
        return _tracked(task, colours=colours)
    except RateRefused as refusal:
        return refusal


def _tracked(task: _Task, *, colours: bool, camera_moves: bool = False) -> "PhaseTrack":
    with ClipReader(task.path, colours=colours) as clip:

        def on_frames(count: int) -> None:
            if task.on_progress is not None:
                task.on_progress(count, clip.frames_stated)

        from vision.tracking.frame_measurement import FrameMeasurements  # while frames are decoded

        batches = iter(clip)
        plate, stretch = _learn_plate(task, clip, batches, on_frames, camera_moves)
        shown = len(stretch.frames) // 2
        measurements = FrameMeasurements(plate, stretch.frames[shown], shown * stretch.stride)
        if stretch.stride == 1:
            rest = _chain(stretch.frames, stretch.prepared(batches))
            track = _measured(measurements, clip, rest, stretch, on_frames)
        else:
            stretch.frames.clear()
    if stretch.stride > 1:
        with ClipReader(task.path, colours=colours) as clip:
            rest = stretch.prepared(_after(stretch.skipped, clip))
            track = _measured(measurements, clip, rest, stretch, on_frames)
    if stretch.camera is None and not camera_moves and measurements.camera_moved:
        return _tracked(task, colours=colours, camera_moves=True)
    return track


def _measured(
    measurements: "FrameMeasurements",
    clip: ClipReader,
    batches: Iterator[list[Frame]],
    stretch: "_Stretch",
    on_frames: Callable[[int], None],
) -> "PhaseTrack":
    """The track of all frames in the batches; those before the stretch are left out."""
    skipped = stretch.skipped
    for batch in batches:
        measurements.add(batch)
        on_frames(skipped + len(measurements))
    notes = []
    if skipped:
        notes.append(
            f"The plate was not seen turning in the first {skipped} frames, which are left out."
        )
    if clip.orientation.mirrored:
        notes.append(
            f"{clip.path.name}: the file has its frames displayed mirrored, as front cameras do. "
            f"The sense of rotation is that of the displayed frame; if writing in it reads "
            f"backwards, the plate itself turns the other way."
        )
    notes += [part.note(clip.path.name) for part in (stretch.interlacing, stretch.camera) if part]
    # By the time, not the count: containers without one state duration times frame rate.
    if clip.seconds_stated and measurements.last_s < THRESHOLDS.whole * clip.seconds_stated:
        notes.append(
            f"The file states {clip.seconds_stated:.1f} s, {measurements.last_s:.1f} s could be "
            f"decoded: it is damaged or was cut short."
        )
    return measurements.track(clip, tuple(notes))


@dataclass(frozen=True, eq=False)
class _Stretch:
    """Frames to learn from.

    Every ``stride``-th of the ``read`` frames that follow the first ``skipped`` of the clip; their
    fields where they are interlaced, brought back onto one of them where a camera moves.
    """

    frames: list[Frame]
    stride: int
    read: int
    skipped: int
    interlacing: "Interlacing | None" = None
    camera: "Registration | None" = None

    def with_fields(self) -> "_Stretch":
        """Interlaced frames split into their fields."""
        from vision.plate.fields import interlacing

        fields = interlacing(self.frames)
        return self if fields is None else replace(
            self, frames=fields.split(self.frames), interlacing=fields)

    def steadied(self, *, camera_moves: bool) -> "_Stretch":
        """Without the motion of the camera, where it moves or is known to move."""
        from vision.tracking.registration import THRESHOLDS as REGISTRATION
        from vision.tracking.registration import registration

        camera, moved_px = registration(self.frames)
        if camera is None or not (camera_moves or moved_px > REGISTRATION.moved_px):
            return self
        return replace(self, frames=[camera.back(frame) for frame in self.frames], camera=camera)

    def prepared(self, batches: Iterator[list[Frame]]) -> Iterator[list[Frame]]:
        """Further frames of the clip, treated as these."""
        if self.interlacing is not None:
            batches = self.interlacing.fields(batches)
        return batches if self.camera is None else self.camera.steadied(batches)


def _learn_plate(
    task: _Task,
    clip: ClipReader,
    batches: Iterator[list[Frame]],
    on_frames: Callable[[int], None],
    camera_moves: bool,
) -> "tuple[PlateModel, _Stretch]":
    """The plate, and the frames it was learned from."""
    from vision.plate.learn import learn

    rim = task.rim.view(clip.reduction) if task.rim else None
    skipped = 0
    refusal: RateRefused | None = None
    for _ in range(ATTEMPTS):
        on_step = partial(on_frames, skipped)
        stretch = _next_stretch(batches, skipped, on_step)
        if not stretch.frames:
            break
        if len(stretch.frames) < FEWEST and refusal is None:
            raise UnreadableVideo(
                f"{task.path}: {len(stretch.frames)} frame(s) found, at least {FEWEST} expected; a "
                f"rate needs a clip of the turning plate, at best a minute long."
            )
        stretch = stretch.with_fields().steadied(camera_moves=camera_moves)
        try:
            return learn(task.path.name, stretch.frames, rim, on_step), stretch
        except RateRefused as error:
            refusal = refusal or error
            skipped += stretch.read
    raise refusal or UnreadableVideo(
        f"{task.path}: the file has a video stream, but not one frame could be decoded; copy it "
        f"from the camera again or convert it to H.264."
    )


def _next_stretch(
    batches: Iterator[list[Frame]], skipped: int, on_step: Callable[[], object]
) -> _Stretch:
    frames: list[Frame] = []
    read = 0
    stride = 1
    fewest, most = LEARN_FROM
    for batch in batches:
        on_step()
        frames += batch[-read % stride :: stride]
        read += len(batch)
        span_s = frames[-1].time_s - frames[0].time_s
        if len(frames) >= fewest and span_s >= THRESHOLDS.learn_for_s:
            break
        if len(frames) >= most or len(frames) * frames[0].nbytes > LEARN_BYTES:
            if span_s >= THRESHOLDS.fast_s:
                break
            frames, stride = frames[::2], 2 * stride
    return _Stretch(frames, stride, read, skipped)


def _chain(first: list[Frame], rest: Iterator[list[Frame]]) -> Iterator[list[Frame]]:
    """All frames in batches; the first are let go as they are handed on."""
    while first:
        yield first[:BATCH]
        del first[:BATCH]
    yield from rest


def _after(skipped: int, clip: ClipReader) -> Iterator[list[Frame]]:
    """The frames of a clip after the first ones."""
    for batch in clip:
        if skipped < len(batch):
            yield batch[skipped:]
        skipped = max(0, skipped - len(batch))
