"""The clips of an open session, each beside the logs of the poses on its plate."""

import csv
import math
from collections.abc import Sequence
from functools import partial
from pathlib import Path

import numpy as np

from calib.errors import CalibrationError
from calib.poses.imu_log import ImuLog
from pipeline.config.schema import VideoRateSection
from pipeline.config.sensor import sensor_specs
from pipeline.errors import PipelineError
from pipeline.export.apply import apply_results
from pipeline.results.read import load_results
from pipeline.stages.context import RunContext
from pipeline.stages.plate_settings import clips_to_follow
from pipeline.stages.rate import ClipToFollow, follow_clips
from pipeline.workbench.clip_player import ClipToPlay, PlateReading
from pipeline.workbench.live_refits import OpenSession
from vision.phase_track import PhaseTrack


def session_clips(session: OpenSession, folder: Path) -> list[ClipToPlay]:
    """The clips in the order of the configuration; ``folder`` has the results.

    A log stands on the clip's own clock where ``pipeline record`` has filmed its pose.
    """
    clips = []
    for name, section in session.config.rate.items():
        if not isinstance(section, VideoRateSection):
            continue
        logs = session.turning_logs("gyroscope", name)
        for i, clip in enumerate(clips_to_follow(section)):
            clips.append(ClipToPlay(
                name, clip.path, session.rates[name].clips[i],
                partial(followed_clip, clip, session.context), [log.label for log in logs],
                i if len(section.video) == len(logs) else 0,
                partial(_turning, session, folder, logs, clip.path)))
    return clips


def followed_clip(clip: ClipToFollow, context: RunContext) -> PhaseTrack:
    """The track of one clip, from the cache where it is known."""
    (track,) = follow_clips([clip], context)
    return track


def _turning(
    session: OpenSession, folder: Path, logs: Sequence[ImuLog], clip: Path, k: int
) -> PlateReading:
    """A log as the results correct it; by its data sheet where they do not say how."""
    spec, log = sensor_specs(session.config.sensor)["gyroscope"], logs[k]
    try:
        stored = load_results(folder, session.context.allow_python)
        vectors, how = apply_results(stored, log).triads["gyroscope"], "corrected as the file says"
    except (PipelineError, CalibrationError, KeyError):
        vectors, how = spec.nominal(log.gyroscope), "by its data sheet"
    return PlateReading(log.time_s, np.linalg.norm(vectors, axis=1), how, _begins_s(clip))


def _begins_s(clip: Path) -> float:
    """When a clip begins on the clock of the session's logs; NaN where it was not recorded so."""
    try:
        with clip.with_suffix(".times.csv").open(encoding="utf-8") as file:
            return float(next(csv.DictReader(file))["session_s"])
    except (OSError, ValueError, KeyError, TypeError, StopIteration, csv.Error):
        return math.nan
