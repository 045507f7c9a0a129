"""Access control: only this computer's own browser with the token may send requests.

The server listens on 127.0.0.1 alone. A request caused by a page of another origin is refused by
the Host (a name that points here), by the Origin and by the cookie, which the browser does not send
along (``SameSite=Strict``). A content security policy without inline script limits what the page
may load.
"""

import secrets
from http.cookies import CookieError, SimpleCookie

from starlette.datastructures import Headers, MutableHeaders
from starlette.requests import Request
from starlette.responses import PlainTextResponse, RedirectResponse
from starlette.types import ASGIApp, Message, Receive, Scope, Send

LOOPBACK = "127.0.0.1"
COOKIE = "pipeline-workbench"
LARGEST_QUESTION = 1_000_000
"""Largest body of a request, bytes: a state is some kilobytes. Chosen."""
LARGEST_RESULTS = 1 << 26  #: bytes of a results.json: 10,000 poses are 8 MB. Chosen
LARGEST_FILE = 1 << 30  #: bytes of a log or a clip that is dropped. Chosen
POLICY = (
    "default-src 'none'; script-src 'self'; style-src 'self' 'unsafe-inline'; "
    "img-src 'self' data:; connect-src 'self'; base-uri 'none'; form-action 'none'; "
    "frame-ancestors 'none'"
)
HEADERS = {
    "Content-Security-Policy": POLICY,
    "Cache-Control": "no-store",
    "Cross-Origin-Opener-Policy": "same-origin",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Referrer-Policy": "no-referrer",
    "X-Content-Type-Options": "nosniff",
}


class Guard:
    """Lets a request of the page's own browser through, and bounds its body.

    Parameters
    ----------
    app : ASGI application
    token : str
        The secret of the address that was printed, from then on in the cookie.
    port : int
    """

    def __init__(self, app: ASGIApp, token: str, port: int) -> None:
        self.app, self.token, self.port = app, token, port
        self.hosts = {f"{LOOPBACK}:{port}", f"localhost:{port}"}

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer one request."""
        if scope["type"] == "lifespan":
            await self.app(scope, receive, send)
            return
        if scope["type"] != "http":
            await send({"type": "websocket.close", "code": 1008})
            return

        async def guarded(message: Message) -> None:
            if message["type"] == "http.response.start":
                MutableHeaders(scope=message).update(HEADERS)
            await send(message)

        request = Request(scope)
        refusal = self._refusal(request)
        if refusal is not None:
            await PlainTextResponse(refusal, 403)(scope, receive, guarded)
        elif self._is_token(request.query_params.get("token")):
            answer = RedirectResponse("/", 303)  # the secret leaves the address line
            answer.set_cookie(f"{COOKIE}-{self.port}", self.token, httponly=True,
                              samesite="strict", path="/")
            await answer(scope, receive, guarded)
        elif int_of(request.headers.get("content-length", "0")) > largest(request.url.path):
            await PlainTextResponse("too large for this server", 413)(scope, receive, guarded)
        else:
            await self.app(scope, _bounded(receive, largest(request.url.path)), guarded)

    def _refusal(self, request: Request) -> str | None:
        """Reason why a request is refused, None where it is not."""
        headers: Headers = request.headers
        host, origin = headers.get("host", ""), headers.get("origin")
        if len(headers.getlist("host")) != 1 or host not in self.hosts:
            return "this server answers on its own address alone"
        if headers.get("sec-fetch-site", "none") not in ("same-origin", "none"):
            return "another site asked"
        if origin != f"http://{host}" and (origin is not None or request.method != "GET"):
            return "another origin asked"
        if self._is_token(request.query_params.get("token")) and request.method == "GET":
            return None
        if not self._is_token(cookie_of(request, f"{COOKIE}-{self.port}")):
            return "open the address that the command printed, with its token"
        return None

    def _is_token(self, text: str | None) -> bool:
        return text is not None and secrets.compare_digest(text.encode(), self.token.encode())


def cookie_of(request: Request, name: str) -> str | None:
    """The value of a cookie; None if there is none."""
    try:
        cookies = SimpleCookie(request.headers.get("cookie", ""))
    except CookieError:
        return None
    return cookies[name].value if name in cookies else None


def largest(path: str) -> int:
    """Largest body, bytes, of a request to ``path``."""
    if path.startswith("/bring/"):
        return LARGEST_FILE
    return LARGEST_RESULTS if path.endswith("/held-out") else LARGEST_QUESTION


def int_of(text: str) -> int:
    """A length as a number; invalid ones count as larger than any."""
    return int(text) if text.isascii() and text.isdigit() and len(text) < 19 else 1 << 62


class TooLarge(Exception):
    """A body without a stated length exceeded the largest length of a request."""


def _bounded(receive: Receive, limit: int) -> Receive:
    """``receive`` that raises :class:`TooLarge` beyond ``limit`` bytes."""
    seen = 0

    async def bounded() -> Message:
        nonlocal seen
        message = await receive()
        seen += len(message.get("body", b""))
        if seen > limit:
            raise TooLarge
        return message

    return bounded
