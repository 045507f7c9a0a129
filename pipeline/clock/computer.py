"""Uncertainty of the computer's clock: by NTP, or by the operating system.

Only the rate matters: a way to the server that is longer than the way back shifts all answers by
the same amount. An answer that took longer than the quickest one may be late by half of the
difference.
"""

import ctypes
import ctypes.util
import socket
import struct
import sys
import threading
import time
from dataclasses import dataclass

import numpy as np

KEPT_PPM = 10.0
"""Sd of a clock that the system disciplines by a time server. A judgement: it is corrected by some
milliseconds now and then, 10 ppm of the five minutes of a film."""

UNKEPT_PPM = 50.0
"""Sd of an undisciplined clock. Fact: quartzes of computers are good to 20 to 100 ppm."""

UNSYNCHRONISED = 0x40  #: STA_UNSYNC of <sys/timex.h>
TIMEX_BYTES = 1024  #: more than the structure has on any system


@dataclass(frozen=True)
class ComputerClock:
    """The computer's clock while the hand was drawn.

    Attributes
    ----------
    by_wall : bool
        The clock of the day was kept; otherwise the monotonic one is meant.
    fast_ppm : float
        It runs fast by so much.
    sd_ppm : float
    how : str
        What it is known by.
    """

    by_wall: bool
    fast_ppm: float
    sd_ppm: float
    how: str


def computer_clock(server: str, measured: "ServerRate | None") -> ComputerClock:
    """Rate of the computer's clock: by the server's answers, or by the system."""
    if measured is not None:
        # The server's seconds per second of ours, less one: if they are many, ours are long.
        return ComputerClock(
            False, -1e6 * measured.rate, 1e6 * measured.sd,
            f"{measured.answers} answers of the time server {server}")
    kept = kept_by_system()
    if kept:
        return ComputerClock(True, 0.0, KEPT_PPM, "the system keeps the clock by a time server")
    reason = ("the system says that no time server keeps it" if kept is False
              else "this system does not say whether a time server keeps it")
    return ComputerClock(False, 0.0, UNKEPT_PPM,
                         f"its quartz alone: no time server answered, and {reason}")


def kept_by_system() -> bool | None:
    """Whether the system disciplines its clock by a time server; None where it does not say."""
    if sys.platform == "win32":
        return None
    try:
        library = ctypes.CDLL(ctypes.util.find_library("c"), use_errno=True)
        timex = ctypes.create_string_buffer(TIMEX_BYTES)
        state = library.ntp_adjtime(timex)  # modes = 0: read only
    except (OSError, AttributeError, TypeError):
        return None
    if state < 0:
        return None
    long = ctypes.sizeof(ctypes.c_long)
    # modes (int, padded), offset, freq, maxerror, esterror (longs), status (int)
    status = ctypes.c_int.from_buffer(timex, 5 * long).value
    return not status & UNSYNCHRONISED


PORT = 123  #: fact: of the protocol
EVERY_S = 16.0  #: between two requests. A judgement: servers reject clients that ask more often
TIMEOUT_S = 2.0  #: for an answer, which takes 0.3 s round the Earth; chosen
FEWEST_ANSWERS = 6
"""Number of answers that determine a rate and its sd. Derived: two for the line, four for the
residual."""

LEAST_SD_S = 2e-4
"""Least sd of an answer. Fact: time stamps of network cards without hardware support."""

NTP_TO_UNIX_S = 2_208_988_800  #: definition: from 1900 to 1970
FRACTION = 2**32  #: definition: parts of a second
QUESTION = b"\x23" + 47 * b"\0"  #: version 4, client


@dataclass(frozen=True)
class ServerAnswer:
    """Answer of a server, seconds.

    Attributes
    ----------
    local_s : float
        The computer's monotonic clock halfway between question and answer.
    ahead_s : float
        The server's clock less that.
    delay_s : float
        On the way, there and back.
    """

    local_s: float
    ahead_s: float
    delay_s: float


@dataclass(frozen=True)
class ServerRate:
    """The server's seconds per second of the computer's monotonic clock, less one; its sd."""

    rate: float
    sd: float
    answers: int


def ask(address: tuple[str, int]) -> ServerAnswer | None:
    """One answer of the server at ``address``; None without a usable one."""
    try:
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as line:
            line.settimeout(TIMEOUT_S)
            line.connect(address)
            sent = time.monotonic()
            line.send(QUESTION)
            packet = line.recv(512)
            heard = time.monotonic()
    except OSError:
        return None
    if len(packet) < 48 or packet[0] & 7 != 4 or packet[0] >> 6 == 3 or packet[1] == 0:
        return None  # no server's answer, or one whose own clock is not set, or "ask less often"
    came, went = (
        whole - NTP_TO_UNIX_S + part / FRACTION
        for whole, part in zip(*[iter(struct.unpack("!4I", packet[32:48]))] * 2, strict=True)
    )
    middle = (sent + heard) / 2
    return ServerAnswer(middle, (came + went) / 2 - middle, (heard - sent) - (went - came))


def server_rate(answers: list[ServerAnswer]) -> ServerRate | None:
    """The rate from answers in the order of time; None if there are too few.

    The variance of each combines the least scatter and its delay beyond the quickest.
    """
    if len(answers) < FEWEST_ANSWERS:
        return None
    local, ahead, delay = (np.array(each) for each in zip(
        *((a.local_s, a.ahead_s, a.delay_s) for a in answers), strict=True))
    sd = np.hypot(LEAST_SD_S, (delay - delay.min()) / 2)
    x = np.column_stack([np.ones_like(local), local - local.mean()])
    weighted = x / sd[:, None]
    beta = np.linalg.lstsq(weighted, (ahead - ahead[0]) / sd, rcond=None)[0]
    misfit = ((ahead - ahead[0] - x @ beta) / sd) ** 2
    # Answers scatter by more than these terms where the server is one of many, or busy.
    scatter = max(1.0, float(misfit.sum()) / (len(answers) - 2))
    cov = np.linalg.inv(weighted.T @ weighted) * scatter
    return ServerRate(float(beta[1]), float(np.sqrt(cov[1, 1])), len(answers))


class ServerWatch:
    """Polls a server, in a thread of its own, from ``start`` to ``stop``."""

    def __init__(self, server: str, port: int = PORT, every_s: float = EVERY_S) -> None:
        self._server, self._port, self._every_s = server, port, every_s
        self._answers: list[ServerAnswer] = []
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._run, daemon=True)

    def start(self) -> None:
        """Begin to poll."""
        self._thread.start()

    def stop(self) -> list[ServerAnswer]:
        """Stop, and return all answers."""
        self._stop.set()
        self._thread.join(2 * TIMEOUT_S)
        return list(self._answers)

    def _run(self) -> None:
        try:
            # One of the pool's servers, and the same one each time: their clocks differ.
            address = socket.getaddrinfo(
                self._server, self._port, socket.AF_INET, socket.SOCK_DGRAM)[0][4]
        except OSError:
            return
        while True:
            answer = ask((str(address[0]), int(address[1])))
            if answer is not None:
                self._answers.append(answer)
            if self._stop.wait(self._every_s):
                return
