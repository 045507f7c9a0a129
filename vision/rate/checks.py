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
from vision.rate.dropped_frames import HIDES
from vision.rate.slow_changes import SlowRate
from vision.rate.steady_part import OTHER_SPEED, TREND, noise_of_turns, steady_advice
from vision.rate.unwrap import leaps, mean_rate, usual_rate

FEWEST_STRETCHES = 3  #: least number of averages in a clip; derived: two have no middle one


# Sizes from which something matters.
LEAST_TURNS = 1.0  #: least number of turns. Fact: fewer show no point of the plate twice
STOPPED = 0.5
"""Share of the fastest rate: a clip that ends slower shows a stop, one that begins slower a run-up.
Share of the path: a plate that turns back by as much goes to and fro. It chooses the words, not the
refusal."""
WANDERING = 5.0  #: scatter that is not noise, over the noise of single frames
MOSTLY = 0.5
"""Share of the variation in a plate that rotation explains; it chooses the words, not the refusal.
Fact: 26 of 27 plates of an independent renderer have 0.55 or more, a dark one 0.32."""
SCATTERED_RAD = 0.0122
"""Scatter about an even rotation that justifies a warning, rad. Ten times that of a poor clip
(``tests.bench.vision_films``)."""


@dataclass(frozen=True, eq=False)
class Seen:
    """Quantities of a clip that the checks use.

    Attributes
    ----------
    track : PhaseTrack
    history : RateHistory
    mean : SlowRate
        Of the fit.
    scatter_rad : float
        Noise of the rate's fit.
    """

    track: PhaseTrack
    history: RateHistory
    mean: SlowRate
    scatter_rad: float

    @cached_property
    def rates(self) -> tuple[FloatArray, float]:
        """Rates from turn to turn, (m,) in rad/s, and the relative range of noise alone.

        Most of them are positive; strays are left out, and they are averaged over enough turns to
        show an unsteady plate above the noise of single frames.
        """
        rate, noise = self.history.rate_rad_s, noise_of_turns(self.history)
        if len(rate) >= 5:
            rate = median(np.lib.stride_tricks.sliding_window_view(rate, 3), axis=1)
        # The mean over n windows of a turn, half a turn apart, retains the noise of two frames at
        # either end, over n half turns.
        span = min(int(np.ceil(noise / OTHER_SPEED)), len(rate) // FEWEST_STRETCHES) or 1
        rate = np.lib.stride_tricks.sliding_window_view(rate, span).mean(axis=1)
        return rate * (np.sign(median(rate)) or 1.0), noise / span

    @cached_property
    def change(self) -> float:
        """Relative change of the rate, from turn to turn or evenly, as far as it is no noise."""
        rates, noise = self.rates
        if len(self.history.rate_rad_s) < 2:
            return 0.0
        shown = float(np.ptp(rates) / max(abs(median(rates)), 1e-9))
        return max(shown * (shown >= noise), abs(self.mean.change) - 2 * self.mean.change_sd)

    @cached_property
    def step_rad(self) -> float:
        """Usual angle from frame to frame."""
        return float(median(np.abs(np.diff(self.history.angle.angle_rad))))

    @property
    def subject(self) -> str:
        """The object that resembles a plate most; a hand may turn about an axis as well as one."""
        share = self.track.plate.explained
        hardly = f", of whose change rotation explains {share:.0%} alone,"
        return "what was taken for the plate" + hardly * (share < MOSTLY)

    def advice(self, usual: str) -> str:
        """Advice: the usual one, or one for something that hardly turns like a plate."""
        if not self.track.plate.explained < MOSTLY:  # it may be unknown
            return usual
        return ("A plate in good light shows 50 to 100 %. Keep everything else that moves out of "
                "the frame, fix the camera, switch on a light, or state the rim (--rim, or plate: "
                "centre_px, radii_px); --overlay shows what was tracked.")


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


def _says_unsteady(seen: Seen) -> str:
    rate, history = seen.rates[0], seen.history
    if rate.min() < -STOPPED * rate.max():
        kind = "changes its direction"
    elif rate[-1] < STOPPED * rate.max():
        kind = "slows down"
    elif rate[0] < STOPPED * rate.max():
        kind = "is still running up"
    else:
        kind = "does not turn steadily"
    listed = history.rate_rad_s * (np.sign(median(history.rate_rad_s)) or 1.0) / RPM
    turns = np.abs(listed).mean() * np.ptp(history.angle.time_s) / 60  # there and back
    return (
        f"{seen.subject} {kind}: from {history.time_s[0]:.1f} s to {history.time_s[-1]:.1f} s it "
        f"goes from {listed[0]:.2f} to {listed[-1]:.2f} rpm (slowest {listed.min():.2f}, fastest "
        f"{listed.max():.2f}) in {turns:.2f} turns. A constant rate may change by at most "
        f"{OTHER_SPEED:.0%}. {seen.advice(steady_advice(history))}"
    )


def _says_less_than_a_turn(seen: Seen) -> str:
    angle = seen.history.angle.angle_rad
    forth = np.max(angle - np.minimum.accumulate(angle))
    back = np.max(np.maximum.accumulate(angle) - angle)
    if min(forth, back) > STOPPED * max(forth, back):
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
    usual, whole = (abs(rate(seen.history.angle)) / RPM for rate in (usual_rate, mean_rate))
    scatter, noise, step = np.degrees(
        [seen.scatter_rad, seen.history.phase_noise_rad, seen.step_rad])
    return (
        f"the angle wanders by {scatter:.2f}° about an even rotation in "
        f"{seen.history.revolutions:.1f} turns, while the noise of a frame is {noise:.2f}° and "
        f"what was taken for the plate turns by {step:.2f}° from frame to frame, usually at "
        f"{usual:.3g} rpm, and at {whole:.3g} rpm in all: its rate changes, it is lost, one mark "
        f"is taken for another, or this clip cannot determine whether frames were dropped. Let it "
        f"turn for a minute with one bold mark, or film with fewer frames per second."
    )


def _says_uneven(seen: Seen) -> str:
    mean = seen.mean
    size = (f"{mean.change:+.2%} ± {mean.change_sd:.2%}, evenly,"
            if abs(mean.change) > 4 * mean.change_sd else f"{seen.change:.2%}")
    return (f"the rate changes by {size} within the clip. The result is its mean; a sensor logged "
            f"at another time may have seen another rate.")


def _says_scattered(seen: Seen) -> str:
    late_ms = 1e3 * seen.scatter_rad / abs(seen.mean.rate_rad_s)
    hides = (f" At {np.degrees(seen.step_rad):.2f}° from frame to frame a dropped frame would not "
             f"be noticed, and one in a hundred makes the rate 1 % too high.")
    return (
        f"the angle scatters by {np.degrees(seen.scatter_rad):.1f}° about an even rotation; a "
        f"plate filmed from a stand gives some hundredths. The cause is noise in the frames, time "
        f"stamps that are late by {late_ms:.0f} ms, a camera that moves, or an object that is no "
        f"plate. The sd includes it; --overlay shows what was tracked."
        f"{hides if _hides_drops(seen) >= 1 else ''}"
    )


def _hides_drops(seen: Seen) -> float:
    return seen.scatter_rad / (HIDES * seen.step_rad)


def _wanders(seen: Seen) -> float:
    noise = max(HIDES * seen.step_rad, WANDERING * seen.history.phase_noise_rad)
    return max(seen.scatter_rad / noise, leaps(seen.history.angle))


REFUSALS: tuple[Check, ...] = (
    (lambda seen: seen.change / OTHER_SPEED, _says_unsteady),
    (lambda seen: seen.history.revolutions < LEAST_TURNS, _says_less_than_a_turn),
    (_wanders, _says_wandering),
)
WARNINGS: tuple[Check, ...] = (  # in the order in which they are printed
    (lambda seen: seen.change / TREND, _says_uneven),
    (lambda seen: max(seen.scatter_rad / SCATTERED_RAD, _hides_drops(seen)),
     _says_scattered),
)
