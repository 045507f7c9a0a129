"""Present state of the sensor, and whether it makes a pose: the logic behind the display.

Samples are processed in hops of a quarter of a second. A window of four hops is still while the
variance of each triad stays near the quietest level of this block
(:mod:`calib.poses.rests.static_intervals`), and under ceilings that a hand cannot keep. On the
turning plate its tilt changes the readings slowly: there a straight line is removed from every hop
first, and the rate must be steady too. The whole pose is then tested by the same rules as in the
calibration.
"""

from collections import deque
from collections.abc import Sequence

import numpy as np

from calib.earth import STANDARD_GRAVITY_M_S2
from calib.numbers import RPM
from calib.poses.attitudes import NEAR_COSINE, direction_name
from calib.poses.imu_log import SI_UNIT, TRIADS, FloatArray
from calib.poses.reference import PLAUSIBLE_RATIO
from calib.poses.rests.static_intervals import STILL_RATIO, quiet_level
from calib.poses.runs.reference_runs import TURNING_RAD_S
from pipeline.record.blocks import Complete, Phase, Refused, Status, Task
from pipeline.record.stream import TimedSample
from pipeline.stages.pose_means import less_rest

# Half and double of each by ``tests.bench.tested_thresholds``, 18 cases; no case fails but
# where it is said.
HOP_S = 0.25
"""s: the display follows a hand at four a second. Twice of it fails what twice the window and twice
the steady hops do."""

WINDOW_HOPS = 4
"""A second. With two, 1 case fails: a pose that was moved is refused too late."""

STEADY_HOPS = 8
"""Over which the plate's rate is compared with itself. With 16, 1 case fails: a tilted plate that
has just been started makes no pose."""

HISTORY = 2400  #: windows remembered, ten minutes
CEILING = {"accelerometer": 0.5, "gyroscope": 0.1}
"""m/s² and rad/s: standard deviation, all axes together, over which nothing counts as still; a
hand at rest has several times that, the noisiest sensor of this kind a tenth."""

MOVED_RATIO = 4 * STILL_RATIO  #: a pose that has begun ends only on a clear movement
STEADY_CHANGE = 0.005  #: share of the rate, from one second to the next
STEADY_SD = 4.0  #: sds of the difference; derived: by chance one look of 16 000 exceeds it
NEAR_DEG = float(np.degrees(np.arccos(NEAR_COSINE)))
MOVED_DEG = 3.0  #: a slow turn of the sensor within a pose; a plate tilts by a degree at most
SAME_SPEED = 0.4
"""The rate felt may differ so much from the stated one: data sheets are off by up to a third."""


