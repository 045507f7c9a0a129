"""The page with the turning hand, and the test of its clock."""

import json
import time
from collections.abc import Sequence
from dataclasses import dataclass
from string import Template

import numpy as np
from starlette.requests import Request
from starlette.responses import HTMLResponse, Response
from starlette.routing import BaseRoute, Route

from calib.numbers import RPM
from pipeline.clock.computer import ComputerClock
from pipeline.errors import DeviceError
from pipeline.served.serve import script, template

HAND_RPM = 17.0
"""Rate of the hand. A judgement: as fast as the slowest plates; 30 frames per second show it at 106
angles of every turn, at different ones in the next."""

LONGEST_GAP_S = 0.5
"""Between two refreshes of a page that is in front. Fact: browsers draw hidden pages once a second
or not at all."""

FEWEST_REPORTS = 20  #: reports that compare two clocks. Derived: a second each, for 2 ppm at 1 ms
LATE = 4.0
"""Sds from which a report counts as delayed on its way. Derived: one in 16,000 is not."""


@dataclass(frozen=True)
class Report:
    """One report of the page, sent every second.

    Attributes
    ----------
    monotonic_s, wall_s : float
        The computer's clocks when it came.
    now_s : float
        The page's clock when it was sent.
    refreshes_s : tuple of float
        When the page drew, by its clock.
    """

    monotonic_s: float
    wall_s: float
    now_s: float
    refreshes_s: tuple[float, ...]


@dataclass(frozen=True)
class DrawnHand:
    """The drawn hand, by true time.

    Attributes
    ----------
    rate_rad_s : float
        By the page's clock.
    refresh_hz : float
        Likewise.
    page_fast_ppm, sd_ppm : float
        The page's clock against true time, and the sd of that.
    how : str
        What that is known by.
    missed : float
        Share of the refreshes at which the page was late.
    seconds : float
        For which it was drawn.
    day : str
        In ISO 8601.
    """

    rate_rad_s: float
    refresh_hz: float
    page_fast_ppm: float
    sd_ppm: float
    how: str
    missed: float
    seconds: float
    day: str


class ScreenPage:
    """The page that draws the hand, and what it has reported so far."""

    def __init__(self) -> None:
        self.reports: list[Report] = []
        page = HTMLResponse(template("clock/page.html"))
        drawing = Template(template("clock/page.js")).substitute(rate_rad_s=repr(HAND_RPM * RPM))
        self.routes: list[BaseRoute] = [
            Route("/", lambda _: page), Route("/page.js", script(drawing)),
            Route("/refreshes", self._take, methods=["POST"])]

    async def _take(self, request: Request) -> Response:
        """Take a report; its time is that of its first byte."""
        monotonic_s, wall_s = time.monotonic(), time.time()
        try:
            message = json.loads(await request.body())
            refreshes = tuple(float(at) / 1e3 for at in message["refreshes"])
            now_s = float(message["now"]) / 1e3
        except (ValueError, KeyError, TypeError):
            return Response(status_code=400)
        self.reports.append(Report(monotonic_s, wall_s, now_s, refreshes))
        return Response()


def drawn_hand(reports: Sequence[Report], computer: ComputerClock, day: str) -> DrawnHand:
    """The hand by true time, from the reports of the page and the computer's clock.

    Raises
    ------
    DeviceError
        The page was not drawn all the time.
    """
    if len(reports) < FEWEST_REPORTS:
        raise DeviceError(
            f"the page was drawn for {len(reports)} s, at least {FEWEST_REPORTS} s are needed. "
            f"Leave its window open and in front until the command ends."
        )
    refreshes = np.concatenate([report.refreshes_s for report in reports])
    steps = np.diff(refreshes)
    if steps.max() > LONGEST_GAP_S:
        raise DeviceError(
            f"the page was not drawn for {steps.max():.1f} s, after {refreshes[steps.argmax()]:.0f}"
            f" s. Leave its window in front, and keep the screen from going dark."
        )
    usual = float(np.median(steps))
    counts = np.maximum(np.rint(steps / usual), 1)
    number = np.concatenate([[0.0], np.cumsum(counts)])
    period = float(np.polyfit(number, refreshes - refreshes[0], 1)[0])
    clock_s = [each.wall_s if computer.by_wall else each.monotonic_s for each in reports]
    rate, sd = _clock_ratio(np.array([each.now_s for each in reports]), np.array(clock_s))
    return DrawnHand(
        rate_rad_s=HAND_RPM * RPM,
        refresh_hz=1 / period,
        page_fast_ppm=1e6 * ((1 + rate) * (1 + 1e-6 * computer.fast_ppm) - 1),
        sd_ppm=float(np.hypot(computer.sd_ppm, 1e6 * sd)),
        how=computer.how,
        missed=float(1 - len(steps) / counts.sum()),
        seconds=float(refreshes[-1] - refreshes[0]),
        day=day,
    )


def _clock_ratio(page_s: np.ndarray, computer_s: np.ndarray) -> tuple[float, float]:
    """Seconds of the page per second of the computer, less one, and its sd.

    Reports are delayed by the browser and the system; those far later than the others are left out.
    """
    x = computer_s - computer_s.mean()
    late = (computer_s - computer_s[0]) - (page_s - page_s[0])
    kept = np.ones(len(x), bool)
    while True:
        columns = np.column_stack([np.ones_like(x), x])
        beta = np.linalg.lstsq(columns[kept], late[kept], rcond=None)[0]
        residual = late - columns @ beta
        sd = float(residual[kept].std(ddof=2))
        still = residual < LATE * max(sd, 1e-9)
        if (still | ~kept).all() or still.sum() < FEWEST_REPORTS:
            break
        kept &= still
    spread = float(np.sqrt(((x[kept] - x[kept].mean()) ** 2).sum()))
    return -float(beta[1]), sd / spread
