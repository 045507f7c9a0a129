"""Whether one number can represent the rate of a clip: one table of checks of the measurement.

Each check is a size over the size from which it matters, and a sentence. The first check of
``REFUSALS`` that reaches one refuses the clip; each one of ``WARNINGS`` that does adds a paragraph.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from vision.errors import RateRefused
from vision.geometry import FloatArray
from vision.numbers import RPM, median
from vision.phase_track import PhaseTrack, RateHistory
from vision.rate.cross_checks import CrossChecks
from vision.rate.dropped_frames import DroppedFrames
from vision.rate.steady_part import THRESHOLDS as STEADY
from vision.rate.steady_part import noise_of_turns, steady_advice

FEWEST_STRETCHES = 3  # least number of averages in a clip


@dataclass(frozen=True)
class CheckThresholds:
    """Sizes from which something matters.

    Attributes
    ----------
    turns : float
        Least number of turns. Fact: fewer show no point of the plate twice.
    stopped : float
        Of the fastest rate: a clip that ends slower shows a stop, one that begins slower a run-up.
        Share of the path: a plate that turns back by as much goes to and fro. It chooses the words,
        not the refusal.
    leaps : float
        Share of the rate in all that is not that from frame to frame. Derived: between two equal
        marks that are taken for one (0.5) and noise (0.2).
    hidden_drop : float
        Scatter that hides a dropped frame, over the angle from frame to frame.
    wandering : float
        Scatter that is not noise, over the noise of single frames.
    mostly : float
        Share of the variation in a plate that rotation explains; it chooses the words, not the
        refusal. Fact: 26 of 27 plates of an independent renderer have 0.55 or more, a dark one
        0.32.
    scattered_rad : float
        Scatter about an even rotation that justifies a warning, rad. Ten times that of a poor clip
        (``tests.bench.vision_films``).
    """

    turns: float = 1.0
    stopped: float = 0.5
    leaps: float = 0.35
    hidden_drop: float = 0.5
    wandering: float = 5.0
    mostly: float = 0.5
    scattered_rad: float = 0.0122


THRESHOLDS = CheckThresholds()


@dataclass(frozen=True, eq=False)
class Seen:
    """Quantities of a clip that the checks use.

    Attributes
    ----------
    track : PhaseTrack
    history : RateHistory
    dropped : DroppedFrames
    scatter_rad : float
        Noise of the rate's fit, rad; NaN before the fit.
    rate_rad_s : float
        Rate of the fit, signed; NaN before it.
    others : CrossChecks or None
        The rate by other methods; None before the fit.
    """

    track: PhaseTrack
    history: RateHistory
    dropped: DroppedFrames
    scatter_rad: float = np.nan
    rate_rad_s: float = np.nan
    others: CrossChecks | None = None

    @cached_property
    def even_history(self) -> tuple[FloatArray, float]:
        """Rates from turn to turn, (m,) in rad/s, and the relative range of noise alone.

        Positive in the direction of most of them; averaged over enough turns to detect an unsteady
        plate above the noise of single frames.
        """
        rate = self.history.rate_rad_s
        if len(rate) >= 5:  # without strays
            rate = median(np.lib.stride_tricks.sliding_window_view(rate, 3), axis=1)
        # The mean over n windows of a turn, half a turn apart, retains the noise of two frames at
        # either end, over n half turns.
        spread = noise_of_turns(self.history)
        wanted = int(np.ceil(spread / STEADY.other))
        span = min(wanted, len(rate) // FEWEST_STRETCHES) or 1
        rate = np.lib.stride_tricks.sliding_window_view(rate, span).mean(axis=1)
        return rate * (np.sign(median(rate)) or 1.0), spread / span

    @cached_property
    def change(self) -> float:
        """Relative change of the rate from turn to turn."""
        return float(np.ptp(self.even_history[0]) / max(abs(median(self.even_history[0])), 1e-9))

    @cached_property
    def unsteady(self) -> float:
        """The change over the largest one of a constant rate, or of the noise of frames."""
        return self.change / max(STEADY.other, self.even_history[1])

    @cached_property
    def step_rad(self) -> float:
        """Usual angle from frame to frame."""
        return float(median(np.abs(np.diff(self.history.angle.angle_rad))))

    @cached_property
    def usual_rad_s(self) -> float:
        """Usual rate from frame to frame, signed."""
        angle = self.history.angle
        return float(median(np.diff(angle.angle_rad) / np.diff(angle.index))) / angle.frame_s

    @property
    def is_plate(self) -> bool:
        """Whether rotation explains most of its variation, or this share is unknown."""
        return not self.track.plate.explained < THRESHOLDS.mostly

    @property
    def subject(self) -> str:
        """The object that resembles a plate most; a hand may turn about an axis as well as one."""
        return "what was taken for the plate" + ("" if self.is_plate else (
            f", of whose change rotation explains {self.track.plate.explained:.0%} alone,"))

    def advice(self, usual: str) -> str:
        """Advice: the usual one, or one for something that hardly turns like a plate."""
        return usual if self.is_plate else (
            "A plate in good light shows 50 to 100 %. Keep everything else that moves out of the "
            "frame, fix the camera, switch on a light, or state the rim (--rim, or plate: "
            "centre_px, radii_px); --overlay shows what was tracked."
        )


#: Size, 1 and more if it matters, and the sentence for that case.
Check = tuple[Callable[[Seen], float], Callable[[Seen], str]]


def refuse(seen: Seen) -> None:
    """Raise the first refusal that applies to a clip.

    Raises
    ------
    RateRefused
        With the rate against time.
    """
    for size, sentence in REFUSALS:
        if size(seen) >= 1:
            raise RateRefused(f"{seen.track.source}: {sentence(seen)}", seen.history)


def warnings(seen: Seen) -> tuple[str, ...]:
    """A paragraph for each warning that applies."""
    return tuple(f"{seen.track.source}: {sentence(seen)}" for size, sentence in WARNINGS
                 if size(seen) >= 1)


def _jumps(seen: Seen) -> str:
    return (f"the angle jumps by {seen.dropped.jumps} frame time(s) in all, at about "
            f"{np.degrees(seen.dropped.at_rad) % 360:.0f}° of plate angle")


def _says_unsteady(seen: Seen) -> str:
    rate, history = seen.even_history[0], seen.history
    first, last, fastest = rate[0] / RPM, rate[-1] / RPM, rate.max() / RPM
    if rate.min() < -THRESHOLDS.stopped * rate.max():
        kind = "changes its direction"
    elif last < THRESHOLDS.stopped * fastest:
        kind = "slows down"
    elif first < THRESHOLDS.stopped * fastest:
        kind = "is still running up"
    else:
        kind = "does not turn steadily"
    listed = history.rate_rad_s * (np.sign(median(history.rate_rad_s)) or 1.0) / RPM
    turns = np.abs(listed).mean() * np.ptp(history.angle.time_s) / 60  # there and back
    return (
        f"{seen.subject} {kind}: from {history.time_s[0]:.1f} s to {history.time_s[-1]:.1f} s it "
        f"goes from {listed[0]:.2f} to {listed[-1]:.2f} rpm (slowest {listed.min():.2f}, fastest "
        f"{listed.max():.2f}) in {turns:.2f} turns. A constant rate may change by at most "
        f"{STEADY.other:.0%}. "
        f"{seen.advice(steady_advice(history))}"
    )


def _says_less_than_a_turn(seen: Seen) -> str:
    angle = seen.history.angle.angle_rad
    forth = np.max(angle - np.minimum.accumulate(angle))
    back = np.max(np.maximum.accumulate(angle) - angle)
    if min(forth, back) > THRESHOLDS.stopped * max(forth, back):
        return (
            f"{seen.subject} goes to and fro within {np.ptp(angle) / (2 * np.pi):.2f} of a turn, "
            f"and a rate is that of a plate that turns one way. "
            f"{seen.advice('Let it turn by its motor, then film for a minute.')}"
        )
    return (
        f"{seen.subject} makes {seen.history.revolutions:.2f} of a turn in the clip, "
        f"at least one is needed to separate the rate from an off-centre view. "
        f"{seen.advice('Check that it turns, then film for a minute.')}"
    )


def _says_wandering(seen: Seen) -> str:
    usual, whole = np.abs([seen.usual_rad_s, seen.rate_rad_s]) / RPM
    return (
        f"the angle wanders by {np.degrees(seen.scatter_rad):.2f}° about an even rotation in "
        f"{seen.history.revolutions:.1f} turns, while the noise of a frame is "
        f"{np.degrees(seen.history.phase_noise_rad):.2f}° and what was taken for the plate turns "
        f"by {np.degrees(seen.step_rad):.2f}° from frame to frame, at {usual:.3g} rpm, and at "
        f"{whole:.3g} rpm in all: its rate changes, it is lost, one mark is taken for another, or "
        f"this clip cannot determine whether frames were dropped. Let it turn for a minute with "
        f"one bold mark, or film with fewer frames per second."
    )


def _says_jumps(seen: Seen) -> str:
    dropped = seen.dropped
    if dropped.sd_of_rate > STEADY.trend:
        return (
            f"{_jumps(seen)}. This clip cannot determine whether frames were dropped or the angle "
            f"is mismeasured there (the odds of dropped frames are {dropped.probability:.0%}); "
            f"the sd covers both ({dropped.sd_of_rate:.2%} of the rate). "
            f"Film over more turns, or put a bold mark near the rim."
        )
    if dropped.count:
        return (
            f"the recorder dropped {dropped.count} frame(s) without a gap in the time stamps "
            f"({dropped.count / len(dropped.angle.time_s):.1%}): the angle jumps by whole frame "
            f"times. Their time was put back; of all that time the angles before and after confirm "
            f"{dropped.share:.3f} ± {dropped.share_sd:.3f}."
        )
    return (
        f"{_jumps(seen)}, and returns within a turn. No frame is missing: the angle is mismeasured "
        f"there. The rate uses the time stamps as they are. Film the whole plate, with a mark near "
        f"the rim."
    )


def _says_uneven(seen: Seen) -> str:
    return (f"the rate changes by {seen.change:.2%} within the clip. The result is its mean; a "
            f"sensor logged at another time may have seen another rate.")


def _says_scattered(seen: Seen) -> str:
    late_ms = 1e3 * seen.scatter_rad / abs(seen.rate_rad_s)
    hides = (f" At {np.degrees(seen.step_rad):.2f}° from frame to frame a dropped frame would not "
             f"be noticed, and one in a hundred makes the rate 1 % too high.")
    return (
        f"the angle scatters by {np.degrees(seen.scatter_rad):.1f}° about an even rotation; a "
        f"plate filmed from a stand gives some hundredths. The cause is noise in the frames, time "
        f"stamps that are late by {late_ms:.0f} ms, a camera that moves, or an object that is no "
        f"plate. The sd includes it; --overlay shows what was tracked."
        f"{hides if _hides_drops(seen) >= 1 else ''}"
    )


def _says_two_rates(seen: Seen) -> str:
    others = seen.others
    assert others is not None
    assert others.second is not None
    return (
        f"two things turn in the frame at two rates, {others.by_stamps_rad_s / RPM:.4g} rpm and "
        f"{others.second.rate_rad_s / RPM:.4g} rpm ± "
        f"{others.second.sd_s / others.second.period_s:.1%}. The rate is that of the first, "
        f"which shows more. If the sensor turns with the second, cover the first or state the rim "
        f"of the second (--rim, or plate: centre_px, radii_px)."
    )


def _hides_drops(seen: Seen) -> float:
    return seen.scatter_rad / (THRESHOLDS.hidden_drop * seen.step_rad) * (seen.dropped.count == 0)


REFUSALS: tuple[Check, ...] = (
    (lambda seen: seen.unsteady, _says_unsteady),
    (lambda seen: THRESHOLDS.turns > seen.history.revolutions, _says_less_than_a_turn),
    (lambda seen: max(
        seen.scatter_rad / max(THRESHOLDS.hidden_drop * seen.step_rad,
                               THRESHOLDS.wandering * seen.history.phase_noise_rad),
        (1 - seen.usual_rad_s / seen.rate_rad_s) / THRESHOLDS.leaps), _says_wandering),
)
WARNINGS: tuple[Check, ...] = (  # in the order in which they are printed
    (lambda seen: seen.dropped.jumps, _says_jumps),
    (lambda seen: seen.change / max(STEADY.trend, seen.even_history[1]), _says_uneven),
    (lambda seen: max(seen.scatter_rad / THRESHOLDS.scattered_rad, _hides_drops(seen)),
     _says_scattered),
    (lambda seen: seen.others is not None and seen.others.second is not None, _says_two_rates),
)
