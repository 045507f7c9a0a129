"""The computer's clock, the time server, and the page that draws the hand."""

import json
import socket
import struct
import subprocess
import threading
import time
from collections.abc import Iterator
from pathlib import Path
from urllib.error import HTTPError
from urllib.request import Request, urlopen

import numpy as np
import pytest

from pipeline.clock.computer import (
    KEPT_PPM,
    NTP_TO_UNIX_S,
    UNKEPT_PPM,
    ComputerClock,
    ServerAnswer,
    ServerRate,
    ServerWatch,
    computer_clock,
    server_rate,
)
from pipeline.clock.measure import keep_screen, read_screen, show_hand
from pipeline.clock.screen import HAND_RPM, Report, ScreenPage, drawn_hand
from pipeline.errors import DeviceError
from pipeline.served.serve import serving
from tests.pipeline.report.browser import CHROMIUM, QUIET, needs_browser

RATE = HAND_RPM * 2 * np.pi / 60
KNOWN = ComputerClock(False, 12.0, 2.0, "20 answers of the time server test")


@pytest.fixture
def home(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A user without cameras."""
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path / "user"))
    return tmp_path


def reports(page_ppm: float, seconds: int = 300, gap_s: float = 0.0, seed: int = 1) -> list[Report]:
    """A page at 60 Hz whose clock is off, that reports once a second, a little late."""
    rng = np.random.default_rng(seed)
    made = []
    for k in range(seconds):
        true = k + np.arange(60) / 60 + (gap_s if k > 30 else 0.0)
        page = true * (1 + 1e-6 * page_ppm)
        late = rng.exponential(1e-3) + (0.2 if rng.random() < 0.02 else 0.0)
        made.append(Report(1e4 + true[-1] + late, 1e9 + true[-1] + late, float(page[-1]),
                           tuple(page)))
    return made


def test_the_clock_of_the_page_is_compared_with_the_computer_s() -> None:
    found = [drawn_hand(reports(40.0, seed=seed), KNOWN, "2026-11-23") for seed in range(10)]
    error = np.array([hand.page_fast_ppm - (40 + 12) for hand in found])
    assert np.abs(error).max() < 3
    assert all(2 <= hand.sd_ppm < 4 for hand in found)
    assert found[0].refresh_hz == pytest.approx(60 / (1 + 40e-6), rel=1e-7)


def test_a_page_that_was_not_in_front_is_refused() -> None:
    with pytest.raises(DeviceError, match=r"not drawn for 2\.0 s"):
        drawn_hand(reports(0.0, gap_s=2.0), KNOWN, "2026-11-23")
    with pytest.raises(DeviceError, match="drawn for 10 s"):
        drawn_hand(reports(0.0, seconds=10), KNOWN, "2026-11-23")


def test_answers_of_a_server_give_the_rate_and_an_honest_sd() -> None:
    """Delays of milliseconds that come and go, on one way only."""
    scores = []
    for seed in range(60):
        rng = np.random.default_rng([seed, 5])
        local = np.arange(20) * 16.0
        wait = rng.exponential(2e-3, 20)
        ahead = 1e9 + local * 30e-6 - wait / 2 + 2e-4 * rng.standard_normal(20)
        answers = [ServerAnswer(float(t), float(a), float(0.02 + w))
                   for t, a, w in zip(local, ahead, wait, strict=True)]
        found = server_rate(answers)
        assert found is not None
        scores.append((found.rate - 30e-6) / found.sd)
        assert found.sd < 6e-6
    assert 0.5 < np.sqrt(np.mean(np.square(scores))) < 1.6
    assert server_rate(answers[:5]) is None


@pytest.fixture
def time_server() -> Iterator[int]:
    """A time server on the loopback address, whose clock is true; its port."""
    line = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    line.bind(("127.0.0.1", 0))
    line.settimeout(0.1)
    ended = threading.Event()

    def serve() -> None:
        while not ended.is_set():
            try:
                _, asker = line.recvfrom(512)
            except TimeoutError:
                continue
            now = time.time() + NTP_TO_UNIX_S
            stamp = struct.pack("!2I", int(now), int(now % 1 * 2**32))
            line.sendto(b"\x24\x02" + 30 * b"\0" + 2 * stamp, asker)

    thread = threading.Thread(target=serve)
    thread.start()
    yield line.getsockname()[1]
    ended.set()
    thread.join()
    line.close()


def test_a_server_is_asked_again_and_again(time_server: int) -> None:
    watch = ServerWatch("127.0.0.1", time_server, every_s=0.02)
    watch.start()
    time.sleep(0.5)
    answers = watch.stop()
    assert len(answers) > 8
    offset = time.time() - time.monotonic()
    assert [each.ahead_s for each in answers] == pytest.approx([offset] * len(answers), abs=0.05)


def test_what_is_known_of_the_computer_is_said(monkeypatch: pytest.MonkeyPatch) -> None:
    measured = computer_clock("ntp.test", ServerRate(-20e-6, 1e-6, 19))
    assert (measured.fast_ppm, measured.sd_ppm) == (pytest.approx(20), pytest.approx(1))
    assert "19 answers of the time server ntp.test" in measured.how
    for kept, sd, words in ((True, KEPT_PPM, "keeps"), (False, UNKEPT_PPM, "quartz alone"),
                            (None, UNKEPT_PPM, "does not say")):
        monkeypatch.setattr("pipeline.clock.computer.kept_by_system", lambda kept=kept: kept)
        found = computer_clock("ntp.test", None)
        assert (found.sd_ppm, found.by_wall) == (sd, bool(kept))
        assert words in found.how


@needs_browser
def test_the_page_draws_in_a_browser_and_reports_its_refreshes() -> None:
    page, address = ScreenPage(), []
    with serving(page.routes, address.append, port=0):
        with subprocess.Popen([CHROMIUM, *QUIET, address[0]], stdout=subprocess.DEVNULL,
                              stderr=subprocess.DEVNULL) as browser:
            deadline = time.monotonic() + 30
            while len(page.reports) < 3 and time.monotonic() < deadline:
                time.sleep(0.1)
            browser.terminate()
        with pytest.raises(HTTPError, match="403"):
            urlopen(address[0].partition("?")[0])  # without the token
        with pytest.raises(HTTPError, match="400"):
            urlopen(report_of(address[0], b"[]"))
    assert len(page.reports) >= 3
    last = page.reports[-1]
    assert len(last.refreshes_s) > 5
    assert last.refreshes_s[-1] == pytest.approx(last.now_s, abs=0.5)


def report_of(address: str, body: bytes) -> Request:
    """What the page sends that was opened at ``address``."""
    root, _, token = address.partition("/?token=")
    port = root.rpartition(":")[2]
    return Request(f"{root}/refreshes", data=body, method="POST", headers={
        "Origin": root, "Cookie": f"pipeline-workbench-{port}={token}"})


def test_the_hand_is_shown_while_the_film_is_taken(
    home: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A browser that reports every 20 ms, in the computer's own time; what is shown is kept."""
    seen = threading.Event()

    def browse(url: str) -> None:
        begun = time.monotonic()
        for k in range(60):
            now = 1e3 * (time.monotonic() - begun)
            refreshes = [1e3 * (5 * k + i) / 60 for i in range(5)]
            urlopen(report_of(url, json.dumps({"now": now, "refreshes": refreshes}).encode())
                    ).close()
            time.sleep(0.02)
        seen.set()

    monkeypatch.setattr("webbrowser.open", browse)
    told: list[str] = []
    hand = show_hand(None, 5.0, told.append, lambda: seen.wait(240))
    assert told[0].startswith("the hand is drawn at http://127.0.0.1:")
    assert hand.rate_rad_s == pytest.approx(RATE)
    assert hand.refresh_hz == pytest.approx(60, rel=1e-6)
    assert hand.missed == 0
    assert hand.sd_ppm >= KEPT_PPM  # no server was asked
    assert read_screen(keep_screen(hand)) == hand


def test_a_browser_that_opens_nothing_is_a_device_s_failure(
    monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("webbrowser.open", lambda url: False)
    monkeypatch.setattr("pipeline.clock.measure.OPENS_S", 0.2)
    with pytest.raises(DeviceError, match=r"no browser has opened http://127\.0\.0\.1"):
        show_hand(None, 5.0, lambda line: None)
