"""Scripts, and answers to questions in JSON; what is refused is answered with a sentence."""

import asyncio
import json
from collections.abc import Callable, Sequence
from contextlib import suppress
from functools import cache, partial
from importlib import resources
from multiprocessing.pool import ThreadPool
from typing import Any, TypeVar

from starlette.applications import Starlette
from starlette.requests import Request
from starlette.responses import JSONResponse, Response
from starlette.routing import BaseRoute, Route

from calib.errors import CalibrationError
from pipeline.errors import ConfigError, PipelineError
from pipeline.served.guard import Guard, TooLarge
from vision.errors import VisionError

REFUSED = (CalibrationError, PipelineError, VisionError)
WORKERS = 16  #: number of questions that are answered at the same time. Chosen
Json = dict[str, Any]
T = TypeVar("T")


def application(routes: Sequence[BaseRoute], token: str, port: int) -> Guard:
    """The guarded application; what is refused is answered with a sentence."""
    handlers: Any = {
        TooLarge: lambda *_: Response("too large for this server", 413),
        **dict.fromkeys(REFUSED, lambda _, error: JSONResponse({"error": str(error)}, 422)),
    }
    return Guard(Starlette(routes=routes, exception_handlers=handlers), token, port)


def script(text: str) -> Callable[[Request], Response]:
    """What answers with a script."""
    return lambda _: Response(text, media_type="text/javascript")


def scripts(folder: str, *names: str) -> list[BaseRoute]:
    """What answers with the scripts of these names in a folder of this package."""
    return [Route(f"/{name}.js", script(template(f"{folder}/{name}.js"))) for name in names]


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
    return JSONResponse(await beside(lambda: answer(question)))


@cache
def _workers() -> ThreadPool:
    """Threads that the program does not wait for when it ends, unlike those of asyncio."""
    return ThreadPool(WORKERS)


async def beside(work: Callable[[], T]) -> T:
    """What ``work`` gives, computed beside the loop that serves the others."""
    loop = asyncio.get_running_loop()
    done: asyncio.Future[T] = loop.create_future()

    def settle(give: Callable[[Any], None], value: Any) -> None:
        with suppress(RuntimeError):  # the server has ended
            loop.call_soon_threadsafe(lambda: None if done.cancelled() else give(value))

    _workers().apply_async(work, callback=partial(settle, done.set_result),
                           error_callback=partial(settle, done.set_exception))
    return await done
