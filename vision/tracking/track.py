"""From a clip to the plate's angle in every frame, in one pass.

The first frames are kept until the plate has been found and learned from them; they and all later
frames are then measured in order, so that memory does not grow with the clip. If the brightness of
the first frames that move shows no plate, the return of the picture is searched in small frames,
taken meanwhile, and the clip is read with its colours. If a camera is so fast that the
frames of a turn are too many to keep, some of them are used for learning; then, if the plate was
found late, and if the camera moves after that, the clip is read again.
"""

from collections.abc import Callable, Iterator
from functools import cached_property, partial
from pathlib import Path
from typing import TYPE_CHECKING

import cv2

from vision.errors import (
    NoPlate,
    NoSuchPart,
    NothingMoves,
    OnlyLight,
    RateRefused,
    TooShortToReturn,
)
from vision.geometry import PlateOverride
from vision.tracking.best_track import best_track, has_turns, is_even, is_explained, is_good
from vision.tracking.search import ClipTask, learned_plate
from vision.tracking.small_clip import SmallClip
from vision.tracking.stretch import Stretch
from vision.video.reader import BATCH, ClipReader, Frame

if TYPE_CHECKING:
    from vision.phase_track import PhaseTrack
    from vision.tracking.frame_measurement import FrameMeasurements
    from vision.tracking.periodic_track import PictureReturn


WHOLE = 0.9  #: share of the stated length below which a clip was cut short; a judgement


def track_phase(
    path: Path | str,
    *,
    plate: PlateOverride | None = None,
    from_s: float = 0.0,
    on_progress: Callable[[int, int | None], None] | None = None,
) -> "PhaseTrack":
    """Track the plate of a clip, by its colour if the brightness shows no rotation.

    Parameters
    ----------
    path : path
    plate : PlateOverride, optional
        The rim as measured by the user, instead of a search.
    from_s : float
        Time of the clip from which the plate is learned, s.
    on_progress : callable (frames done, frames stated or None), optional
        Called often, also while the plate is being learned; an exception ends the work.

    Returns
    -------
    PhaseTrack
        Angles in rad, times in s, of shape (f,).

    Raises
    ------
    UnreadableVideo
        The file is not a clip, or has fewer than a dozen frames.
    RateRefused
        Nothing in the clip turns about a fixed axis, in brightness or in colour.
    """
    cv2.setNumThreads(1)  # the other cores decode
    task = ClipTask(Path(path), plate, from_s, on_progress)
    attempts = _Attempts(task)
    by_luma = attempts.tracked()
    if is_good(by_luma):
        return by_luma
    tracks, returned = [by_luma], None
    if plate is None and not isinstance(by_luma, NothingMoves):
        returned = attempts.by_return(by_luma)
    nothing = (isinstance(returned, NoPlate) and not isinstance(returned, TooShortToReturn)
               and not is_explained(by_luma))
    if not is_even(by_luma) and not nothing and not is_good(returned):
        tracks.append(attempts.tracked(colours=True))
    if isinstance(by_luma, NothingMoves):
        # The colours show no rotation either, or only that of the light's bands.
        by_colour = tracks[-1]
        if isinstance(by_colour, RateRefused) or (
                isinstance(by_luma, OnlyLight) and not is_explained(by_colour)):
            raise by_luma
    if plate is None and not is_good(tracks[-1]):
        colour_turns = len(tracks) > 1 and has_turns(tracks[-1])
        if returned is None or (colour_turns and isinstance(returned, RateRefused)):
            # A plate tracked by its colour may supply a view.
            returned = attempts.by_return(tracks[-1])
        tracks.append(returned)
    return best_track(task.path.name, tracks)


