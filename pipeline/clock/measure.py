"""A camera's clock from the film of the turning hand."""

import json
import math
import threading
import time
import webbrowser
from collections.abc import Callable
from dataclasses import asdict
from datetime import date
from pathlib import Path

from calib.numbers import RPM
from pipeline.cameras import CameraClock, user_folder
from pipeline.clock.computer import ServerWatch, computer_clock, server_rate
from pipeline.clock.screen import DrawnHand, ScreenPage, drawn_hand
from pipeline.errors import DeviceError, UnreadableInput
from pipeline.files import write_whole
from pipeline.served.serve import serving
from pipeline.stages.context import RunContext
from pipeline.stages.rate import ClipToFollow, follow_clips
from vision.rate.filmed_screen import FilmedScreen, clock_by_screen
from vision.rate.measure import measure_rate
from vision.rate.steady_part import ClipPart
from vision.rate.timebase import Timebase

OPENS_S = 30.0  #: for a browser to open the page; chosen
LOOK_S = 0.5  #: between two checks whether the page reports; chosen
SETTLED_S = 3.0
"""Time of the film after which a camera has set its exposure. A judgement."""

EXPOSURE_S = 1e-3
"""Sd of a drift of the middle of the exposure over a film. A judgement: the screen's light is
constant; automatic exposure may still creep by some per cent of 1/30 s."""

TEMPERATURE_PPM = 3.0
"""Sd due to the camera's temperature. Fact: AT-cut crystals move by up to 3 ppm between 15 and 45
°C; a camera is some 10 K warmer after a quarter of an hour."""

Progress = Callable[[str, int, int | None], None]


def last_screen() -> Path:
    """Path of the description of the latest drawing of the hand."""
    return user_folder() / "screen.json"


def show_hand(server: str | None, seconds: float, tell: Callable[[str], None],
              meanwhile: Callable[[], object] | None = None) -> DrawnHand:
    """Draw the hand in a browser, for ``seconds`` or until ``meanwhile`` has returned.

    Parameters
    ----------
    server : str or None
        The time server that is asked; None asks none.
    seconds : float
    tell : callable
        Takes a line for the user.
    meanwhile : callable, optional
        What films the screen.

    Raises
    ------
    DeviceError
        No browser opens the page, or it was not in front all the time.
    """
    page, watch = ScreenPage(), None if server is None else ServerWatch(server)
    address = ""

    def opened(at: str) -> None:
        nonlocal address
        address = at
        tell(f"the hand is drawn at {at}")
        # Some browsers that are named by $BROWSER return when they are closed.
        threading.Thread(target=webbrowser.open, args=(at,), daemon=True).start()

    with serving(page.routes, opened, port=0):
        begun = time.monotonic()
        while not page.reports:
            if time.monotonic() - begun > OPENS_S:
                raise DeviceError(f"no browser has opened {address} within {OPENS_S:g} s. Open "
                                  f"the address in a browser on this computer sooner.")
            time.sleep(LOOK_S)
        if watch is not None:
            watch.start()
        if meanwhile is not None:
            meanwhile()
        else:
            time.sleep(seconds)
        answers = watch.stop() if watch is not None else []
        computer = computer_clock(str(server), server_rate(answers))
        return drawn_hand(page.reports, computer, date.today().isoformat())


def keep_screen(hand: DrawnHand) -> Path:
    """Store the description of the drawing for films that are measured later; returns its path."""
    path = last_screen()
    write_whole(path, json.dumps(asdict(hand), indent=1, ensure_ascii=False) + "\n")
    return path


def read_screen(path: Path) -> DrawnHand:
    """The drawing described in ``path``.

    Raises
    ------
    UnreadableInput
        It is missing or describes none.
    """
    try:
        hand = DrawnHand(**json.loads(path.read_text(encoding="utf-8")))
        known = (hand.rate_rad_s, hand.refresh_hz, hand.page_fast_ppm, hand.sd_ppm)
        if not all(isinstance(value, int | float) and math.isfinite(value) for value in known):
            raise ValueError("a number is missing")
        if min(hand.rate_rad_s, hand.refresh_hz, hand.sd_ppm) <= 0:
            raise ValueError("a number is not positive")
    except OSError as error:
        raise UnreadableInput(
            f"{path}: cannot be read ({error.strerror}). It describes the hand that was filmed: "
            f"type `pipeline clock --show` while you film it, or name the file (--screen)."
        ) from error
    except (ValueError, TypeError) as error:
        raise UnreadableInput(f"{path}: describes no drawn hand ({error}). Type `pipeline clock "
                              f"--show` again, and film it.") from error
    return hand


def film_of_screen(clip: Path, hand: DrawnHand, on_progress: Progress) -> FilmedScreen:
    """The camera's clock against that of the page, from the film.

    Raises
    ------
    UnreadableInput, UnreadableVideo, RateRefused
        The film cannot be read, or shows no hand that turns at the drawn rate.
    """
    (track,) = follow_clips([ClipToFollow(clip)], RunContext(None, on_progress))
    rate = measure_rate(track, timebase=Timebase(), nominal_rpm=hand.rate_rad_s / RPM,
                        part=ClipPart(SETTLED_S))
    return clock_by_screen(rate, str(clip), hand.rate_rad_s, hand.refresh_hz)


def camera_clock(name: str, film: FilmedScreen, hand: DrawnHand, day: date) -> CameraClock:
    """The camera's clock against true time, with every part of its sd."""
    fast = (1 + film.fast) * (1 + 1e-6 * hand.page_fast_ppm) - 1
    parts = {
        "frames": 1e6 * film.frames_sd,
        "refresh of the screen": 1e6 * film.refresh_sd,
        "computer's clock": hand.sd_ppm,
        "exposure": 1e6 * EXPOSURE_S / film.seconds,
        "temperature": TEMPERATURE_PPM,
    }
    return CameraClock(
        name=name,
        fast_ppm=1e6 * fast,
        sd_ppm=math.hypot(*parts.values()),
        parts_ppm=parts,
        measured=day,
        how=hand.how,
    )
