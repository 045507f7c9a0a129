"""A server on the loopback address, until Ctrl-C or the end of a block."""

import secrets
import socket
import threading
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from types import FrameType

import uvicorn
from starlette.routing import BaseRoute

from pipeline.served.answers import application
from pipeline.served.guard import LOOPBACK

PREFERRED_PORT = 8818  #: tried first, so that a reloaded page finds a new server. Chosen
END_S = 2.0  #: for a server in a thread to end. Chosen
TOKEN_BYTES = 32  #: 256 random bits. Chosen


class _Server(uvicorn.Server):
    """Ends at the first signal, whatever is still being answered."""

    def handle_exit(self, sig: int, frame: FrameType | None) -> None:
        self.force_exit = True
        super().handle_exit(sig, frame)


def serve(
    routes: Sequence[BaseRoute], opened: Callable[[str], None], port: int = PREFERRED_PORT
) -> None:
    """Serve until a signal ends it, which is raised again then.

    Parameters
    ----------
    routes : sequence of route
        What is answered.
    opened : callable
        Gets the address with its token once the server listens.
    port : int
        Tried first; another one is taken where it is busy.

    Raises
    ------
    ConfigError, Undetermined
        The answer to a question that is none; the application turns it into a sentence.
    """
    with _listening(routes, opened, port) as (server, listener):
        server.run(sockets=[listener])


@contextmanager
def serving(
    routes: Sequence[BaseRoute], opened: Callable[[str], None], port: int = PREFERRED_PORT
) -> Iterator[None]:
    """A server in a thread of its own, which ends with the block; as :func:`serve`."""
    with _listening(routes, opened, port) as (server, listener):
        thread = threading.Thread(target=server.run, kwargs={"sockets": [listener]}, daemon=True)
        thread.start()
        try:
            yield
        finally:
            server.should_exit = server.force_exit = True
            thread.join(END_S)


@contextmanager
def _listening(
    routes: Sequence[BaseRoute], opened: Callable[[str], None], port: int
) -> Iterator[tuple[_Server, socket.socket]]:
    """A server with its socket, whose address is told."""
    with listening_socket(port) as listener:
        chosen = int(listener.getsockname()[1])
        token = secrets.token_urlsafe(TOKEN_BYTES)
        config = uvicorn.Config(
            application(routes, token, chosen), log_level="critical", access_log=False,
            lifespan="off", server_header=False, ws="none", timeout_graceful_shutdown=0)
        opened(f"http://{LOOPBACK}:{chosen}/?token={token}")
        yield _Server(config), listener


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
