"""A server on the loopback address, its scripts and its answers in JSON."""

import asyncio
import json
import secrets
import socket
import threading
from collections.abc import AsyncIterator, Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from functools import partial
from importlib import resources
from multiprocessing.pool import ThreadPool
from types import FrameType
from typing import Any, TypeVar

import uvicorn
from starlette.applications import Starlette
from starlette.requests import Request
from starlette.responses import JSONResponse, Response, StreamingResponse
from starlette.routing import BaseRoute, Route

from calib.errors import CalibrationError
from pipeline.errors import ConfigError, PipelineError
from pipeline.served.guard import LOOPBACK, Guard, TooLarge
from vision.errors import VisionError

REFUSED = (CalibrationError, PipelineError, VisionError)
Json = dict[str, Any]
T = TypeVar("T")


def application(routes: Sequence[BaseRoute], token: str, port: int) -> Guard:
    """The guarded application; refusals are answered with a sentence."""
    handlers: Any = {
        TooLarge: lambda *_: Response("too large for this server", 413),
        **dict.fromkeys(REFUSED, lambda _, error: JSONResponse({"error": str(error)}, 422)),
    }
    no_icon = Route("/favicon.ico", lambda _: Response(status_code=204))  # browsers ask for one
    return Guard(Starlette(routes=[*routes, no_icon], exception_handlers=handlers), token, port)


def script(text: str) -> Callable[[Request], Response]:
    """A handler that returns a script."""
    return lambda _: Response(text, media_type="text/javascript")


def scripts(folder: str, *names: str) -> list[BaseRoute]:
    """Routes for the scripts of these names in a folder of this package."""
    return [Route(f"/{name}.js", script(template(f"{folder}/{name}.js"))) for name in names]


def template(path: str) -> str:
    """The text of a file of this package, by its path in it."""
    return resources.files("pipeline").joinpath(path).read_text(encoding="utf-8")


def answering(path: str, answer: Callable[[Json], Json]) -> Route:
    """Route that answers requests in JSON, computed beside the loop that serves the others.

    Raises
    ------
    ConfigError
        While it is asked: the question is none; the application turns it into a sentence.
    """

    async def answered(request: Request) -> Response:
        try:
            question = json.loads(await request.body())
        except (ValueError, RecursionError):
            question = None
        if not isinstance(question, dict):
            raise ConfigError("a question of the page is expected, in JSON.")
        return JSONResponse(await beside(lambda: answer(question)))

    return Route(path, answered, methods=["POST"])


def events(news: Callable[[], str], look_s: float, settles: bool = False) -> Route:
    """Route ``/events`` of a stream: an event whenever ``news`` gives another text.

    ``look_s`` is the time between two looks; with ``settles`` a text counts that two looks give.
    """

    async def stream(request: Request) -> AsyncIterator[str]:
        told = before = ""
        while not await request.is_disconnected():
            now = news()
            if now != told and (now == before or not settles):
                told = now
                yield f"{now}\n\n"
            before = now
            await asyncio.sleep(look_s)

    async def streamed(request: Request) -> Response:
        return StreamingResponse(stream(request), media_type="text/event-stream")

    return Route("/events", streamed)


async def beside(work: Callable[[], T]) -> T:
    """Result of ``work``, computed beside the loop that serves the others.

    The program does not wait for the thread when it ends, unlike for those of asyncio.
    """
    loop = asyncio.get_running_loop()
    done: asyncio.Future[T] = loop.create_future()

    def settle(give: Callable[[Any], None], value: Any) -> None:
        with suppress(RuntimeError):  # the server has ended
            loop.call_soon_threadsafe(lambda: None if done.cancelled() else give(value))

    thread = ThreadPool(1)
    thread.apply_async(work, callback=partial(settle, done.set_result),
                       error_callback=partial(settle, done.set_exception))
    thread.close()  # once this is answered
    return await done


PREFERRED_PORT = 8818  #: tried first, so that a reloaded page finds a new server. Chosen
LOOK_S = 0.01  #: between checks whether a server in a thread listens. Chosen
END_S = 2.0  #: for a server in a thread to end. Chosen
TOKEN_BYTES = 32  #: 256 random bits. Chosen


class _Server(uvicorn.Server):
    """Reports its address once it listens for requests and signals; ends at the first signal.

    An earlier signal goes to Python, which may lose one while it imports.
    """

    def __init__(self, config: uvicorn.Config, listens: Callable[[], None]) -> None:
        super().__init__(config)
        self.listens = listens
        self.told = False

    async def startup(self, sockets: list[socket.socket] | None = None) -> None:
        await super().startup(sockets)
        self.listens()
        self.told = True

    def handle_exit(self, sig: int, frame: FrameType | None) -> None:
        self.force_exit = True
        super().handle_exit(sig, frame)


def serve(routes: Sequence[BaseRoute], opened: Callable[[str], None]) -> None:
    """Serve until a signal ends the server; the signal is raised again then.

    Parameters
    ----------
    routes : sequence of route
        What is answered.
    opened : callable
        Gets the address with its token once the server listens.

    Raises
    ------
    ConfigError, Undetermined
        The answer to a question that is none; the application turns it into a sentence.
    """
    with _listening(routes, opened, PREFERRED_PORT) as (server, listener):
        server.run(sockets=[listener])


@contextmanager
def serving(
    routes: Sequence[BaseRoute], opened: Callable[[str], None], port: int = PREFERRED_PORT
) -> Iterator[None]:
    """A server in its own thread, which ends with the block; as :func:`serve`.

    ``port`` is tried first; another one is taken where it is busy.
    """
    with _listening(routes, opened, port) as (server, listener):
        thread = threading.Thread(target=server.run, kwargs={"sockets": [listener]}, daemon=True)
        thread.start()
        while thread.is_alive() and not server.told:
            thread.join(LOOK_S)
        try:
            yield
        finally:
            server.should_exit = server.force_exit = True
            thread.join(END_S)


@contextmanager
def _listening(
    routes: Sequence[BaseRoute], opened: Callable[[str], None], port: int
) -> Iterator[tuple[_Server, socket.socket]]:
    """A server with its socket, whose address is reported."""
    with listening_socket(port) as listener:
        chosen = int(listener.getsockname()[1])
        token = secrets.token_urlsafe(TOKEN_BYTES)
        config = uvicorn.Config(
            application(routes, token, chosen), log_level="critical", access_log=False,
            lifespan="off", server_header=False, ws="none", timeout_graceful_shutdown=0)
        address = f"http://{LOOPBACK}:{chosen}/?token={token}"
        yield _Server(config, lambda: opened(address)), listener


def listening_socket(port: int) -> socket.socket:
    """A socket on the loopback address that listens on ``port``, or on a free one."""
    for tried in (port, 0):
        listener = socket.socket(socket.AF_INET, socket.SOCK_STREAM)
        listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            listener.bind((LOOPBACK, tried))
            listener.listen()
            return listener
        except OSError:
            listener.close()
            if tried == 0:
                raise
    raise AssertionError  # the loop ends with a socket or an error