class _Attempts:
    """Attempts on a clip, and its small frames from the first one that found no plate."""

    def __init__(self, task: ClipTask) -> None:
        self._task = task
        self._small: SmallClip | None = None

    def tracked(self, *, colours: bool = False) -> "PhaseTrack | RateRefused":
        """The track of a plate by its template, or its refusal."""
        try:
            return self._tracked(colours)
        except NoSuchPart:
            raise
        except RateRefused as refusal:
            return refusal.with_traceback(None)  # which keeps frames in memory

    def by_return(self, roughly: "PhaseTrack | RateRefused") -> "PhaseTrack | RateRefused":
        """The track by the return of the picture, with the view of a poor track of the plate."""
        try:
            picture = self._picture
            notes = _notes(picture.small.clip)
            return picture.track(roughly if has_turns(roughly) else None, notes)
        except RateRefused as refusal:
            return refusal

    @cached_property
    def _picture(self) -> "PictureReturn":
        from vision.tracking.periodic_track import picture_return

        if self._small is None:
            with ClipReader(self._task.path) as clip:
                self._small = SmallClip(clip)
                self._read_on(self._small, self._small.followed(clip))
        return picture_return(self._small)

    def _read_on(self, small: SmallClip, batches: Iterator[list[Frame]]) -> None:
        """Read the rest of the clip for its small frames."""
        while not small.ended and next(batches, None) is not None:
            self._task.report(small.clip, len(small.time_s))

    def _tracked(self, colours: bool, camera_moves: bool = False) -> "PhaseTrack":
        task = self._task
        with ClipReader(task.path, colours=colours) as clip:
            from vision.tracking.frame_measurement import FrameMeasurements  # while it is decoded

            small = SmallClip(clip, ended=colours or task.rim is not None)
            batches, on_frames = small.followed(clip), partial(task.report, clip)
            try:
                plate, stretch = learned_plate(
                    task, clip, batches, on_frames, colours=colours, camera_moves=camera_moves)
            except RateRefused as refusal:
                if not small.ended and not isinstance(refusal, NothingMoves):
                    self._small = small
                    self._read_on(small, batches)
                raise
            small.end()
            measurements = FrameMeasurements(plate, stretch)
            from_the_first = stretch.stride == 1 and stretch.skipped == 0
            if from_the_first:
                rest = _chain(stretch.frames, stretch.prepared(batches))
                track = _measured(measurements, clip, rest, stretch, on_frames)
            else:
                stretch.frames.clear()
        if not from_the_first:  # a plate that was learned late is measured in all frames
            with ClipReader(task.path, colours=colours) as clip:
                rest = stretch.prepared(iter(clip))
                track = _measured(measurements, clip, rest, stretch, partial(task.report, clip))
        if stretch.camera is None and not camera_moves and measurements.camera_moved:
            return self._tracked(colours, camera_moves=True)
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
    if clip.seconds_stated and measurements.last_s < WHOLE * clip.seconds_stated:
        notes += (
            f"The file states {clip.seconds_stated:.1f} s, {measurements.last_s:.1f} s could be "
            f"decoded: it is damaged or was cut short.",
        )
    return measurements.track(clip, notes)


def _notes(clip: ClipReader, stretch: Stretch | None = None) -> tuple[str, ...]:
    """Notes for the user on the reading of the frames."""
    notes = []
    if clip.orientation.mirrored:
        notes.append(
            f"{clip.path.name}: the file has its frames displayed mirrored, as front cameras do. "
            f"The sense of rotation is that of the displayed frame; if writing in it reads "
            f"backwards, the plate itself turns the other way.")
    if stretch is not None and stretch.interlacing is not None:
        notes.append(stretch.interlacing.note(clip.path.name))
    if stretch is not None and stretch.camera is not None:
        notes.append(stretch.camera.note(clip.path.name, clip.reduction))
    return tuple(notes)


def _chain(first: list[Frame], rest: Iterator[list[Frame]]) -> Iterator[list[Frame]]:
    """All frames in batches; the first ones are released as they are passed on."""
    while first:
        yield first[:BATCH]
        del first[:BATCH]
    yield from rest
