"""A page in headless Chromium that is used as a person uses it: keys, mouse, touch, printing.

Spoken to over a pipe in the DevTools protocol, a JSON message ended by a zero byte each way.
"""

import base64
import json
import os
import select
import subprocess
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

from tests.pipeline.report.browser import CHROMIUM, QUIET

SECONDS = 240.0  #: a command is expected to be answered within
KEYS = {"Enter": 13, " ": 32, "Tab": 9, "Escape": 27, "ArrowLeft": 37, "ArrowUp": 38,
        "ArrowRight": 39, "ArrowDown": 40}  # fmt: skip
PHONE = {"width": 390, "height": 844, "deviceScaleFactor": 2, "mobile": True}
DESKTOP = {"width": 1280, "height": 900, "deviceScaleFactor": 1, "mobile": False}


class Tab:
    """One open page."""

    def __init__(self, to: int, out: int, number: int = 0) -> None:
        self.to, self.out, self.number = to, out, number
        self.buffer, self.session = b"", ""
        self.requests: list[str] = []  #: addresses that the page has asked for
        self.errors: list[str] = []  #: exceptions of its scripts that nobody caught

    def send(self, method: str, **parameters: Any) -> Any:
        """The result of one command."""
        self.number += 1
        message = {"id": self.number, "method": method, "params": parameters}
        if self.session:
            message["sessionId"] = self.session
        os.write(self.to, json.dumps(message).encode() + b"\0")
        while True:
            answer = self._receive()
            if answer.get("id") == self.number:
                assert "error" not in answer, f"{method}: {answer['error']}"
                return answer["result"]

    def _receive(self) -> dict[str, Any]:
        while b"\0" not in self.buffer:
            assert select.select([self.out], [], [], SECONDS)[0], "the browser does not answer"
            part = os.read(self.out, 1 << 20)
            assert part, "the browser has ended"
            self.buffer += part
        text, _, self.buffer = self.buffer.partition(b"\0")
        message: dict[str, Any] = json.loads(text)
        if message.get("sessionId", self.session) != self.session:
            return {}  # of a tab that is closed
        if message.get("method") == "Network.requestWillBeSent":
            url = message["params"]["request"]["url"]
            if not url.startswith("data:"):
                self.requests.append(url)
        if message.get("method") == "Runtime.exceptionThrown":
            self.errors.append(str(message["params"]["exceptionDetails"]))
        return message

    def evaluate(self, script: str) -> Any:
        """The value of an expression, or of a function's body that returns one."""
        code = f"(() => {{ {script} }})()" if "return" in script else script
        result = self.send("Runtime.evaluate", expression=code, returnByValue=True,
                           awaitPromise=True)
        assert "exceptionDetails" not in result, result["exceptionDetails"]
        return result["result"].get("value")

    def open(self, page: Path, screen: dict[str, Any] | None = None, *, dark: bool = False,
             fragment: str = "") -> None:
        """Load a file on a screen of this size, and wait until it has loaded."""
        self.visit(f"{page.as_uri()}{fragment}", screen, dark=dark)

    def visit(self, address: str, screen: dict[str, Any] | None = None, *, dark: bool = False
              ) -> None:
        """The same of any address."""
        for domain in ("Page", "Runtime", "Network"):
            self.send(f"{domain}.enable")
        screen = screen or DESKTOP
        self.send("Emulation.setDeviceMetricsOverride", **screen)
        self.send("Emulation.setTouchEmulationEnabled", enabled=screen["mobile"])
        self.send("Emulation.setEmulatedMedia", features=[
            {"name": "prefers-color-scheme", "value": "dark" if dark else "light"},
            {"name": "prefers-reduced-motion", "value": "reduce"}])
        self.send("Page.navigate", url=address)
        self.loaded()

    def loaded(self) -> None:
        """Wait until the page has loaded and is on the screen."""
        self.evaluate("new Promise((done) => document.readyState === 'complete' ? done(true)"
                      " : addEventListener('load', () => done(true)))")
        self.painted()

    def wait(self, expression: str) -> Any:
        """The value of an expression once it is true, across pages that are loaded meanwhile."""
        end = time.monotonic() + SECONDS
        while time.monotonic() < end:
            with suppress(AssertionError):
                if value := self.evaluate(expression):
                    return value
            time.sleep(0.05)
        raise AssertionError(f"never true: {expression}")

    def painted(self) -> None:
        """Wait until the page is on the screen as it is: a finger touches what was painted last.

        On a busy machine a page may be loaded, or scrolled, long before it is painted so.
        """
        self.evaluate("new Promise((done) => "
                      "requestAnimationFrame(() => requestAnimationFrame(() => done(true))))")

    def unfold(self) -> None:
        """Open the layers of a report that are folded away."""
        self.evaluate(
            "document.querySelectorAll('details.layer, details.others')"
            ".forEach((e) => { e.open = true; })")
        self.painted()

    def key(self, key: str) -> None:
        """Press and release a key, where the focus is."""
        code = KEYS[key]
        text = {"Enter": "\r", " ": " "}.get(key)
        down = {"text": text} if text else {}
        common = {"key": key, "code": "Space" if key == " " else key, "windowsVirtualKeyCode": code}
        self.send("Input.dispatchKeyEvent", type="keyDown" if text else "rawKeyDown", **common,
                  **down)
        self.send("Input.dispatchKeyEvent", type="keyUp", **common)

    def centre(self, selector: str) -> tuple[float, float]:
        """The middle of an element, scrolled into sight."""
        x, y = self.evaluate(
            f"const e = document.querySelector({json.dumps(selector)});"
            "e.scrollIntoView({block: 'center', behavior: 'instant'});"
            "const b = e.getBoundingClientRect();"
            "return [b.x + b.width / 2, b.y + b.height / 2];")
        self.painted()
        return x, y

    def click(self, selector: str) -> None:
        """Click the middle of an element."""
        x, y = self.centre(selector)
        for kind in ("mousePressed", "mouseReleased"):
            self.send("Input.dispatchMouseEvent", type=kind, x=x, y=y, button="left", clickCount=1)

    def drag(self, selector: str, dx: float, dy: float, *, touch: bool = False) -> None:
        """Drag the middle of an element, with the mouse or a finger."""
        x, y = self.centre(selector)
        path = [(x + dx * i / 5, y + dy * i / 5) for i in range(6)]
        if touch:
            for kind, points in (("touchStart", path[:1]), *(("touchMove", [p]) for p in path[1:]),
                                 ("touchEnd", [])):
                self.send("Input.dispatchTouchEvent", type=kind,
                          touchPoints=[{"x": a, "y": b} for a, b in points])
            return
        kinds = ["mousePressed", *["mouseMoved"] * 5, "mouseReleased"]
        for kind, (a, b) in zip(kinds, [*path, path[-1]], strict=True):
            self.send("Input.dispatchMouseEvent", type=kind, x=a, y=b, button="left", buttons=1,
                      clickCount=1)

    def tap(self, selector: str) -> None:
        """Touch the middle of an element."""
        x, y = self.centre(selector)
        self.send("Input.dispatchTouchEvent", type="touchStart", touchPoints=[{"x": x, "y": y}])
        self.send("Input.dispatchTouchEvent", type="touchEnd", touchPoints=[])

    def shot(self, path: Path) -> None:
        """What is in sight, as a PNG."""
        data = self.send("Page.captureScreenshot", format="png")["data"]
        path.write_bytes(base64.b64decode(data))

    def printed(self) -> bytes:
        """The page as a PDF on A4."""
        data = self.send("Page.printToPDF", paperWidth=8.27, paperHeight=11.69)["data"]
        return base64.b64decode(data)


