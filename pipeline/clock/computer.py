"""How well the computer's clock is known, and by what."""

import ctypes
import ctypes.util
import sys
from dataclasses import dataclass

from pipeline.clock.ntp import ServerRate

KEPT_PPM = 10.0
"""Sd of a clock that the system keeps by a time server. A judgement: it is corrected by some
milliseconds now and then, 10 ppm of the five minutes of a film."""

UNKEPT_PPM = 50.0
"""Sd of a clock that nobody keeps. Fact: quartzes of computers are good to 20 to 100 ppm."""

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


def computer_clock(server: str, measured: ServerRate | None) -> ComputerClock:
    """What is known of the computer's clock: by the server's answers, or by the system."""
    if measured is not None:
        # The server's seconds per second of ours, less one: where they are many, ours are long.
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
    """Whether the system keeps its clock by a time server; None where it does not say."""
    if sys.platform == "win32":
        return None
    try:
        library = ctypes.CDLL(ctypes.util.find_library("c"), use_errno=True)
        timex = ctypes.create_string_buffer(TIMEX_BYTES)
        state = library.ntp_adjtime(timex)  # modes = 0: only asks
    except (OSError, AttributeError, TypeError):
        return None
    if state < 0:
        return None
    long = ctypes.sizeof(ctypes.c_long)
    # modes (int, padded), offset, freq, maxerror, esterror (longs), status (int)
    status = ctypes.c_int.from_buffer(timex, 5 * long).value
    return not status & UNSYNCHRONISED
