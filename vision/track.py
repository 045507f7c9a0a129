"""From a film to the plate's angle in every picture, in one pass.

The first pictures are kept until the plate has been found and learned from them; they and all that
follow are then measured as they come, so that memory does not grow with the film.
"""

from collections.abc import Callable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from vision.annotate import annotate
from vision.errors import RateRefused, UnreadableVideo
from vision.follow import Follower
from vision.geometry import FloatArray, PlateOverride
from vision.learn import Learned, learn
from vision.mark import find_deck_mark, find_mark
from vision.phase_track import PhaseTrack
from vision.stillness import median_picture
from vision.video import BATCH, Film, Frame, Luma

FEWEST = 12  # pictures from which anything can be said
LEARN_FROM = 300  # pictures
LEARN_BYTES = 96_000_000
ATTEMPTS = 5  # stretches of the film in which a plate is looked for
THUMBNAIL = 20  # samples across the plate's surroundings, each way
DUPLICATE = 0.2  # of the usual change between pictures


def track_phase(
    path: Path | str,
    *,
    plate: PlateOverride | None = None,
    on_progress: Callable[[int, int | None], None] | None = None,
) -> PhaseTrack:
    """Follow the plate of a film.

    Parameters
    ----------
    path : path
    plate : PlateOverride, optional
        The rim as the user measured it, instead of looking for it.
    on_progress : callable (pictures done, pictures stated or None), optional
        Called often, also while the plate is being learned; what it raises ends the work.

    Raises
    ------
    UnreadableVideo
        Not a film, or fewer than a dozen pictures.
    RateRefused
        Nothing in the film turns about a fixed axis.
    """
    name = Path(path).name
    with Film(path) as film:
        batches = iter(film)
        skipped = 0
        refusal: RateRefused | None = None
        frames: list[Frame] = []
        found: Learned | None = None
        size = (0, 0)

        def on_step() -> None:
            if on_progress is not None:
                on_progress(skipped, film.frames_stated)

        for _ in range(ATTEMPTS):
            frames = _first(batches, on_step)
            if not frames:
                break
            if len(frames) < FEWEST and refusal is None:
                raise UnreadableVideo(
                    f"{path}: {len(frames)} picture(s) found, at least {FEWEST} expected; a rate "
                    f"needs a film of the turning plate, better of a minute."
                )
            try:
                given = plate.view(film.reduction) if plate else None
                found = learn(name, frames, given, on_step)
                break
            except RateRefused as error:
                refusal = refusal or error
                skipped += len(frames)
        if found is None:
            if refusal is not None:
                raise refusal
            raise UnreadableVideo(
                f"{path}: the file has a video stream, but not one picture could be decoded; "
                f"copy it from the camera again or convert it to H.264."
            )
        h, w = frames[0].luma.shape
        size = (w * film.reduction, h * film.reduction)
        rows = _Rows(found, frames)
        for samples in _ahead(_chain(frames, batches), rows.sample):
            rows.add(samples)
            if on_progress is not None:
                on_progress(skipped + len(rows.values), film.frames_stated)
        notes = list(found.notes)
        if skipped:
            notes.append(
                f"The plate was not seen turning in the first {skipped} pictures, which are "
                f"left out."
            )
        if film.frames_stated and skipped + len(rows.values) < 0.9 * film.frames_stated:
            notes.append(
                f"The file states {film.frames_stated} pictures, {skipped + len(rows.values)} "
                f"could be decoded: it is damaged or was cut short."
            )
        return rows.track(name, film, size, tuple(notes))


def _first(batches: Iterator[list[Frame]], on_step: Callable[[], None]) -> list[Frame]:
    frames: list[Frame] = []
    for batch in batches:
        on_step()
        frames += batch
        if len(frames) >= LEARN_FROM or len(frames) * frames[0].luma.nbytes > LEARN_BYTES:
            break
    return frames


def _chain(first: list[Frame], rest: Iterator[list[Frame]]) -> Iterator[list[Frame]]:
    while first:
        yield first[:BATCH]
        del first[:BATCH]
    yield from rest


@dataclass(frozen=True, eq=False)
class _Sample:
    """What is needed of a picture: along the rings, and in small."""

    time_s: float
    strip: Luma
    thumbnail: Luma


