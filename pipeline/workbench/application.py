"""Answers of the workbench: page, scripts, refits, columns, changes of the files, writing."""

import json
import re
from collections.abc import Callable
from contextlib import nullcontext
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from threading import Lock

from starlette.requests import Request
from starlette.responses import HTMLResponse, JSONResponse, PlainTextResponse, Response
from starlette.routing import BaseRoute, Route

from calib.poses.imu_log import Triad
from calib.poses.triad_kind import TRIAD_KINDS
from pipeline.config.load import Config, config_from
from pipeline.errors import ConfigError
from pipeline.report.page import outputs_of
from pipeline.report.page_templates import page_templates
from pipeline.results.json_values import Json
from pipeline.results.names import REPORT_NAME
from pipeline.served.serve import answering, beside, events, script, scripts, template
from pipeline.session_folder import working_on, write_session
from pipeline.stages.run import Outcome
from pipeline.workbench.chart_columns import chart_columns
from pipeline.workbench.clip_player import ClipPlayer
from pipeline.workbench.further import FurtherFiles
from pipeline.workbench.held_out import HeldOut
from pipeline.workbench.live_refits import OpenSession
from pipeline.workbench.own_effect import tried_expression, with_own_effect
from pipeline.workbench.session_files import SessionFiles, Stamp, session_clips
from pipeline.workbench.state import changed_lines, read_state

LOOK_S = 0.25
"""Time between two checks of the files, which a run changes one after the other: it shows within a
second. Chosen."""

TEMPLATES = "workbench/templates"
SCRIPTS = ("drawing", "dropped", "player", "further", "steps", "bench_charts", "bench", "workbench")
"""The scripts of the page, in the order in which they build on each other."""

RunConfig = Callable[[Config, Path], Outcome]
_SCRIPT = re.compile(r"<script>\n.*</script>", re.DOTALL)
"""The script of a page that was written as a file: the one element of its kind, the last."""


@dataclass(eq=False)
class Workbench:
    """One configuration with the folder of its results.

    ``run`` runs a configuration with its cache in a folder; ``cache`` is the folder of the phase
    tracks; ``output`` as in ``pipeline run``; ``held_out`` the session whose poses no fit sees.
    """

    path: Path
    folder: Path
    output: Path | None
    cache: Path
    allow_python: bool
    run: RunConfig
    held_out: HeldOut | None = None

    def __post_init__(self) -> None:
        self.files = SessionFiles(self.path, self.folder)
        self.further = FurtherFiles(self.path.absolute().parent)
        self._session: OpenSession | None = None
        self._stamp: Stamp = {}
        self._lock = Lock()

    @property
    def report(self) -> Path:
        """The page of the last run; a link that leads elsewhere counts as missing.

        Raises
        ------
        ConfigError
            There is no such file in the folder.
        """
        path = self.folder / REPORT_NAME
        if not path.is_file() or path.resolve().parent != self.folder.resolve():
            raise ConfigError(f"{path}: is no file of this folder. Run the session again.")
        return path

    def session(self) -> OpenSession:
        """The session as it was run.

        Raises
        ------
        PipelineError, CalibrationError, VisionError
            As a run of it; or its files were changed after the run that the page shows.
        """
        with self._lock:
            stamp = self.files.stamp()
            if self._session is None or stamp != self._stamp:
                if not self.files.is_run():
                    raise ConfigError(
                        f"{self.path}: the configuration or a log was changed after the last run. "
                        f"\"Run\" brings the results here.")
                self._session = OpenSession(self.path, self.cache, self.allow_python)
                self._stamp = stamp
            self._session.held_out = self.held_out
            return self._session

    def page(self) -> str:
        """The report with its script from this server and the tools of the workbench."""
        stamps = " ".join(f'data-{name}="{value}"' for name, value in self.files.stamp().items())
        text = self.report.read_text(encoding="utf-8")
        tools = template(f"{TEMPLATES}/workbench.html")
        elements = "\n".join(f'<script src="{name}.js"></script>' for name in (*SCRIPTS, "report"))
        return _SCRIPT.sub(lambda _: f"{tools}\n{elements}", text).replace(
            "<html ", f'<html class="served" {stamps} ', 1)

    def run_again(self) -> Json:
        """Run the configuration as it is in its file, for a page whose files were changed.

        Raises
        ------
        PipelineError, CalibrationError, VisionError
            The run refuses it; nothing is written.
        """
        with working_on(self.path, self.output) as (config, folder):
            write_session(folder, outputs_of(self.run(config, folder), folder))
        return {}

    def bring(self, question: Json) -> Json:
        """The dropped logs as poses of the session on the screen; nothing is written.

        Raises
        ------
        PipelineError, CalibrationError, VisionError
            A log or the session with it is refused.
        """
        session = self.session()
        shown = config_from(session.source(read_state(question.get("state"))))
        return self.further.looked_at(session, shown, _names(question.get("left_out")))

    def write(self, question: Json) -> Json:
        """Write the state of the screen into the configuration and run it, as one step; dropped
        logs are kept with it.

        Raises
        ------
        PipelineError, CalibrationError, VisionError
            The run refuses it, or the file was changed meanwhile; nothing is written.
        """
        session = self.session()
        source = session.source(read_state(question.get("state")))
        if effect := question.get("own"):
            if not isinstance(effect, dict):
                raise ConfigError("an effect of your own has a name and a formula; load the page "
                                  "again.")
            source = with_own_effect(source, effect, _triad(effect.get("triad")))
        with working_on(self.path, self.output) as (config, folder):
            if config.source.text != session.config.source.text:
                raise ConfigError(f"{self.path}: was changed meanwhile. Load the page again.")
            further = question.get("further")
            with (nullcontext(source) if further is None else
                  self.further.kept_in(session, config_from(source), _names(further))) as source:
                if source.text != config.source.text:
                    outcome = self.run(config_from(source), folder)
                    write_session(folder, outputs_of(outcome, folder), config, source.text)
        return {"lines": changed_lines(config.source.text, source.text), "path": str(self.path),
                "data": self.files.stamp()["data"]}


