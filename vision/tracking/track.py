"""From a clip to the plate's angle in every frame, in one pass.

The first frames are kept until the plate has been found and learned from them; they and all that
follow are then measured as they come, so that memory does not grow with the clip. Where no plate is
in the brightness of one stretch of frames after the other, the clip is read with its colours. Where
a camera is so fast that the frames of a turn are too many to keep, some of them are learned from;
then, where the plate was found late, and where the camera is seen to move after that, the clip is
read again.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import reduce
from pathlib import Path
from typing import TYPE_CHECKING, TypeGuard

import cv2

from vision.errors import (
    NoSuchPart,
    NothingMoves,
    NothingRepeats,
    RateRefused,
    more_telling,
)
from vision.geometry import PlateOverride
from vision.tracking.evenness import scatter_rad
from vision.tracking.search import ClipPass, ClipTask, learned_plate
from vision.tracking.stretch import Stretch, next_stretch
from vision.video.reader import BATCH, ClipReader, Frame

if TYPE_CHECKING:
    from vision.phase_track import PhaseTrack
    from vision.tracking.frame_measurement import FrameMeasurements
    from vision.tracking.periodic_track import PictureReturn


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
    scatter_rad : float
        Scatter of the angles about an even rotation, rad, from which the return of the picture is
        measured too. Ten times that of a poor clip (``tests.bench.vision_films``).
    clearly : float
        Times the least scatter, with which a plate by its template comes before one by the return
        of the picture. Tuned on ``tests.bench.clip_study --only pulldown``.
    """

    fewest_turns: float = 1.0
    whole: float = 0.9
    scatter_rad: float = 0.0122
    clearly: float = 1.5


THRESHOLDS = ClipThresholds()


