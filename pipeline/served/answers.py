"""Scripts, and answers to questions in JSON; what is refused is answered with a sentence."""

import asyncio
import json
from collections.abc import Callable, Sequence
from importlib import resources
from typing import Any

from starlette.applications import Starlette
from starlette.requests import Request
from starlette.responses import JSONResponse, Response
from starlette.routing import BaseRoute

from calib.errors import CalibrationError
from pipeline.errors import ConfigError, PipelineError
from pipeline.served.guard import Guard, TooLarge
from vision.errors import VisionError

REFUSED = (CalibrationError, PipelineError, VisionError)
Json = dict[str, Any]


def application(routes: Sequence[BaseRoute], token: str, port: int) -> Guard:
    """The guarded application; what is refused is answered with a sentence."""
    handlers: Any = {
        TooLarge: lambda *_: Response("larger than any question", 413),
        **dict.fromkeys(REFUSED, lambda _, error: JSONResponse({"error": str(error)}, 422)),
    }
    return Guard(Starlette(routes=routes, exception_handlers=handlers), token, port)


def script(text: str) -> Callable[[Request], Response]:
    """What answers with a script."""
    return lambda _: Response(text, media_type="text/javascript")


def template(path: str) -> str:
    """The text of a file of this package, by its path in it."""
    return resources.files("pipeline").joinpath(path).read_text(encoding="utf-8")


async def answered(request: Request, answer: Callable[[Json], Json]) -> Response:
    """The answer to a question in JSON, computed beside the loop that serves the others."""
    try:
        question = json.loads(await request.body())
    except (ValueError, RecursionError):
        question = None
    if not isinstance(question, dict):
        raise ConfigError("a question of the page is expected, in JSON.")
    found_answer = await asyncio.get_running_loop().run_in_executor(None, answer, question)
    return JSONResponse(found_answer)
