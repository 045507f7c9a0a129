"""The page of a folder: its sessions, each with its workbench, and dropped logs."""

import json
import re
from collections.abc import Callable
from functools import lru_cache
from pathlib import Path
from typing import Any

from starlette.responses import HTMLResponse, JSONResponse
from starlette.routing import BaseRoute, Mount, Route, Router

from calib.poses.triad_kind import TRIAD_KINDS
from pipeline.config.load import load_config
from pipeline.errors import ConfigError
from pipeline.report.page_templates import page_templates
from pipeline.results.json_values import Json
from pipeline.results.names import RESULTS_NAME
from pipeline.served.serve import answering, scripts, template
from pipeline.workbench.application import Workbench, routes_of
from pipeline.workbench.brought import Brought
from pipeline.workbench.clip_player import ClipPlayer
from pipeline.workbench.session_files import stamp_of

PATTERNS = ("*.yaml", "*.yml", "*/*.yaml", "*/*.yml")
"""Patterns of configurations of a folder: in it, or in a subfolder of their own."""
_SESSION = re.compile(r"^(?:accelerometer|gyroscope|sensor)\s*:", re.MULTILINE)
MOST_LISTED = 10_000  #: sessions whose lines are kept; a line is some hundred bytes. Chosen
LARGEST_CONFIG = 1 << 20  #: bytes; a longer file is no configuration. Chosen

OpenWorkbench = Callable[[Path], Workbench]


class FolderPage:
    """A folder with its sessions.

    Parameters
    ----------
    folder : Path
    opened : callable
        Gives the workbench of a configuration, which it runs where it was not run.
    """

    def __init__(self, folder: Path, opened: OpenWorkbench) -> None:
        self.folder, self._opened = folder.resolve(), opened
        self.brought = Brought(self.folder)
        self._paths: list[Path] = []
        self._mounted: set[int] = set()
        self._benches = Router()
        self.routes: list[BaseRoute] = [
            Route("/", lambda _: HTMLResponse(page_templates().from_string(
                template("workbench/templates/start.html")).render(title=self.folder.name))),
            *scripts("workbench/templates", "drawing", "dropped", "player", "start"),
            *ClipPlayer(self.brought.clips).routes, *self.brought.routes,
            Route("/sessions", lambda _: JSONResponse({"sessions": self.sessions()})),
            Mount("/session", app=self._benches),
            answering("/open", self.open), answering("/guess", self._guess),
            answering("/use", self._use),
        ]

    def sessions(self) -> list[Json]:
        """The sessions of the folder, in the order of their names; no link out of it is followed.
        """
        there = sorted({path for pattern in PATTERNS for path in self.folder.glob(pattern)})
        for path in there:
            if path not in self._paths and self._is_session(path):
                self._paths.append(path)
        listed = [(i, path) for i, path in enumerate(self._paths) if path.is_file()]
        return [self._row(i, path) for i, path in sorted(listed, key=lambda each: each[1])]

    def _is_session(self, path: Path) -> bool:
        if not path.is_file() or not path.resolve().is_relative_to(self.folder):
            return False
        try:
            with path.open(encoding="utf-8") as file:
                return bool(_SESSION.search(file.read(LARGEST_CONFIG)))
        except (OSError, ValueError):
            return False

    def _row(self, number: int, path: Path) -> Json:
        """Contents of a line of the list; the verdicts are those of the last run."""
        inside = path.relative_to(self.folder)
        row = {"number": number, "path": str(inside), "was_run": False, "verdicts": {},
               "problem": "", "title": str(inside.parent if inside.parent.name else inside.stem)}
        try:
            results = _output_folder(path, stamp_of(path)) / RESULTS_NAME
        except ConfigError as error:
            return row | {"problem": str(error).replace(f"{path}:", "line ", 1)}
        return row | _of_results(results, stamp_of(results))

    def open(self, question: Json) -> Json:
        """The address of the workbench of a session, which is run first if it was not.

        Raises
        ------
        PipelineError, CalibrationError, VisionError
            There is no such session, or it does not run.
        """
        number = question.get("number")
        if not isinstance(number, int) or not 0 <= number < len(self._paths):
            raise ConfigError("there is no such session; load the page again.")
        if number not in self._mounted:
            workbench = self._opened(self._paths[number])
            self._benches.routes.append(Mount(f"/{number}", routes=routes_of(workbench)))
            self._mounted.add(number)
        return {"address": f"/session/{number}/"}

    def _guess(self, question: Json) -> Json:
        return self.brought.guessed(_number(question.get("scale")))

    def _use(self, question: Json) -> Json:
        latitude, height = (_number(question.get(key)) for key in ("latitude", "height"))
        written = self.brought.use(str(question.get("name")), latitude, height or 0.0,
                                   _number(question.get("scale")))
        self.sessions()
        return written | {"number": self._paths.index(Path(written["path"]))}


@lru_cache(MOST_LISTED)
def _output_folder(config: Path, _stamp: str) -> Path:
    return load_config(config).output_folder


@lru_cache(MOST_LISTED)
def _of_results(results: Path, _stamp: str) -> Json:
    """Title and verdicts of a run; nothing without one."""
    try:
        contents: Any = json.loads(results.read_text(encoding="utf-8"))
        verdicts = {triad: contents[triad]["diagnosis"]["short"] for triad in TRIAD_KINDS
                    if contents.get(triad)}
        titled = {"title": contents["title"]} if contents["title"] else {}
        return {"was_run": True, "verdicts": verdicts} | titled
    except (OSError, ValueError, KeyError, TypeError, AttributeError, RecursionError):
        return {}


def _number(value: Any) -> float | None:
    """A number in a request; None if it is not one."""
    return float(value) if isinstance(value, int | float) and abs(value) < 1e6 else None
