"""Questions to a workbench, with any headers."""

import http.client
import json

from pipeline.served.guard import LOOPBACK
from tests.pipeline.workbench.conftest import Opened

GIGABYTE = 1 << 30


class Asked:
    """Requests to a workbench with any headers."""

    def __init__(self, opened: Opened) -> None:
        self.port = int(opened.origin.rpartition(":")[2])
        self.token = opened.address.rpartition("=")[2]
        self.cookie = f"pipeline-workbench-{self.port}={self.token}"
        self.host = f"{LOOPBACK}:{self.port}"

    def ask(
        self, path: str, method: str = "GET", body: bytes = b"", **headers: str
    ) -> tuple[int, dict[str, str], bytes]:
        """Status, headers and body; of a request with exactly these headers and the Host."""
        connection = http.client.HTTPConnection(LOOPBACK, self.port, timeout=240)
        connection.putrequest(method, path, skip_host=True, skip_accept_encoding=True)
        named = {"Host": self.host} | {k.replace("_", "-"): v for k, v in headers.items()}
        if body and "Content-Length" not in named:
            named["Content-Length"] = str(len(body))
        for name, value in named.items():
            connection.putheader(name, value)
        connection.endheaders(body or None)
        answer = connection.getresponse()
        event_stream = answer.getheader("content-type", "").startswith("text/event-stream")
        body_read = b"" if event_stream else answer.read()
        connection.close()
        return answer.status, {k.lower(): v for k, v in answer.getheaders()}, body_read

    def post(self, path: str, question: object) -> tuple[int, dict[str, object]]:
        """A question as the page asks it."""
        status, _, body = self.ask(path, "POST", json.dumps(question).encode(),
                                   Cookie=self.cookie, Origin=f"http://{self.host}")
        return status, json.loads(body)