def routes_of(workbench: Workbench) -> list[BaseRoute]:
    """Routes of one session.

    Raises
    ------
    ConfigError, Undetermined
        The answer to a question that is none; the application turns it into a sentence.
    """

    def page(_: Request) -> Response:
        try:
            return HTMLResponse(workbench.page())
        except ConfigError as error:
            return PlainTextResponse(str(error), 404)

    async def columns(request: Request) -> Response:
        triad = _triad(request.path_params["triad"])
        return JSONResponse(await beside(lambda: chart_columns(workbench.session(), triad)))

    async def held_out(request: Request) -> Response:
        triad = _triad(request.path_params["triad"])
        return JSONResponse(
            await beside(lambda: workbench.session().predicted(None, triad)))

    async def hold_out(request: Request) -> Response:
        dropped = await request.body()
        workbench.held_out = None  # a refused one takes the place of the last one too
        workbench.held_out = await beside(lambda: HeldOut.of_bytes(dropped))
        return JSONResponse({"name": workbench.held_out.name})

    def news() -> str:
        return f"event: files\ndata: {json.dumps(workbench.files.stamp())}"

    player = ClipPlayer(lambda: session_clips(workbench.session(), workbench.folder))
    return [
        Route("/", page),
        *scripts(TEMPLATES, *SCRIPTS), *player.routes,
        Route("/report.js", script(page_templates().get_template("report.js").render())),
        Route("/held-out/{triad}", held_out), Route("/held-out", hold_out, methods=["POST"]),
        Route("/columns/{triad}", columns), events(news, LOOK_S, settles=True),
        answering("/refit", partial(_refit, workbench)), answering("/write", workbench.write),
        answering("/expression", partial(_tried, workbench)),
        answering("/run", lambda _: workbench.run_again()),
        answering("/further", workbench.bring), *workbench.further.routes,
    ]


def _triad(name: object) -> Triad:
    triad = next((each for each in TRIAD_KINDS if each == name), None)
    if triad is None:
        raise ConfigError(f"'{name}' is no triad.")
    return triad


def _names(value: object) -> list[str]:
    if not isinstance(value, list):
        raise ConfigError("runs and effects are named by texts; load the page again.")
    return [*map(str, value)]


def _refit(workbench: Workbench, question: Json) -> Json:
    triad = _triad(question.get("triad"))
    state = read_state(question.get("state"))
    if triad not in state.triads:
        raise ConfigError(f"the page said nothing of the {triad}.")
    return workbench.session().answer(state, triad, _names(question.get("guesses", [])))


def _tried(workbench: Workbench, question: Json) -> Json:
    return tried_expression(
        workbench.session(), read_state(question.get("state")), _triad(question.get("triad")),
        str(question.get("expression")), str(question.get("per")))