class Browser:
    """A browser that can reach no host but this one, for one tab after the other."""

    def __init__(self, to: int, out: int) -> None:
        self.to, self.out, self.commands = to, out, 0

    @contextmanager
    def tab(self) -> Iterator[Tab]:
        """A new tab, closed in the end."""
        tab = Tab(self.to, self.out, self.commands)
        target = tab.send("Target.createTarget", url="about:blank")["targetId"]
        tab.session = tab.send("Target.attachToTarget", targetId=target, flatten=True)["sessionId"]
        try:
            yield tab
        finally:
            tab.session = ""
            tab.send("Target.closeTarget", targetId=target)
            self.commands = tab.number

    def ask(
        self, page: str, folder: Path, script: str, fragment: str = "",
        screen: dict[str, Any] | None = None,
    ) -> Any:
        """What ``script`` returns in the opened page, whose own script must not fail."""
        path = folder / "asked.html"
        path.write_text(page, encoding="utf-8")
        with self.tab() as tab:
            tab.open(path, screen, fragment=fragment)
            answer = tab.evaluate(script)
            assert tab.errors == []
        return answer


@contextmanager
def started_browser(folder: Path) -> Iterator[Browser]:
    """A new browser; its profile is in ``folder``."""
    assert CHROMIUM is not None
    to_browser, from_us = os.pipe()
    to_us, from_browser = os.pipe()
    ends = f"exec \"$0\" \"$@\" 3<&{to_browser} 4>&{from_browser}"
    process = subprocess.Popen(
        ["bash", "-c", ends, CHROMIUM, *QUIET, "--remote-debugging-pipe",
         "--host-resolver-rules=MAP * ~NOTFOUND, EXCLUDE 127.0.0.1",
         f"--user-data-dir={folder / 'profile'}"],
        pass_fds=(to_browser, from_browser), stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
    )  # fmt: skip
    os.close(to_browser)
    os.close(from_browser)
    try:
        yield Browser(from_us, to_us)
    finally:
        process.terminate()
        process.wait(SECONDS)
        os.close(from_us)
        os.close(to_us)