class PoseDetector:
    """Guides through the poses of one block on one connection.

    Parameters
    ----------
    task : Task
    rate_hz : float
        Samples per second.
    covered : sequence of int
        Indices of the wanted directions that are recorded; :meth:`accept` adds to a copy of it.
    """

    def __init__(self, task: Task, rate_hz: float, covered: Sequence[int] = ()) -> None:
        self.task = task
        self.covered = set(covered)
        self._hop = max(2, round(rate_hz * HOP_S))
        self._needed = round(rate_hz * task.seconds)
        self._pending: list[TimedSample] = []
        self._window: deque[FloatArray] = deque(maxlen=WINDOW_HOPS)
        self._means: deque[FloatArray] = deque(maxlen=STEADY_HOPS)
        self._history: dict[str, deque[float]] = {t: deque(maxlen=HISTORY) for t in TRIADS}
        self._rows: list[TimedSample] = []
        self._aim = -1
        self._wait_for_move = False
        self._begun_at = self._taken_at = np.full(6, np.nan)
        self.status = Status("moving", "waiting for readings", "", 0.0, np.full(6, np.nan))

    @property
    def next_direction(self) -> int | None:
        """The first wanted direction not yet covered, None where all are."""
        return next((i for i in range(len(self.task.wanted)) if i not in self.covered), None)

    def feed(self, rows: Sequence[TimedSample]) -> list[Refused | Complete]:
        """Process rows into refused or complete poses; :attr:`status` is updated."""
        events: list[Refused | Complete] = []
        for row in rows:
            self._pending.append(row)
            if len(self._pending) == self._hop:
                hop, self._pending = self._pending, []
                event = self._look(hop)
                if event is not None:
                    events.append(event)
        return events

    def accept(self, direction: int) -> None:
        """Mark a pose as written."""
        self.covered.add(direction)

    def reject(self) -> None:
        """Reject the whole pose; it may be tried again without moving the sensor."""
        self._wait_for_move = False

    def begin_again(self) -> None:
        """Forget the rows of an incomplete pose: those that follow are not continuous."""
        self._rows, self._pending = [], []

    def _look(self, hop: list[TimedSample]) -> Refused | Complete | None:
        values = self._nominal(hop)
        self._window.append(values)
        self._means.append(values.mean(axis=0))
        mean = self._means[-1]
        still, moved = self._stillness()
        if not still:  # the plate's rate counts as steady from the end of the movement on
            self._means.clear()
            self._means.append(mean)
        direction = self._direction(mean)
        name = direction_name(direction) if direction is not None else ""

        def show(phase: Phase, message: str) -> None:
            progress = min(1.0, len(self._rows) / self._needed)
            self.status = Status(phase, message, name, progress, mean)

        if self._rows:
            if moved or self._turned_away(mean, self._begun_at, MOVED_DEG):
                seconds = len(self._rows) * self.task.seconds / self._needed
                self._rows = []
                show("moving", self._advice())
                return Refused(f"It moved after {seconds:.1f} s. Let it lie until it is taken.")
            self._rows += hop
            show("taking", "keep still")
            if len(self._rows) < self._needed:
                return None
            # Whatever the result of this pose, the next one begins after a movement or a rejection.
            rows, self._rows = self._rows[: self._needed], []
            self._wait_for_move, self._taken_at = True, mean
            return Complete(rows, self._aim)
        if self._wait_for_move:
            # A careful hand moves below the threshold: a new direction counts as a movement too.
            if not still or self._turned_away(mean, self._taken_at, NEAR_DEG):
                self._wait_for_move = False
            else:
                show("taken", self._advice())
                return None
        if not still or len(self._window) < WINDOW_HOPS:
            show("moving", self._advice())
            return None
        phase, message = self._begin(mean, direction)
        if phase == "taking":
            self._rows, self._begun_at = list(hop), mean
        show(phase, message)
        return None

    def _begin(self, mean: FloatArray, direction: FloatArray | None) -> tuple[Phase, str]:
        """Whether a pose may begin here, and the message to show."""
        wrong = self._implausible(mean)
        if wrong:
            return "wrong", wrong
        if direction is None:
            return "wrong", ("the readings show no direction: an accelerometer is needed, or a "
                             "gyroscope on the turning plate")
        unsteady = self._unsteady(mean)
        if unsteady:
            return "unsteady", unsteady
        cosine = self.task.wanted @ direction
        aim = int(np.argmax(cosine))
        if cosine[aim] < NEAR_COSINE:
            off = np.degrees(np.arccos(np.clip(cosine[aim], -1, 1)))
            return "between", (f"{off:.0f}° from the nearest direction that is wanted "
                               f"({direction_name(self.task.wanted[aim])}); {self._advice()}")
        if aim in self.covered:
            return "repeats", (f"{direction_name(self.task.wanted[aim])} is taken already; "
                               f"{self._advice()}")
        self._aim = aim
        return "taking", "keep still"

    def _nominal(self, rows: list[TimedSample]) -> FloatArray:
        """Readings in nominal SI units, (t, 6), NaN where a triad is absent."""
        parts = []
        for triad in TRIADS:
            spec = self.task.specs.get(triad)
            counts = np.array([getattr(row, triad) for row in rows], dtype=float)
            parts.append(np.full_like(counts, np.nan) if spec is None else spec.nominal(counts))
        return np.hstack(parts)

    def _stillness(self) -> tuple[bool, bool]:
        """Whether the window is still, and whether it clearly is not."""
        still, moved = True, False
        # The quiet level of a turning plate differs from that of one at rest.
        learns = not self.task.turns or self._sensed_rate(self._means[-1]) >= self._least_rate()
        for i, triad in enumerate(TRIADS):
            hops = [hop[:, 3 * i : 3 * i + 3] for hop in self._window]
            if not np.isfinite(hops[-1]).all():
                continue
            variance = (float(np.mean([_line_variance(hop) for hop in hops])) if self.task.turns
                        else float(np.vstack(hops).var(axis=0).sum()))
            history = self._history[triad]
            if learns or not history:
                history.append(variance)
            quiet = quiet_level(np.array(history))
            ceiling = CEILING[triad] ** 2
            still &= variance <= min(STILL_RATIO * quiet, ceiling)
            moved |= variance > min(MOVED_RATIO * quiet, ceiling)
        return still, moved

    def _direction(self, mean: FloatArray) -> FloatArray | None:
        """The unit vector of the side that faces up; None where no reading shows it.

        On the turning plate it is that of the axis about which gravity rotates.
        """
        force, rate = mean[:3], mean[3:]
        if self.task.turns and self._sensed_rate(mean) >= self._least_rate():
            vector = less_rest(rate, self.task.rest_rad_s)
            vector = vector * (np.sign(vector @ force) if np.isfinite(force).all() else 1.0)
        elif np.isfinite(force).all():
            vector = force
        else:
            return None
        size = float(np.linalg.norm(vector))
        return vector / size if size > 0 else None

    def _turned_away(self, mean: FloatArray, before: FloatArray, degrees: float) -> bool:
        one, two = self._direction(mean), self._direction(before)
        return one is not None and two is not None and one @ two < np.cos(np.radians(degrees))

    def _implausible(self, mean: FloatArray) -> str:
        force = float(np.linalg.norm(mean[:3]))
        g = STANDARD_GRAVITY_M_S2
        if np.isfinite(force) and not g / PLAUSIBLE_RATIO < force < g * PLAUSIBLE_RATIO:
            return (f"by the data sheet the accelerometer reads {force:.3g} {SI_UNIT[TRIADS[0]]} "
                    f"at rest, {g:.2g} is expected: check sensor.accelerometer in the "
                    f"configuration")
        return ""

    def _sensed_rate(self, mean: FloatArray) -> float:
        """The plate's rate as the gyroscope reads it, rad/s; NaN without a gyroscope."""
        return float(np.linalg.norm(less_rest(mean[3:], self.task.rest_rad_s)))

    def _least_rate(self) -> float:
        """The least rate at which the plate counts as turning."""
        stated = self.task.rate_rad_s
        return stated / PLAUSIBLE_RATIO if stated else TURNING_RAD_S

    def _unsteady(self, mean: FloatArray) -> str:
        """Reason why the plate is not in the state that the block requires; empty if it is."""
        task, rest, sensed = self.task, self.task.rest_rad_s, self._sensed_rate(mean)
        if not np.isfinite(sensed):
            return ""
        if not task.turns:
            turning = rest is not None and sensed > TURNING_RAD_S
            return f"the plate turns at {sensed:.2f} rad/s: stop it" if turning else ""
        if sensed < self._least_rate():
            return "the plate does not turn: start it"
        if rest is not None and task.rate_rad_s:
            off = sensed / task.rate_rad_s - 1
            if abs(off) > SAME_SPEED:
                return (f"the plate turns at {sensed / RPM:.1f} rpm, the configuration "
                        f"says {task.rate_rad_s / RPM:.1f}: set its speed")
        if len(self._means) < STEADY_HOPS:
            return "waiting for the plate's rate to be steady"
        hops = np.array(self._means)[:, 3:]
        half = STEADY_HOPS // 2
        size = [float(np.linalg.norm(part.mean(axis=0))) for part in (hops[:half], hops[half:])]
        noise = float(np.sqrt((np.diff(hops, axis=0) ** 2).mean() / 2 / half) * np.sqrt(2))
        change = size[1] - size[0]
        if abs(change) > max(STEADY_CHANGE * size[0], STEADY_SD * noise):
            verb = "speeds up" if change > 0 else "slows down"
            return f"the plate {verb}: {100 * change / size[0]:+.1f} % in a second"
        return ""

    def _advice(self) -> str:
        following = self.next_direction
        if following is None:
            return "all directions are taken"
        return f"next: {direction_name(self.task.wanted[following])}"


def _line_variance(values: FloatArray) -> float:
    """Variance of ``values`` (t, 3) about a straight line in time, summed over the axes."""
    time = np.linspace(-1, 1, len(values))
    centred = values - values.mean(axis=0)
    return float((centred - np.outer(time, time @ centred / (time @ time))).var(axis=0).sum())
