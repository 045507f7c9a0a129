"""From a clip to the rate of its plate in one call, for notebooks and other programs."""

from collections.abc import Sequence
from pathlib import Path
from typing import Literal

from vision.rate.measure import RateMeasurement
from vision.rate.measure import measure_rate as rate_of_track
from vision.rate.steady_part import ClipPart
from vision.rate.terms import CONSTANT_RATE
from vision.rate.timebase import CLOCK_PPM, Timebase
from vision.tracking.track import track_phase


def measure_rate(
    clip: Path | str,
    *,
    nominal_rpm: float | None = None,
    fps: float | None = None,
    ppm: float | None = None,
    model: Sequence[str] = (CONSTANT_RATE,),
    part: tuple[float | None, float | None] = (None, None),
) -> RateMeasurement:
    """Measure the rate of the plate in a clip.

    Parameters
    ----------
    clip : path
        A video file of the turning plate, filmed from above.
    nominal_rpm : float, optional
        Expected rate; chooses among rates that give the same frames.
    fps : float, optional
        Frames per second while filming, to replace the file's time stamps.
    ppm : float, optional
        Sd of the clock that stamps the frames, parts per million.
    model : sequence of str
        ``constant_rate`` and any of ``vision.rate.terms.TERMS``.
    part : (from_s, to_s)
        Seconds of the clip that are measured; None is its beginning or its end. By default the
        whole clip, or its steady part between the motor's start and stop.

    Returns
    -------
    RateMeasurement
        ``rate_rad_s``, ``uncertainty.total_rad_s``, ``direction`` and everything behind them.

    Raises
    ------
    UnreadableVideo
        The file is not a clip.
    RateRefused
        Nothing in the clip turns steadily about a fixed axis.
    """
    source: Literal["container", "constant"] = "container" if fps is None else "constant"
    timebase = Timebase(source, fps, CLOCK_PPM[source] if ppm is None else ppm)
    return rate_of_track(
        track_phase(clip),
        timebase=timebase,
        nominal_rpm=nominal_rpm,
        model=model,
        part=ClipPart(*part),
    )
