"""From a clip to the plate's angle in every frame, in one pass.

The first frames are kept until the plate has been found and learned from them; they and all that
follow are then measured as they come, so that memory does not grow with the clip. Where a camera is
so fast that the frames of a turn are too many to keep, some of them are learned from and the clip
is read again.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, TypeGuard

import cv2

from vision.errors import RateRefused, UnreadableVideo
from vision.geometry import PlateOverride
from vision.video import BATCH, ClipReader, Frame

if TYPE_CHECKING:
    from vision.phase_track import PhaseTrack
    from vision.plate.learn import PlateModel
    from vision.tracking.frame_measurement import FrameMeasurements

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
    """Follow the plate of a clip, by its colour where the brightness shows nothing that turns.

    Parameters
    ----------
    path : path
    plate : PlateOverride, optional
        The rim as the user measured it, instead of looking for it.
    on_progress : callable (frames done, frames stated or None), optional
        Called often, also while the plate is being learned; what it raises ends the work.

    Raises
    ------
    UnreadableVideo
        Not a clip, or fewer than a dozen frames.
    RateRefused
        Nothing in the clip turns about a fixed axis, in brightness or in colour.
    """
    cv2.setNumThreads(1)  # the other cores decode
    by_luma = _tried(path, plate, on_progress, colours=False)
    if _turns(by_luma):
        return by_luma
    by_colour = _tried(path, plate, on_progress, colours=True)
    if _turns(by_colour):
        return by_colour
    if isinstance(by_luma, RateRefused):
        raise by_luma
    return by_luma


def _turns(found: "PhaseTrack | RateRefused") -> "TypeGuard[PhaseTrack]":
    return not isinstance(found, RateRefused) and found.apparent_turns >= THRESHOLDS.fewest_turns


def _tried(
    path: Path | str,
    plate: PlateOverride | None,
    on_progress: Callable[[int, int | None], None] | None,
    *,
    colours: bool,
) -> "PhaseTrack | RateRefused":
    try:
        return _followed(path, plate, on_progress, colours=colours)
    except RateRefused as refusal:
        return refusal


def _followed(
    path: Path | str,
    plate: PlateOverride | None,
    on_progress: Callable[[int, int | None], None] | None,
    *,
    colours: bool,
) -> "PhaseTrack":
    with ClipReader(path, colours=colours) as clip:

        def on_frames(images: int) -> None:
            if on_progress is not None:
                on_progress(images, clip.frames_stated)

        from vision.tracking.frame_measurement import FrameMeasurements

        batches = iter(clip)
        found, first, skipped = _find(path, clip, batches, plate, on_frames)
        shown = len(first.images) // 2
        rows = FrameMeasurements(found, first.images[shown], shown * first.stride)
        if first.stride == 1:
            return _measured(rows, clip, _chain(first.images, batches), skipped, on_frames)
        first.images.clear()
    with ClipReader(path, colours=colours) as clip:
        return _measured(rows, clip, _after(skipped, clip), skipped, on_frames)


def _measured(
    rows: "FrameMeasurements",
    clip: ClipReader,
    batches: Iterator[list[Frame]],
    skipped: int,
    on_frames: Callable[[int], None],
) -> "PhaseTrack":
    """The track of all frames in the batches, the first ``skipped`` of the clip left out."""
    for batch in batches:
        rows.add(batch)
        on_frames(skipped + len(rows))
    name = clip.path.name
    notes = []
    if skipped:
        notes.append(
            f"The plate was not seen turning in the first {skipped} frames, which are left out."
        )
    if clip.orientation.mirrored:
        notes.append(
            f"{name}: the file has its frames shown mirrored, as front cameras do, and the sense "
            f"of rotation is that of the displayed frame. If writing in it reads backwards, the "
            f"plate itself turns the other way."
        )
    # By the time, not the count: containers without one state duration times frame rate.
    if clip.seconds_stated and rows.last_s < THRESHOLDS.whole * clip.seconds_stated:
        notes.append(
            f"The file states {clip.seconds_stated:.1f} s, {rows.last_s:.1f} s could be decoded: "
            f"it is damaged or was cut short."
        )
    return rows.track(clip, tuple(notes))


@dataclass(frozen=True, eq=False)
class _Stretch:
    """Frames to learn from: every ``stride``-th of those ``taken`` from the clip."""

    images: list[Frame]
    stride: int
    taken: int


def _find(
    path: Path | str,
    clip: ClipReader,
    batches: Iterator[list[Frame]],
    plate: PlateOverride | None,
    on_frames: Callable[[int], None],
) -> "tuple[PlateModel, _Stretch, int]":
    """The plate, the frames it was learned from, and how many were in vain before them."""
    from vision.plate.learn import learn

    given = plate.view(clip.reduction) if plate else None
    skipped = 0
    refusal: RateRefused | None = None
    for _ in range(ATTEMPTS):
        first = _first(batches, partial(on_frames, skipped))
        frames = first.images
        if not frames:
            break
        if len(frames) < FEWEST and refusal is None:
            raise UnreadableVideo(
                f"{path}: {len(frames)} frame(s) found, at least {FEWEST} expected; a rate "
                f"needs a clip of the turning plate, better of a minute."
            )
        try:
            found = learn(Path(path).name, frames, given, partial(on_frames, skipped))
            return found, first, skipped
        except RateRefused as error:
            refusal = refusal or error
            skipped += first.taken
    raise refusal or UnreadableVideo(
        f"{path}: the file has a video stream, but not one frame could be decoded; copy it from "
        f"the camera again or convert it to H.264."
    )


def _first(batches: Iterator[list[Frame]], on_step: Callable[[], object]) -> _Stretch:
    frames: list[Frame] = []
    taken = 0
    stride = 1
    for batch in batches:
        on_step()
        frames += batch[-taken % stride :: stride]
        taken += len(batch)
        span_s = frames[-1].time_s - frames[0].time_s
        fewest, most = LEARN_FROM
        if len(frames) >= fewest and span_s >= THRESHOLDS.learn_for_s:
            break
        if len(frames) >= most or len(frames) * frames[0].nbytes > LEARN_BYTES:
            if span_s >= THRESHOLDS.fast_s:
                break
            frames, stride = frames[::2], 2 * stride
    return _Stretch(frames, stride, taken)


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
