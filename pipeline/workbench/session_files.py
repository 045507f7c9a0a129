"""The files of an open session: what they are now, by their times and sizes."""

import hashlib
import json
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from pipeline.config.load import Config, load_config
from pipeline.errors import ConfigError
from pipeline.results.names import REPORT_NAME, RESULTS_NAME

OF_THE_SCREEN = frozenset({"model", "exclude"})  #: keys that the screen writes
Stamp = Mapping[str, str]


class SessionFiles:
    """The configuration ``path``, what it names, and the folder of its results."""

    def __init__(self, path: Path, folder: Path) -> None:
        self.path, self.folder = path, folder
        self._of_config: tuple[str, str, list[Path]] = "", "", []

    def stamp(self) -> Stamp:
        """What changes when a run, an editor or a recorder writes; empty for what is not there.

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
                self._of_config = config, _stated(stated), list(_paths(stated.model_dump()))
            except ConfigError:  # between two writes of an editor
                self._of_config = config, *self._of_config[1:]
        _, text, paths = self._of_config
        data = hashlib.sha256("\n".join([text, *map(stamp_of, paths)]).encode())
        return {"config": config, "report": stamp_of(self.folder / REPORT_NAME),
                "data": data.hexdigest()}

    def is_run(self) -> bool:
        """Whether the results are those of the configuration and the logs as they are now."""
        config = load_config(self.path)
        results = self.folder / RESULTS_NAME
        try:
            written = results.stat().st_mtime_ns
            of_run = json.loads(results.read_text(encoding="utf-8"))["config_sha256"]
            there = (self.folder / REPORT_NAME).is_file() and all(
                path.stat().st_mtime_ns <= written for path in _paths(config.model_dump()))
        except (OSError, ValueError, KeyError, TypeError, RecursionError):
            return False
        return bool(there and of_run == hashlib.sha256(config.source.text.encode()).hexdigest())


def stamp_of(path: Path) -> str:
    """What changes when a file is written; empty where there is none."""
    try:
        status = path.stat()
    except OSError:
        return ""
    return f"{status.st_mtime_ns}-{status.st_size}-{status.st_ino}"


def _stated(config: Config) -> str:
    """What a configuration states beside what the screen writes."""
    def without(value: Any) -> Any:
        if isinstance(value, dict):
            return {key: without(one) for key, one in value.items() if key not in OF_THE_SCREEN}
        return [*map(without, value)] if isinstance(value, list | tuple) else value

    return json.dumps([str(config.source.path.resolve()), without(config.model_dump())],
                      default=str)


def _paths(value: Any) -> Iterator[Path]:
    """The files in the values of a configuration."""
    if isinstance(value, Path):
        yield value
    elif isinstance(value, dict | list | tuple):
        for one in value.values() if isinstance(value, dict) else value:
            yield from _paths(one)
