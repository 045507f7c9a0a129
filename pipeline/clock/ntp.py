"""The computer's clock against a time server's: SNTP (RFC 4330), asked a few times.

Only the rate matters: a way to the server that is longer than the way back shifts all answers
alike. An answer that took longer than the quickest one may be late by half of the difference.
"""

import socket
import struct
import threading
import time
from dataclasses import dataclass

import numpy as np

PORT = 123  #: fact: of the protocol
EVERY_S = 16.0  #: between two questions. A judgement: servers turn away who asks more often
TIMEOUT_S = 2.0  #: for an answer, which takes 0.3 s round the Earth; chosen
FEWEST_ANSWERS = 6
"""Number of answers that determine a rate and its sd. Derived: two for the line, four for what is
left."""

LEAST_SD_S = 2e-4
"""Sd of an answer at least. Fact: time stamps of network cards without help of the hardware."""

NTP_TO_UNIX_S = 2_208_988_800  #: definition: from 1900 to 1970
FRACTION = 2**32  #: definition: parts of a second
QUESTION = b"\x23" + 47 * b"\0"  #: version 4, client


@dataclass(frozen=True)
class ServerAnswer:
    """What a server answered, seconds.

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
    """One answer of the server at ``address``; None where there is none that can be used."""
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
    """The rate from answers in the order of time; None where they are too few.

    Each counts by the least scatter and by what it took longer than the quickest.
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
    """Asks a server again and again, in a thread of its own, from ``start`` to ``stop``."""

    def __init__(self, server: str, port: int = PORT, every_s: float = EVERY_S) -> None:
        self._server, self._port, self._every_s = server, port, every_s
        self._answers: list[ServerAnswer] = []
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._run, daemon=True)

    def start(self) -> None:
        """Begin to ask."""
        self._thread.start()

    def stop(self) -> list[ServerAnswer]:
        """End, and give all answers."""
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
