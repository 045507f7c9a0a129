"""The rate of one plate setting: its clips are tracked, and each gives a rate.

This module knows no configuration: ``pipeline rate`` measures clips without one, and its time
should be that of decoding, not of imports.
"""

import tempfile
import threading
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from datetime import date
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from calib.numbers import RPM
from calib.poses.reference import PlateRate
from pipeline.cameras import CameraClock
from pipeline.files import write_whole
from pipeline.stages.context import RunContext

if TYPE_CHECKING:
    from vision.geometry import PlateOverride
    from vision.phase_track import PhaseTrack
    from vision.rate.measure import RateMeasurement
    from vision.rate.steady_part import ClipPart
    from vision.rate.timebase import Timebase

#: Clips tracked at the same time. The decoder uses threads itself; more clips gain nothing.
PARALLEL_CLIPS = 2


@dataclass(frozen=True, eq=False)
class SettingRate:
    """The rate of one plate setting.

    Parameters
    ----------
    name : str
        Its key under ``rate:``.
    plate : PlateRate
        What the gyroscope is measured against: one rate, or one for each clip.
    sources : tuple of str
        What the clips are called; empty where the rate was stated.
    clips : tuple of RateMeasurement
        What was measured in each of them.
    annotated : tuple of array of uint8, shape (b,)
        A PNG of one frame of each clip, with plate, centre and marks drawn in.
    timebase : Timebase or None
        The clock of the clips; None where the rate was stated.
    """

    name: str
    plate: PlateRate
    sources: tuple[str, ...]
    clips: "tuple[RateMeasurement, ...]"
    annotated: tuple[NDArray[np.uint8], ...] = ()
    timebase: "Timebase | None" = None

    def __repr__(self) -> str:
        turns = self.plate.direction
        return (f"{self.rate_rad_s:.7g} rad/s ± {self.sd_rad_s:.2g} "
                f"({self.rate_rad_s / RPM:.6g} rpm{f', {turns}' if turns else ''})")

    @property
    def rate_rad_s(self) -> float:
        """Mean rate over the clips, positive."""
        return float(self.plate.rate_rad_s.mean())

    @property
    def signed_rad_s(self) -> float:
        """The mean rate, negative clockwise."""
        return -self.rate_rad_s if self.plate.direction == "cw" else self.rate_rad_s

    @property
    def image_sd_rad_s(self) -> float:
        """Sd of the mean rate without the clock's."""
        sd = self.plate.sd_rad_s
        return float(np.sqrt((sd**2).sum()) / len(sd))

    @property
    def timebase_sd_rad_s(self) -> float:
        """Sd of the mean rate by the camera's clock, which all clips share."""
        return self.rate_rad_s * self.plate.timebase_relative

    @property
    def sd_rad_s(self) -> float:
        """Sd of the mean rate, all parts together."""
        return float(np.hypot(self.image_sd_rad_s, self.timebase_sd_rad_s))

    @property
    def warnings(self) -> tuple[str, ...]:
        """Warnings about the clips, a paragraph each."""
        return tuple(warning for clip in self.clips for warning in clip.warnings)


@dataclass(frozen=True)
class ClipToFollow:
    """A clip, the plate's ellipse where the user states it, and the start of learning, s."""

    path: Path
    plate: "PlateOverride | None" = None
    from_s: float = 0.0


def follow_clips(clips: Sequence[ClipToFollow], context: RunContext) -> "list[PhaseTrack]":
    """Track the plate in each clip, several clips at a time; known clips come from the cache.

    Parameters
    ----------
    clips : sequence of ClipToFollow
    context : RunContext
        The cache and the progress display.

    Returns
    -------
    list of PhaseTrack
        In the order of ``clips``.

    Raises
    ------
    UnreadableInput, UnreadableVideo, RateRefused
        Of the first clip, in their order, that cannot be tracked.
    """
    if not clips:
        return []  # and nothing of the vision stage is imported
    stop = threading.Event()

    def follow(clip: ClipToFollow) -> "PhaseTrack":
        from vision.tracking.track import track_phase  # OpenCV, which known clips do not need

        def on_progress(done: int, stated: int | None) -> None:
            if stop.is_set():  # another clip was refused, or Ctrl-C: end this thread too
                raise KeyboardInterrupt
            context.on_progress(clip.path.name, done, stated)

        return track_phase(
            clip.path, plate=clip.plate, from_s=clip.from_s, on_progress=on_progress)

    def find(clip: ClipToFollow) -> "PhaseTrack":
        if context.cache is None:
            return follow(clip)
        from pipeline.stages.track_cache import kept_track, track_key

        key = track_key(clip.path, clip.plate, clip.from_s)
        return kept_track(context.cache, key, lambda: follow(clip))

    with ThreadPoolExecutor(PARALLEL_CLIPS) as pool:
        waiting = [pool.submit(find, clip) for clip in clips]
        try:
            return [one.result() for one in waiting]
        finally:
            stop.set()
            pool.shutdown(cancel_futures=True)


