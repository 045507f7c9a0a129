"""From a clip to the plate's angle in every frame, in one pass.

The first frames are kept until the plate has been found and learned from them; they and all that
follow are then measured as they come, so that memory does not grow with the clip. Where no plate is
in the brightness of the first frames, the clip is read with its colours (unless glimpses of it show
that nothing moves), and colours and brightness of one stretch after the other are looked at; a
plate in a later brightness is then tracked from there. Where a camera is so fast that the frames of
a turn are too many to keep, some of them are learned from and the clip is read again; and where the
camera is seen to move after that, it is read again with its motion taken out.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, TypeGuard

import cv2

from vision.errors import NothingMoves, RateRefused, UnreadableVideo, more_telling
from vision.geometry import PlateOverride
from vision.tracking.glimpses import nothing_moves
from vision.tracking.stretch import Stretch, next_stretch
from vision.video.reader import BATCH, ClipReader, Frame

if TYPE_CHECKING:
    from vision.phase_track import PhaseTrack
    from vision.plate.learn import PlateModel
    from vision.tracking.frame_measurement import FrameMeasurements

FEWEST = 12  # frames from which anything can be said
ATTEMPTS = 12  # stretches of the clip in which a plate is looked for


@dataclass(frozen=True)
class ClipThresholds:
    """How much of a clip is needed.

    Attributes
    ----------
    fewest_turns : float
        Apparent turns, or parts of a turn where the plate looks the same after each; with less, a
        mark of colour may be the better one. Derived: no rate comes from less.
    whole : float
        Of the stated length; less was cut short.
    """

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
    by_luma = _track_or_refusal(task, _Pass(attempts=1))
    if _turns(by_luma):
        return by_luma
    if isinstance(by_luma, NothingMoves) and nothing_moves(task.path, on_progress):
        raise by_luma
    by_colour = _track_or_refusal(task, _Pass(colours=True))
    if _turns(by_colour):
        return by_colour
    if isinstance(by_luma, RateRefused):
        raise more_telling(by_luma, by_colour) if isinstance(by_colour, RateRefused) else by_luma
    return by_luma


@dataclass(frozen=True)
class _Task:
    """What to track, and whom to tell."""

    path: Path
    rim: PlateOverride | None
    on_progress: Callable[[int, int | None], None] | None


@dataclass(frozen=True)
class _Pass:
    """How the clip is read.

    Attributes
    ----------
    colours : bool
        With chroma, and with the luma reduced to its size.
    skipped : int
        Frames before the first stretch that is learned from.
    attempts : int
        Stretches in which a plate is looked for.
    camera_moves : bool
        The camera is known to.
    """

    colours: bool = False
    skipped: int = 0
    attempts: int = ATTEMPTS
    camera_moves: bool = False


def _turns(result: "PhaseTrack | RateRefused") -> "TypeGuard[PhaseTrack]":
    if isinstance(result, RateRefused):
        return False
    return result.apparent_turns * result.plate.symmetry >= THRESHOLDS.fewest_turns


def _track_or_refusal(task: _Task, way: _Pass) -> "PhaseTrack | RateRefused":
    try:
        return _tracked(task, way)
    except RateRefused as refusal:
        return refusal


def _tracked(task: _Task, way: _Pass) -> "PhaseTrack":
    with ClipReader(task.path, colours=way.colours) as clip:

        def on_frames(count: int) -> None:
            if task.on_progress is not None:
                task.on_progress(count, clip.frames_stated)

        from vision.tracking.frame_measurement import FrameMeasurements  # while frames are decoded

        batches = _after(way.skipped, clip)
        plate, stretch = _learn_plate(task, way, clip, batches, on_frames)
        shown = len(stretch.frames) // 2
        measurements = FrameMeasurements(plate, stretch.frames[shown], shown * stretch.stride)
        later_by_luma = way.colours and plate.by_brightness
        if stretch.stride == 1 and not later_by_luma:
            rest = _chain(stretch.frames, stretch.prepared(batches))
            track = _measured(measurements, clip, rest, stretch, on_frames)
        else:
            stretch.frames.clear()
    if later_by_luma:
        return _tracked(task, _Pass(skipped=stretch.skipped, attempts=1))
    if stretch.stride > 1:
        with ClipReader(task.path, colours=way.colours) as clip:
            rest = stretch.prepared(_after(stretch.skipped, clip))
            track = _measured(measurements, clip, rest, stretch, on_frames)
    if stretch.camera is None and not way.camera_moves and measurements.camera_moved:
        return _tracked(task, replace(way, camera_moves=True))
    return track


def _measured(
    measurements: "FrameMeasurements",
    clip: ClipReader,
    batches: Iterator[list[Frame]],
    stretch: Stretch,
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


def _learn_plate(
    task: _Task,
    way: _Pass,
    clip: ClipReader,
    batches: Iterator[list[Frame]],
    on_frames: Callable[[int], None],
) -> "tuple[PlateModel, Stretch]":
    """The plate, and the frames it was learned from."""
    from vision.plate.channel import channels
    from vision.plate.learn import learn

    rim = task.rim.view(clip.reduction) if task.rim else None
    skipped = way.skipped
    refusal: RateRefused | None = None
    for attempt in range(way.attempts):
        on_step = partial(on_frames, skipped)
        stretch = next_stretch(batches, skipped, on_step)
        if not stretch.frames:
            break
        if len(stretch.frames) < FEWEST and refusal is None:
            raise UnreadableVideo(
                f"{task.path}: {len(stretch.frames)} frame(s) found, at least {FEWEST} expected; a "
                f"rate needs a clip of the turning plate, at best a minute long."
            )
        stretch = stretch.with_fields().steadied(camera_moves=way.camera_moves)
        # The brightness of the first stretch was looked at before the clip was read with colours.
        seen = channels(stretch.frames, brightness=not way.colours or attempt > 0)
        try:
            plate = learn(task.path.name, stretch.frames, seen, rim, on_step,
                          camera_stands=stretch.camera_stands)
            return plate, stretch
        except RateRefused as error:
            refusal = more_telling(refusal, error)
            skipped += stretch.read
    raise refusal or UnreadableVideo(
        f"{task.path}: the file has a video stream, but not one frame could be decoded; copy it "
        f"from the camera again or convert it to H.264."
    )


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
