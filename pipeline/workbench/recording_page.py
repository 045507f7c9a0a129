"""A recording shown in the browser: what the terminal's panel shows, as a stream of events.

The recording runs in the program's own thread and knows nothing of the page; the server runs in
another one and sends what it was last told.
"""

import asyncio
import json
import threading
from collections import deque
from collections.abc import AsyncIterator, Callable

import numpy as np
from starlette.requests import Request
from starlette.responses import HTMLResponse, Response, StreamingResponse
from starlette.routing import BaseRoute, Route

from calib.numbers import RPM
from calib.poses.attitudes import direction_name
from pipeline.drawings.sheet import pose_svg
from pipeline.record.session import RecordingDisplay, RecordingView
from pipeline.report.layout.page_templates import page_templates
from pipeline.results.json_values import Json
from pipeline.served.answers import script, template

LOOK_S = 0.1  #: between two looks at the state: as often as the panel is drawn. Chosen
KEPT = 200  #: lines that stay on the page; chosen
TRACE = 120  #: readings of a trace, some ten seconds; layout


class RecordingPage:
    """A display that the terminal has beside it; see ``pipeline.record.session.RecordingDisplay``.

    Parameters
    ----------
    beside : RecordingDisplay
        Shows the same on the terminal.
    outlook : callable
        Lines on what the poses recorded so far determine.
    """

    def __init__(self, beside: RecordingDisplay, outlook: Callable[[], list[str]]) -> None:
        self._beside, self._outlook = beside, outlook
        self._lines: deque[str] = deque(maxlen=KEPT)
        self._traces: deque[list[float]] = deque(maxlen=TRACE)
        self._view: Json = {}
        self._lock = threading.Lock()

    def say(self, text: str) -> None:
        """A line that stays."""
        self._beside.say(text)
        with self._lock:
            self._lines.append(text)

    def show(self, view: RecordingView) -> None:
        """The present state."""
        self._beside.show(view)
        with self._lock:
            self._traces.append(view.status.reading.tolist())
            self._view = view_json(view)

    def recorded(self, text: str) -> None:
        """A pose is recorded: its line, and what all of them determine by now."""
        self._beside.recorded(text)
        with self._lock:
            self._lines.extend([text, *self._outlook()])

    def state(self) -> Json:
        """What the page shows: the view, the traces axis by axis, and the lines."""
        with self._lock:
            traces = np.nan_to_num(np.array(self._traces).reshape(-1, 6)).round(4).T.tolist()
            return {"view": self._view, "traces": traces, "lines": list(self._lines)}

    @property
    def routes(self) -> list[BaseRoute]:
        """The page, its scripts and its events."""
        page = page_templates().from_string(
            template("workbench/templates/recording.html")).render(title="record")
        return [
            Route("/", lambda _: HTMLResponse(page)),
            Route("/drawing.js", script(template("workbench/templates/drawing.js"))),
            Route("/recording.js", script(template("workbench/templates/recording.js"))),
            Route("/events", self._events),
        ]

    async def _events(self, request: Request) -> Response:
        return StreamingResponse(self._news(request), media_type="text/event-stream")

    async def _news(self, request: Request) -> AsyncIterator[str]:
        before = ""
        while not await request.is_disconnected():
            now = json.dumps(self.state())
            if now != before:
                before = now
                yield f"data: {now}\n\n"
            await asyncio.sleep(LOOK_S)


def view_json(view: RecordingView) -> Json:
    """One moment of a recording; ``next`` is the attitude to lay next with its drawing."""
    status = view.status
    missing = [i for i in range(len(view.wanted)) if i not in view.covered]
    return {
        "plate": view.block.rate, "phase": status.phase, "message": status.message,
        "up": status.direction, "progress": status.progress,
        "rpm": float(np.linalg.norm(np.nan_to_num(status.reading[3:]))) / RPM,
        "rate_hz": view.rate_hz, "damaged": view.bad,
        "directions": [{"name": direction_name(each), "recorded": i in view.covered}
                       for i, each in enumerate(view.wanted)],
        "next": None if not missing else {
            "name": direction_name(view.wanted[missing[0]]),
            "drawing": pose_svg(view.wanted[missing[0]])},
    }
