"""A recording in the browser: the contents of the terminal's panel as a stream of events.

The recording runs in the program's own thread and does not depend on the page; the server runs in
another one and sends the latest state.
"""

import json
import threading
from collections import deque
from collections.abc import Sequence

import numpy as np
from starlette.requests import Request
from starlette.responses import HTMLResponse, Response
from starlette.routing import BaseRoute, Route

from calib.numbers import RPM
from calib.poses.attitudes import direction_name
from pipeline.drawings.sheet import pose_svg
from pipeline.plan.so_far import Outlook, SoFar
from pipeline.record.session import RecordingDisplay, RecordingView
from pipeline.report.page_templates import page_templates
from pipeline.results.json_values import Json
from pipeline.served.serve import events, scripts, template
from pipeline.text.formatting import DISPLAY
from vision.live_plate import LivePlate

LOOK_S = 0.1  #: between two looks at the state: as often as the panel is drawn. Chosen
KEPT = 200  #: lines that stay on the page; chosen
TRACE = 120  #: readings of a trace, some ten seconds; layout


class RecordingPage:
    """A display in addition to the terminal's; see ``pipeline.record.session.RecordingDisplay``.

    Parameters
    ----------
    beside : RecordingDisplay
        Shows the same on the terminal.
    outlook : Outlook
        What the poses recorded so far determine.
    plate : LivePlate
        What a camera sees, if there is one.
    """

    def __init__(self, beside: RecordingDisplay, outlook: Outlook, plate: LivePlate) -> None:
        self._beside, self._outlook, self._plate = beside, outlook, plate
        self._so_far: dict[str, list[SoFar]] = {}
        self._note(outlook.after("begin"))
        self._lines: deque[str] = deque(maxlen=KEPT)
        self._traces: deque[list[float]] = deque(maxlen=TRACE)
        self._view: Json = {}
        self._lock = threading.Lock()

    def say(self, text: str) -> None:
        """Show a line that stays."""
        self._beside.say(text)
        with self._lock:
            self._lines.append(text)

    def show(self, view: RecordingView) -> None:
        """Show the present state."""
        self._beside.show(view)
        with self._lock:
            self._traces.append(view.status.reading.tolist())
            self._view = view_json(view)

    def recorded(self, text: str) -> None:
        """Show a recorded pose: its line, and the results of all poses so far."""
        self._beside.recorded(text)
        triads = self._outlook.after(text)
        with self._lock:
            self._lines.extend(self._outlook.lines_after(text))
            self._note(triads)

    def _note(self, triads: list[SoFar]) -> None:
        for each in triads:
            self._so_far.setdefault(each.triad, []).append(each)

    def state(self) -> Json:
        """Contents of the page: the view, the traces axis by axis, and the lines."""
        with self._lock:
            traces = np.nan_to_num(np.array(self._traces).reshape(-1, 6)).round(4).T.tolist()
            return {"view": self._view, "traces": traces, "lines": list(self._lines),
                    "camera": self._plate.words,
                    "outlook": [outlook_json(history) for history in self._so_far.values()]}

    @property
    def routes(self) -> list[BaseRoute]:
        """The page, its scripts and its events."""
        page = page_templates().from_string(
            template("workbench/templates/recording.html")).render(title="record")
        return [
            Route("/", lambda _: HTMLResponse(page)),
            *scripts("workbench/templates", "drawing", "recording"),
            events(lambda: f"data: {json.dumps(self.state())}", LOOK_S),
            Route("/picture", self._picture),
        ]

    def _picture(self, _: Request) -> Response:
        picture = self._plate.picture()
        return (Response(status_code=404) if picture is None
                else Response(picture, media_type="image/jpeg"))


def view_json(view: RecordingView) -> Json:
    """One moment of a recording; ``next`` is the next attitude with its drawing."""
    status, wanted = view.status, view.next_wanted
    return {
        "plate": view.block.rate, "phase": status.phase, "message": status.message,
        "up": status.direction, "progress": status.progress,
        "rpm": float(np.linalg.norm(np.nan_to_num(status.reading[3:]))) / RPM,
        "rate_hz": view.rate_hz, "damaged": view.bad,
        "directions": [{"name": direction_name(each), "recorded": i in view.covered}
                       for i, each in enumerate(view.wanted)],
        "next": None if wanted is None else {
            "name": direction_name(wanted), "drawing": pose_svg(wanted)},
    }


def outlook_json(history: Sequence[SoFar]) -> Json:
    """The sds of one triad from pose to pose, and the most valuable next step."""
    known = [each for each in history if not np.isnan(each.scale_sd)]
    now = history[-1]
    return {
        "triad": now.triad, "advice": now.advice, "enough": now.enough, "poses_now": now.poses,
        "poses": [each.poses for each in known],
        "sds": [{"name": "scale", "unit": "ppm", "values": [1e6 * each.scale_sd for each in known]},
                {"name": "bias", "unit": DISPLAY[now.triad][0],
                 "values": [each.bias_sd for each in known]}],
    }
