"""Clips that play with rim, mark and angle drawn on them, on one time axis with a gyroscope.

No browser plays every format that cameras write, and each frame has its own time: a clip is decoded
once on demand, into pictures that the page shows one after another.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from threading import Lock

import numpy as np
from starlette.requests import Request
from starlette.responses import JSONResponse, Response
from starlette.routing import BaseRoute, Route

from calib.numbers import RPM
from calib.poses.imu_log import FloatArray
from pipeline.errors import ConfigError
from pipeline.results.json_values import Json
from pipeline.served.serve import answering, beside
from vision.overlay import StillFrame, still_frames
from vision.phase_track import PhaseTrack
from vision.rate.measure import RateMeasurement

WIDTH_PX = 640  #: width of a picture; layout
MOST_PICTURES = 1800  #: limit of memory, some 30 MB: a minute at 30 frames per second
KEPT_CLIPS = 2  #: number of clips whose pictures are kept. Chosen
DRAWN = 600  #: number of points of a line, more than its pixels; layout


@dataclass(frozen=True, eq=False)
class PlateReading:
    """Readings of a gyroscope on the plate.

    Attributes
    ----------
    time_s : array, shape (t,)
    rate_rad_s : array, shape (t,)
        Length of its vector.
    how : str
        What it was corrected by.
    begins_s : float
        When the clip begins on its clock; NaN where the two clocks have nothing in common.
    """

    time_s: FloatArray
    rate_rad_s: FloatArray
    how: str
    begins_s: float


@dataclass(frozen=True, eq=False)
class ClipToPlay:
    """A clip, its measurement, and the logs that can be shown with it.

    Attributes
    ----------
    setting : str
        The plate's setting that it shows.
    path : Path
    rate : RateMeasurement
    track : callable
        Gives its track.
    logs : sequence of str
        Names of the logs.
    log : int
        The one of its own pose; 0 where all of them are of one setting.
    turning : callable
        Gives what the gyroscope reads in one of them.
    """

    setting: str
    path: Path
    rate: RateMeasurement
    track: Callable[[], PhaseTrack]
    logs: Sequence[str]
    log: int
    turning: Callable[[int], PlateReading]


class ClipPlayer:
    """Plays the clips that ``clips`` returns, always the same ones in the same order."""

    def __init__(self, clips: Callable[[], Sequence[ClipToPlay]]) -> None:
        self._clips = clips
        self._pictures: dict[tuple[Path, float], list[StillFrame]] = {}
        self._lock = Lock()
        self.routes: list[BaseRoute] = [
            answering("/clips", self._listed), answering("/clip", self.course),
            Route("/clip/{number:int}/{picture:int}", self._picture),
        ]

    def _listed(self, _: Json) -> Json:
        return {"clips": [
            {"number": i, "setting": clip.setting, "name": clip.path.name,
             "logs": list(clip.logs), "log": clip.log} for i, clip in enumerate(self._clips())]}

    def course(self, question: Json) -> Json:
        """The pictures' times, and the rates by the clip and by a gyroscope, in rpm.

        Raises
        ------
        ConfigError
            There is no such clip or log.
        """
        clip, log = self._clip(question.get("number")), question.get("log")
        if log is not None and not (isinstance(log, int) and 0 <= log < len(clip.logs)):
            raise ConfigError("there is no such log; load the page again.")
        history, rate = clip.rate.history, clip.rate
        known = np.isfinite(history.rate_so_far_rad_s)
        return {
            "pictures": [picture.time_s for picture in self._pictures_of(clip)],
            "rpm": rate.rate_rad_s / RPM, "sd": rate.sd_rad_s / RPM,
            "so_far": _line(history.angle.time_s[known], history.rate_so_far_rad_s[known]),
            "turns": _line(history.time_s, np.abs(history.rate_rad_s)),
            "gyroscope": None if log is None else _beside(clip.turning(log)),
        }

    def _clip(self, number: object) -> ClipToPlay:
        clips = self._clips()
        if not isinstance(number, int) or not 0 <= number < len(clips):
            raise ConfigError("there is no such clip; load the page again.")
        return clips[number]

    def _pictures_of(self, clip: ClipToPlay) -> list[StillFrame]:
        try:
            key = clip.path, clip.path.stat().st_mtime
        except OSError as error:
            raise ConfigError(f"{clip.path.name}: cannot be read ({error.strerror}).") from error
        with self._lock:
            if key not in self._pictures:
                pictures = still_frames(
                    clip.path, clip.track(), clip.rate, WIDTH_PX, MOST_PICTURES)
                for old in list(self._pictures)[:-KEPT_CLIPS + 1 or None]:
                    del self._pictures[old]
                self._pictures[key] = pictures
            return self._pictures[key]

    async def _picture(self, request: Request) -> Response:
        number, picture = (request.path_params[key] for key in ("number", "picture"))
        pictures = await beside(lambda: self._pictures_of(self._clip(number)))
        if picture >= len(pictures):
            return JSONResponse({"error": "there is no such picture"}, 404)
        return Response(pictures[picture].jpeg, media_type="image/jpeg")


def _beside(turning: PlateReading) -> Json:
    """The gyroscope on the clip's time axis, and whether the two share a clock."""
    shared = bool(np.isfinite(turning.begins_s))
    begins = turning.begins_s if shared else turning.time_s[0]
    return _line(turning.time_s - begins, turning.rate_rad_s) | {
        "how": turning.how, "one_clock": shared}


def _line(time_s: FloatArray, rate_rad_s: FloatArray) -> Json:
    """Times and rpm, means of equal numbers of values, without values that were not logged."""
    known = np.isfinite(rate_rad_s)
    time_s, rate_rad_s = time_s[known], rate_rad_s[known]
    n = len(time_s)
    edges = np.unique(np.linspace(0, n, min(n, DRAWN) + 1).astype(int))
    counts = np.diff(edges)
    time, rate = ((np.add.reduceat(values, edges[:-1]) / counts).tolist() if n else []
                  for values in (time_s, rate_rad_s / RPM))
    return {"time_s": time, "rpm": rate}