def track_phase(
    path: Path | str,
    *,
    plate: PlateOverride | None = None,
    from_s: float = 0.0,
    on_progress: Callable[[int, int | None], None] | None = None,
) -> "PhaseTrack":
    """Track the plate of a clip, by its colour where the brightness shows nothing that turns.

    Parameters
    ----------
    path : path
    plate : PlateOverride, optional
        The rim as the user measured it, instead of looking for it.
    from_s : float
        The plate is learned from what follows this time of the clip, s.
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
    task = ClipTask(Path(path), plate, from_s, on_progress)
    by_luma = _track_or_refusal(task, ClipPass())
    if _good(by_luma):
        return by_luma
    tracks, returned, picture = [by_luma], None, None
    if plate is None and not isinstance(by_luma, NothingMoves):
        picture = _returning(task)
        returned = _by_return(picture, by_luma)
    nothing = isinstance(by_luma, RateRefused) and isinstance(returned, NothingRepeats)
    if not _turns(by_luma) and not nothing and not _good(returned):
        tracks.append(_track_or_refusal(task, ClipPass(colours=True)))
    if isinstance(by_luma, NothingMoves) and isinstance(tracks[-1], RateRefused):
        raise by_luma  # nor does anything turn in the colours
    if plate is None and not _good(tracks[-1]):
        colour_turns = len(tracks) > 1 and _turns(tracks[-1])
        if returned is None or (colour_turns and isinstance(returned, RateRefused)):
            # A plate followed by its colour may know a view.
            returned = _by_return(picture or _returning(task), tracks[-1])
        tracks.append(returned)
    return _best(task.path.name, tracks)


def _best(name: str, tracks: "list[PhaseTrack | RateRefused]") -> "PhaseTrack":
    """The track that goes most evenly; without one a refusal that says what was seen."""
    turning = [track for track in tracks if _turns(track)]
    if turning:
        # Where the times scatter and not the angles, all tracks do alike.
        allowed = THRESHOLDS.clearly * min(map(scatter_rad, turning))
        return next(track for track in turning if scatter_rad(track) <= allowed)
    refusals = [track for track in tracks if isinstance(track, RateRefused)]
    returned = next((each for each in refusals if each.returns is not None), None)
    if returned is not None:
        raise _only_returns(name, returned)
    still = [track for track in tracks if not isinstance(track, RateRefused)]
    if still:
        return still[0]
    last = refusals.pop() if len(refusals) > 2 or isinstance(refusals[-1], NothingRepeats) else ""
    telling = reduce(more_telling, refusals)
    raise type(telling)(f"{telling} {last}".rstrip())


def _only_returns(name: str, refusal: RateRefused) -> RateRefused:
    """What to do where the picture returns, and no plate is seen."""
    assert refusal.returns is not None
    rate = refusal.returns.rate_rad_s
    sd = rate * refusal.returns.sd_s / refusal.returns.period_s
    return RateRefused(
        f"{name}: {refusal}. Film the whole plate from above, with one bold mark near its rim; "
        f"where it makes one turn in that time, and does not go to and fro, and this rate will do, "
        f"state it in a configuration (rate: {{{Path(name).stem}: {{rate_rad_s: {rate:.4f}, "
        f"sd_rad_s: {sd:.1g}}}}}).",
        returns=refusal.returns)


def _turns(result: "PhaseTrack | RateRefused") -> "TypeGuard[PhaseTrack]":
    if isinstance(result, RateRefused):
        return False
    return result.apparent_turns * result.plate.symmetry >= THRESHOLDS.fewest_turns


def _good(result: "PhaseTrack | RateRefused | None") -> "TypeGuard[PhaseTrack]":
    """Whether a plate was followed so well that no other way to its angle is looked for."""
    return result is not None and _turns(result) and scatter_rad(result) < THRESHOLDS.scatter_rad


def _track_or_refusal(task: ClipTask, way: ClipPass) -> "PhaseTrack | RateRefused":
    try:
        return _tracked(task, way)
    except NoSuchPart:
        raise
    except RateRefused as refusal:
        return refusal


def _by_return(
    picture: "PictureReturn | RateRefused", roughly: "PhaseTrack | RateRefused"
) -> "PhaseTrack | RateRefused":
    """A track by the return of the picture, with what a poor track of the plate tells of it."""
    if isinstance(picture, RateRefused):
        return picture
    try:
        return picture.track(roughly if _turns(roughly) else None)
    except RateRefused as refusal:
        return refusal


def _returning(task: ClipTask) -> "PictureReturn | RateRefused":
    from vision.tracking.periodic_track import picture_return

    def followed(clip: ClipReader) -> Iterator[list[Frame]]:
        count = 0
        for batch in clip:
            count += len(batch)
            if task.on_progress is not None:
                task.on_progress(count, clip.frames_stated)
            yield batch

    try:
        with ClipReader(task.path) as clip:
            batches = followed(clip)
            stretch = next_stretch(batches, 0, lambda: None).with_fields()
            stretch = stretch.steadied(camera_moves=False)
            if stretch.stride == 1:
                rest = _chain(stretch.frames, stretch.prepared(batches))
                return picture_return(clip, rest, _notes(clip, stretch))
        with ClipReader(task.path) as clip:
            rest = stretch.prepared(followed(clip))
            return picture_return(clip, rest, _notes(clip, stretch))
    except RateRefused as refusal:
        return refusal


def _tracked(task: ClipTask, way: ClipPass) -> "PhaseTrack":
    with ClipReader(task.path, colours=way.colours) as clip:

        def on_frames(count: int) -> None:
            if task.on_progress is not None:
                task.on_progress(count, clip.frames_stated)

        from vision.tracking.frame_measurement import FrameMeasurements  # while frames are decoded

        batches = iter(clip)
        plate, stretch = learned_plate(task, way, clip, batches, on_frames)
        shown = len(stretch.frames) // 2
        measurements = FrameMeasurements(
            plate, stretch.frames[shown], stretch.skipped + shown * stretch.stride, stretch.around)
        from_the_first = stretch.stride == 1 and stretch.skipped == 0
        if from_the_first:
            rest = _chain(stretch.frames, stretch.prepared(batches))
            track = _measured(measurements, clip, rest, stretch, on_frames)
        else:
            stretch.frames.clear()
    if not from_the_first:  # what was learned late is measured in all frames
        with ClipReader(task.path, colours=way.colours) as clip:
            track = _measured(measurements, clip, stretch.prepared(iter(clip)), stretch, on_frames)
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
    """The track of all frames in the batches."""
    for batch in batches:
        measurements.add(batch)
        on_frames(len(measurements))
    notes = _notes(clip, stretch)
    # By the time, not the count: containers without one state duration times frame rate.
    if clip.seconds_stated and measurements.last_s < THRESHOLDS.whole * clip.seconds_stated:
        notes += (
            f"The file states {clip.seconds_stated:.1f} s, {measurements.last_s:.1f} s could be "
            f"decoded: it is damaged or was cut short.",
        )
    return measurements.track(clip, notes)


def _notes(clip: ClipReader, stretch: Stretch) -> tuple[str, ...]:
    """What the user should know of how the frames were read."""
    notes = [part.note(clip.path.name) for part in (stretch.interlacing, stretch.camera) if part]
    if clip.orientation.mirrored:
        notes.insert(0,
            f"{clip.path.name}: the file has its frames displayed mirrored, as front cameras do. "
            f"The sense of rotation is that of the displayed frame; if writing in it reads "
            f"backwards, the plate itself turns the other way.")
    return tuple(notes)


def _chain(first: list[Frame], rest: Iterator[list[Frame]]) -> Iterator[list[Frame]]:
    """All frames in batches; the first are let go as they are handed on."""
    while first:
        yield first[:BATCH]
        del first[:BATCH]
    yield from rest
