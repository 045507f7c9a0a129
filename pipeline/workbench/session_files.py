"""The files of an open session, and its clips, each beside the logs of the poses on its plate."""

import csv
import hashlib
import json
import math
import re
import shlex
from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from calib.errors import CalibrationError
from calib.poses.imu_log import ImuLog
from pipeline.config.load import Config, load_config
from pipeline.config.schema import VideoRateSection
from pipeline.config.sensor import sensor_specs
from pipeline.config.session import named_files
from pipeline.errors import ConfigError, PipelineError
from pipeline.export.apply import apply_results
from pipeline.results.names import REPORT_NAME, RESULTS_NAME
from pipeline.results.read import load_results
from pipeline.stages.context import RunContext
from pipeline.stages.plate_settings import clips_to_follow
from pipeline.stages.rate import ClipToFollow, follow_clips
from pipeline.text.names import program_version
from pipeline.workbench.clip_player import ClipToPlay, PlateReading
from pipeline.workbench.live_refits import OpenSession
from vision.phase_track import PhaseTrack

OF_THE_SCREEN = frozenset({"model", "exclude"})  #: keys that the screen writes
Stamp = Mapping[str, str]
_NAMED = re.compile(r'"config": ?("(?:[^"\\]|\\.)*")')
"""The configuration in a report as its commands name it, in JSON."""


class SessionFiles:
    """The configuration ``path``, the files that it names, and the folder of its results."""

    def __init__(self, path: Path, folder: Path) -> None:
        self.path, self.folder = path, folder
        self._of_config: tuple[str, str, list[Path]] = "", "", []

    def stamp(self) -> Stamp:
        """Stamp that changes when a run, an editor or a recorder writes; empty for missing files.

        Returns
        -------
        mapping
            ``config`` and ``report`` of the two files; ``data`` of the logs and clips and of all
            that the configuration says beside models and excluded poses.
        """
        config = stamp_of(self.path)
        if config != self._of_config[0]:
            try:
                stated = load_config(self.path)
                self._of_config = config, _stated(stated), list(named_files(stated))
            except ConfigError:  # between two writes of an editor
                self._of_config = config, *self._of_config[1:]
        _, text, paths = self._of_config
        data = hashlib.sha256("\n".join([text, *map(stamp_of, paths)]).encode())
        return {"config": config, "report": stamp_of(self.folder / REPORT_NAME),
                "data": data.hexdigest()}

    def is_run(self) -> bool:
        """Whether the results are from this program, configuration and files as they are.

        And whether the commands of the page, typed here, are for this configuration: those of a
        session that was moved or copied are for the one that it was.
        """
        config = load_config(self.path)
        results, report = self.folder / RESULTS_NAME, self.folder / REPORT_NAME
        try:
            written = results.stat().st_mtime_ns
            of_run = json.loads(results.read_text(encoding="utf-8"))["config_sha256"]
            is_newest = all(path.stat().st_mtime_ns <= written for path in named_files(config))
            page = report.read_text(encoding="utf-8")
            named, = shlex.split(json.loads(_NAMED.findall(page)[0]))
        except (OSError, ValueError, LookupError, TypeError, RecursionError):
            return False
        return (is_newest and Path(named).resolve() == self.path.resolve()
                and f"pipeline {program_version()}" in page
                and of_run == hashlib.sha256(config.source.text.encode()).hexdigest())


def stamp_of(path: Path) -> str:
    """Stamp that changes when a file is written; empty without one."""
    try:
        status = path.stat()
    except OSError:
        return ""
    return f"{status.st_mtime_ns}-{status.st_size}-{status.st_ino}"


def _stated(config: Config) -> str:
    """The part of a configuration that the screen does not write."""
    def without(value: Any) -> Any:
        if isinstance(value, dict):
            return {key: without(one) for key, one in value.items() if key not in OF_THE_SCREEN}
        return [*map(without, value)] if isinstance(value, list | tuple) else value

    stated = without(config.model_dump(warnings=False))
    return json.dumps([str(config.source.path.resolve()), stated], default=str)


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
    """The track of one clip, from the cache if it is there."""
    (track,) = follow_clips([clip], context)
    return track


def _turning(
    session: OpenSession, folder: Path, logs: Sequence[ImuLog], clip: Path, k: int
) -> PlateReading:
    """A log corrected by the results; by its data sheet if they have no correction."""
    spec, log = sensor_specs(session.config.sensor)["gyroscope"], logs[k]
    try:
        stored = load_results(folder, session.context.allow_python)
        vectors, how = apply_results(stored, log).triads["gyroscope"], "corrected as the file says"
    except (PipelineError, CalibrationError, KeyError):
        vectors, how = spec.nominal(log.gyroscope), "by its data sheet"
    return PlateReading(log.time_s, np.linalg.norm(vectors, axis=1), how, _begins_s(clip))


def _begins_s(clip: Path) -> float:
    """Start of a clip on the clock of the session's logs; NaN where it was recorded otherwise."""
    try:
        with clip.with_suffix(".times.csv").open(encoding="utf-8") as file:
            return float(next(csv.DictReader(file))["session_s"])
    except (OSError, ValueError, KeyError, TypeError, StopIteration, csv.Error):
        return math.nan