def _ahead(
    batches: Iterator[list[Frame]], sample: Callable[[list[Frame]], list[_Sample]]
) -> Iterator[list[_Sample]]:
    """The batches sampled in a thread of its own, one ahead of the one that is measured."""
    with ThreadPoolExecutor(1) as pool:
        waiting: Future[list[_Sample]] | None = None
        for batch in batches:
            coming = pool.submit(sample, batch)
            if waiting is not None:
                yield waiting.result()
            waiting = coming
        if waiting is not None:
            yield waiting.result()


@dataclass(frozen=True)
class _Row:
    time_s: float
    angle_rad: float
    quality: float
    seed_rad: float
    change: float
    thumbnail: Luma


class _Rows:
    """One row per picture, and what is needed to measure the next."""

    def __init__(self, found: Learned, frames: list[Frame]) -> None:
        self._found = found
        grid = found.template.grid
        self._mark = find_mark(found.template)
        self._follower = Follower(found.template, self._mark, found.rate_rad_s)
        x, y = grid.view.pixels(np.ones(90), np.linspace(0, 2 * np.pi, 90))
        h, w = frames[0].luma.shape
        self._columns, self._rows = _samples(x, w), _samples(y, h)
        self._still = median_picture([f.luma for f in frames])
        self._shown = frames[len(frames) // 2].luma
        self._shown_index = len(frames) // 2
        self.values: list[_Row] = []

    def sample(self, batch: list[Frame]) -> list[_Sample]:
        grid = self._found.template.grid
        return [
            _Sample(f.time_s, grid.strip(f.luma), f.luma[self._rows, self._columns].ravel())
            for f in batch
        ]

    def add(self, samples: list[_Sample]) -> None:
        for each in samples:
            angle, quality, seed, change = self._follower.angle(each.time_s, each.strip)
            self.values.append(_Row(each.time_s, angle, quality, seed, change, each.thumbnail))

    def track(
        self, name: str, film: Film, size: tuple[int, int], notes: tuple[str, ...]
    ) -> PhaseTrack:
        grid = self._found.template.grid
        phase = _column(self.values, "angle_rad")
        change = _column(self.values, "change")
        mark, resting = self._mark, grid.view.at_rest
        deck = find_deck_mark(self._still, resting)
        at = None
        if mark is not None:
            at = (mark.radius, mark.azimuth_rad + phase[self._shown_index])
        track = PhaseTrack(
            source=name,
            time_s=_column(self.values, "time_s"),
            phase_rad=_wrapped(phase),
            seed_rad=_wrapped(_column(self.values, "seed_rad")),
            quality=_column(self.values, "quality"),
            duplicate=change < DUPLICATE * np.median(change),
            thumbnail=np.stack([row.thumbnail for row in self.values]),
            symmetry=self._found.symmetry,
            mark_rad=np.nan if mark is None else mark.azimuth_rad,
            mark_radius=np.nan if mark is None else mark.radius,
            deck_mark_rad=np.nan if deck is None else deck[1],
            deck_mark_radius=np.nan if deck is None else deck[0],
            view=grid.view.matrix,
            size_px=size,
            reduction=film.reduction,
            explained=self._found.template.explained,
            fps_stated=film.fps_stated,
            annotated=annotate(
                self._shown, resting, (float(grid.radius[0]), float(grid.radius[-1])), at, deck
            ),
            notes=notes,
        )
        # The template holds for the row of the spindle; every picture is stamped for its own mark.
        turned_on = grid.view.lag_rad_px * track.mark_row_px(phase)
        return replace(
            track,
            phase_rad=_wrapped(phase + turned_on),
            seed_rad=_wrapped(track.seed_rad + turned_on),
        )


def _samples(reach: FloatArray, size: int) -> slice:
    """Evenly spaced pixels across the plate, one coordinate."""
    low, high = max(0, int(reach.min())), min(size, int(reach.max()) + 1)
    return slice(low, high, max(1, (high - low) // THUMBNAIL))


def _column(rows: list[_Row], name: str) -> FloatArray:
    return np.array([getattr(row, name) for row in rows], float)


def _wrapped(angle_rad: FloatArray) -> FloatArray:
    return np.asarray(np.angle(np.exp(1j * angle_rad)))
