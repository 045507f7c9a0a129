"""Whether one number can represent the rate of a clip: one table of checks of the measurement.

Each check is a size over the size from which it matters, and a sentence. The first check of
``REFUSALS`` that reaches one refuses the clip; each one of ``WARNINGS`` that does adds a paragraph.
"""

from collections.abc import Callable

import numpy as np

from vision.errors import RateRefused
from vision.numbers import RPM, median
from vision.rate.dropped_frames import THRESHOLDS as DROPPED
from vision.rate.seen import THRESHOLDS, Seen
from vision.rate.steady_part import THRESHOLDS as STEADY
from vision.rate.steady_part import steady_advice

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


def _says_jumps(seen: Seen) -> str:
    dropped, angle = seen.dropped, seen.dropped.angle
    is_time = dropped.probability >= 0.5
    jumps = (f"the angle jumps by {np.abs(dropped.size).sum():.3g} frame time(s) in all, at about "
             f"{np.degrees(dropped.at_rad) % 360:.0f}° of plate angle")
    if dropped.sd_of_rate > STEADY.trend:
        return (
            f"{jumps}. This clip cannot determine whether frames were dropped or the angle "
            f"is mismeasured there (the odds of dropped frames are "
            f"{np.average(dropped.probability, weights=np.abs(dropped.size)):.0%}); "
            f"the sd covers both ({dropped.sd_of_rate:.2%} of the rate). "
            f"Film over more turns, or put a bold mark near the rim."
        )
    if not is_time.any():
        return (
            f"{jumps}, and returns within a turn. No frame is missing: the angle is mismeasured "
            f"there. The rate uses the time stamps as they are. Film the whole plate, with a mark "
            f"near the rim."
        )
    causes = []
    if dropped.count:
        causes.append(
            f"the recorder dropped {dropped.count} frame(s) without a gap in the time stamps "
            f"({dropped.count / len(angle.time_s):.1%}): the angle jumps by whole frame times. "
            f"Their time was put back.")
    if angle.stepped.any():
        steps = [f"{1e3 * angle.frame_s * by:+.0f} ms at {at:.1f} s"
                 for by, at in zip(-angle.dropped[angle.stepped], angle.time_s[angle.stepped],
                                   strict=True)]
        causes.append(
            f"the clock of the time stamps steps by {' and '.join(steps)}, or that and whole "
            f"turns of the plate: the angle jumps there by no whole number of frame times. The "
            f"rate is fitted beside it.")
    return " ".join(causes)


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
    second = others.second
    assert second is not None
    return (
        f"two things turn in the frame at two rates, {others.by_stamps_rad_s / RPM:.4g} rpm and "
        f"{second.rate_rad_s / RPM:.4g} rpm ± {second.sd_s / second.period_s:.1%}. The rate is "
        f"that of the first, which shows more. If the sensor turns with the second, cover the "
        f"first or state the rim of the second (--rim, or plate: centre_px, radii_px)."
    )


def _hides_drops(seen: Seen) -> float:
    return seen.scatter_rad / (DROPPED.hides * seen.step_rad) * (seen.dropped.count == 0)


def _wanders(seen: Seen) -> float:
    noise = max(DROPPED.hides * seen.step_rad,
                THRESHOLDS.wandering * seen.history.phase_noise_rad)
    leaps = 1 - seen.usual_rad_s / seen.rate_rad_s
    return max(seen.scatter_rad / noise, leaps / THRESHOLDS.leaps)


REFUSALS: tuple[Check, ...] = (
    (lambda seen: seen.unsteady, _says_unsteady),
    (lambda seen: THRESHOLDS.turns > seen.history.revolutions, _says_less_than_a_turn),
    (_wanders, _says_wandering),
)
WARNINGS: tuple[Check, ...] = (  # in the order in which they are printed
    (lambda seen: len(seen.dropped.size), _says_jumps),
    (lambda seen: seen.change / max(STEADY.trend, seen.even_history[1]), _says_uneven),
    (lambda seen: max(seen.scatter_rad / THRESHOLDS.scattered_rad, _hides_drops(seen)),
     _says_scattered),
    (lambda seen: seen.others is not None and seen.others.second is not None, _says_two_rates),
)