def measure_setting(
    name: str,
    tracks: "Sequence[PhaseTrack]",
    timebase: "Timebase",
    nominal_rpm: float | None = None,
    model: Sequence[str] = ("constant_rate",),
    part: "ClipPart | None" = None,
) -> SettingRate:
    """Measure the rate of a plate setting from the phase tracks of its clips.

    Parameters
    ----------
    name : str
        Of the setting, for messages.
    tracks : sequence of PhaseTrack
        One for each clip.
    timebase : Timebase
        Which clock the rates are measured against, and its sd.
    nominal_rpm : float, optional
        Chooses among rates that look the same in the clip.
    model : sequence of str
        Terms of the phase track.
    part : ClipPart, optional
        What of each clip is measured; by default what turns steadily.

    Raises
    ------
    RateRefused
        The rate of a clip cannot be determined, or the clips turn in both directions.
    """
    from vision.errors import RateRefused
    from vision.rate.measure import measure_rate
    from vision.rate.steady_part import WHOLE

    clips = tuple(
        measure_rate(track, timebase=timebase, nominal_rpm=nominal_rpm, model=model,
                     part=part or WHOLE)
        for track in tracks
    )
    ways = {clip.direction for clip in clips}
    if len(ways) > 1:
        odd = next(i for i, clip in enumerate(clips) if clip.direction != clips[0].direction)
        raise RateRefused(
            f"rate.{name}: {tracks[0].source} turns {clips[0].direction} and {tracks[odd].source} "
            f"turns {clips[odd].direction}; one direction is expected in a plate setting. Give "
            f"each direction an entry of its own under `rate:`."
        )
    plate = PlateRate(
        name=name,
        rate_rad_s=np.array([clip.rate_rad_s for clip in clips]),
        sd_rad_s=np.array([clip.uncertainty.image_rad_s for clip in clips]),
        timebase_relative=timebase.ppm * 1e-6,
        direction=clips[0].direction,
    )
    return SettingRate(
        name,
        plate,
        sources=tuple(track.source for track in tracks),
        clips=clips,
        annotated=tuple(track.annotated for track in tracks),
        timebase=timebase,
    )


def camera_timebase(clock: CameraClock, clips: Sequence[Path]) -> "Timebase":
    """The time base of clips by a camera whose clock was measured.

    Its quartz aged between the day of the measurement and that of the clips.
    """
    from vision.rate.timebase import Timebase

    days = [date.fromtimestamp(clip.stat().st_mtime) for clip in clips if clip.exists()]
    ppm = max((clock.sd_on(day) for day in days), default=clock.sd_ppm)
    return Timebase(ppm=ppm, fast_ppm=clock.fast_ppm, camera=clock.name)


def draw_overlay(
    clip: Path,
    track: "PhaseTrack",
    rate: SettingRate | None,
    target: Path,
    on_progress: Callable[[str, int, int | None], None],
) -> None:
    """Write the clip with its measurement drawn on it, whole or not at all.

    Parameters
    ----------
    clip : Path
    track : PhaseTrack
        Of this clip.
    rate : SettingRate or None
        Measured from this clip alone; None where it was refused.
    target : Path
        An .mp4.
    on_progress : callable (name, frames done, frames in all)

    Raises
    ------
    UnwritableOverlay, UnwritableOutput
        The clip cannot be encoded or written.
    """
    from vision.overlay import write_overlay

    with tempfile.TemporaryDirectory(prefix="pipeline-") as folder:
        drawn = Path(folder) / target.name
        write_overlay(clip, track, None if rate is None else rate.clips[0], drawn,
                      partial(on_progress, target.name))
        write_whole(target, drawn.read_bytes())
