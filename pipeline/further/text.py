"""The runs of a session that further logs may join, and the text of its configuration with them."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from calib.poses.imu_log import Triad
from pipeline.config.edit import add_entry, extend_list, set_excluded
from pipeline.config.file_patterns import names_of, relative_name
from pipeline.config.load import Config
from pipeline.config.schema import RunSection
from pipeline.config.types import STOPPED
from pipeline.config.yaml_syntax import yaml_word
from pipeline.config.yaml_text import PathTo, YamlSource
from pipeline.errors import ConfigError
from pipeline.further.logs import AS_READ, FurtherLog
from pipeline.guess.plate import nominal_rpm
from pipeline.stages.excluded_poses import choose, short_names
from pipeline.stages.session_logs import pose_labels


@dataclass(frozen=True)
class Place:
    """A run of a triad that logs may join; ``section`` has its keys, empty for a new run."""

    triad: Triad
    rate: str
    section: PathTo = ()


def places_for(config: Config, logs: Sequence[FurtherLog]) -> list[Place]:
    """Every run of a triad that these logs may join, in the order of the configuration; a new run
    of the gyroscope where it has none at their setting."""
    places: dict[Place, None] = {}
    for log in logs:
        for triad in config.triads:
            if not np.isfinite(log.means[0].of(triad).mean).all():
                continue
            able = [Place(triad, log.rate, keys) for keys, run in config.placed_runs()
                    if keys[0] == triad and run.rate == log.rate
                    and (run.poses.log if log.is_long else run.poses.files)]
            new = [Place(triad, log.rate)] if triad == "gyroscope" else []
            places |= dict.fromkeys((able or new)[:1])
    return [*places]


def with_further(
    config: Config, logs: Sequence[FurtherLog], places: Sequence[Place],
    moved: Mapping[Path, Path] | None = None,
) -> YamlSource:
    """The file of the configuration with ``logs`` in the runs ``places``; all else is kept.

    ``moved`` says where files lie that were not there when they were read.

    Raises
    ------
    ConfigError
        No place takes a log, or its run lists the columns of each file.
    """
    now, source = moved or {}, config.source
    for log in logs:
        if not any(log.rate == place.rate for place in places):
            kind = "a long log" if log.is_long else "a log of one pose"
            raise ConfigError(
                f"{log.path.name}: no run takes it: it is {kind} "
                f"{'at rest' if log.rate == STOPPED else f'at the setting {log.rate}'}. Cut it "
                f"into files of one pose each, choose a run, or add one to {source.path}.")
    for rate, clip in {log.rate: log.clip for log in logs if log.clip}.items():
        video = relative_name(now.get(clip.path, clip.path), source.path.parent)
        source = add_entry(source, "rate", rate, (
            f"{{video: {yaml_word(video)}, nominal_rpm: {nominal_rpm(clip.rate_rad_s):.6g}}}"))
    for place in places:
        source = _with_place(
            config, source, place, [log for log in logs if log.rate == place.rate], now)
    return source


def _with_place(
    config: Config, source: YamlSource, place: Place, logs: Sequence[FurtherLog],
    moved: Mapping[Path, Path],
) -> YamlSource:
    folder = source.path.parent
    paths = [moved.get(log.path, log.path) for log in logs]
    words = [yaml_word(name) for name in names_of(paths, folder)]
    if not place.section:
        return extend_list(source, (place.triad, "runs"), [_run_text(source, place, logs, words)])
    run = next(run for keys, run in config.placed_runs() if keys == place.section)
    if run.poses.columns is not None and len(run.poses.columns) > 1:
        raise ConfigError(source.problem((*place.section, "poses"), (
            "lists the columns of each file; add the new files there by hand")))
    source = _with_whole_names(config, source, place, run, paths)
    key: PathTo = (*place.section, "poses")
    if isinstance(source.value(key), dict):
        key = (*key, "log" if run.poses.log else "files")
    return extend_list(source, key, words)


def _run_text(
    source: YamlSource, place: Place, logs: Sequence[FurtherLog], words: Sequence[str]
) -> str:
    """A new run, with the columns and the clock of the section as which its logs were read."""
    stated = source.value(logs[0].read_as)
    keys = {name: stated[name] for name in AS_READ
            if isinstance(stated, dict) and name in stated}
    is_long = logs[0].is_long
    files = f"[{', '.join(words)}]" if len(words) > 1 else words[0]
    if keys or is_long:
        entries = [f"{'log' if is_long else 'files'}: {files}"]
        entries += [f"{name}: {_flow(value)}" for name, value in keys.items()]
        entries += ["find: still"] if is_long else []
        files = f"{{{', '.join(entries)}}}"
    return f"{{poses: {files}, rate: {yaml_word(place.rate)}}}"


def _flow(value: Any) -> str:
    """A value of a configuration on one line."""
    if isinstance(value, dict):
        return f"{{{', '.join(f'{name}: {_flow(each)}' for name, each in value.items())}}}"
    if isinstance(value, list):
        return f"[{', '.join(map(_flow, value))}]"
    return yaml_word(value) if isinstance(value, str) else f"{value}"


def _with_whole_names(
    config: Config, source: YamlSource, place: Place, run: RunSection, paths: Sequence[Path]
) -> YamlSource:
    """The file with the whole names of excluded poses where a new file has the short one too."""
    labels = pose_labels(run.poses, config)
    new = {name for path in paths for name in short_names(path.name)}
    if not labels or new.isdisjoint(run.exclude):
        return source
    whole = [str(name) if isinstance(name, int) else
             yaml_word(labels[int(choose(labels, [name]).excluded[0])]) for name in run.exclude]
    return set_excluded(source, place.section, whole)
