"""Steady, drifting or stopping: whether one number can stand for the rate of a clip."""

from dataclasses import dataclass

import numpy as np

from vision.errors import RateRefused
from vision.geometry import FloatArray
from vision.phase_track import PhaseTrack, RateHistory
from vision.rate.aliases import RPM

SCATTERED_RAD = np.radians(0.7)  # about an even rotation; ten times what a poor film gives

FEWEST = 6  # pictures in which the surroundings were looked at
SMOOTHED = 5  # of them
ROLLED_RAD = np.radians(0.3)
CLEAR = 8.0  # times the noise, for a roll to be told from it

UNSTEADY = 0.01  # relative change of the rate within the clip that is refused
UNEVEN = 0.001  # relative change worth a word
STOPPED = 0.5  # of the fastest: slower at the end is a stop, at the start a run-up
STEADY_WITHIN = 0.002  # relative; what counts as steady when looking for a usable stretch
STEADY_TURNS = 3
PEAK_TO_PEAK = 8.0  # standard deviations, of a hundred that overlap
NOISE_SHARE = 0.5  # of what is refused, that noise may reach
HIDING = 0.5  # of the angle from picture to picture: a scatter that hides a lost picture
WANDERING = 5.0  # times the noise of single pictures
FEWEST_STRETCHES = 3  # that a clip is averaged in


def _variation(rate: FloatArray) -> float:
    """Relative change from turn to turn."""
    return float(np.ptp(rate) / max(abs(np.median(rate)), 1e-9))


def refuse_unsteady(source: str, history: RateHistory) -> None:
    """Raise ``RateRefused`` with the history if the rate is not constant."""
    rate, _ = _forward(history)
    if _variation(rate) < UNSTEADY:
        return
    first, last, fastest = rate[0] / RPM, rate[-1] / RPM, rate.max() / RPM
    if rate.min() < -STOPPED * rate.max():
        kind = "changes its direction"
    elif last < STOPPED * fastest:
        kind = "slows down"
    elif first < STOPPED * fastest:
        kind = "is still running up"
    else:
        kind = "does not turn steadily"
    span = f"from {history.time_s[0]:.1f} s to {history.time_s[-1]:.1f} s"
    raise RateRefused(
        f"{source}: the plate {kind}: {span} it goes from {first:.2f} to {last:.2f} rpm "
        f"(slowest {rate.min() / RPM:.2f}, fastest {fastest:.2f}) in {history.revolutions:.2f} "
        f"turns, and no constant rate can stand for that; at most {UNSTEADY:.0%} of change is "
        f"taken. {_advice(history, rate)}",
        history,
    )


def refuse_wandering(source: str, history: RateHistory, scatter_rad: float) -> None:
    """Raise ``RateRefused`` where lost pictures look like the plate's own unevenness.

    Pictures that a recorder loses silently make the angle jump. With a fast camera the jumps are
    small; blurred by an encoder they are a slow wander, and the rate is too high by their share.
    """
    step = angle_step(history)
    if scatter_rad < max(HIDING * step, WANDERING * history.phase_noise_rad):
        return
    raise RateRefused(
        f"{source}: the angle wanders by {np.degrees(scatter_rad):.2f}° about an even rotation, "
        f"though each picture is good to {np.degrees(history.phase_noise_rad):.2f}°, and the plate "
        f"turns by {np.degrees(step):.2f}° from picture to picture: pictures lost by the recorder "
        f"cannot be told from that. Film with fewer pictures per second, or put a bold mark near "
        f"the rim.",
        history,
    )


def angle_step(history: RateHistory) -> float:
    """Usual angle from picture to picture, rad."""
    return float(np.median(np.abs(np.diff(history.angle.angle_rad))))


def _forward(history: RateHistory) -> tuple[FloatArray, float]:
    """Rates from turn to turn, and how far apart noise alone would spread them, relative.

    Positive in the direction of most of them; without strays; averaged over as many turns as it
    takes to see an unsteady plate through the noise of single pictures: stamps that come a few
    milliseconds early or late are no change of the rate.
    """
    rate = _without_strays(history.rate_rad_s)
    # The mean over n windows of a turn, half a turn apart, leaves the noise of two pictures at
    # either end, over n half turns.
    spread = PEAK_TO_PEAK * 2 * history.phase_noise_rad / (2 * np.pi)
    wanted = int(np.ceil(spread / (NOISE_SHARE * UNSTEADY)))
    span = min(wanted, len(rate) // FEWEST_STRETCHES) or 1
    rate = np.lib.stride_tricks.sliding_window_view(rate, span).mean(axis=1)
    return rate * (np.sign(np.median(rate)) or 1.0), float(spread / span)


def _without_strays(rate: FloatArray) -> FloatArray:
    if len(rate) < 5:
        return rate
    return np.median(np.lib.stride_tricks.sliding_window_view(rate, 3), axis=1)


def _advice(history: RateHistory, rate: FloatArray) -> str:
    """The longest stretch that could be used, if there is one."""
    lead = (len(history.time_s) - len(rate)) // 2
    time_s = history.time_s[lead : lead + len(rate)]
    best = (0, 0)
    start = 0
    for stop in range(1, len(rate) + 1):
        while np.ptp(rate[start:stop]) > STEADY_WITHIN * abs(rate[start]):
            start += 1
        if stop - start > best[1] - best[0]:
            best = (start, stop)
    # The turn by turn values are half a turn apart.
    if best[1] - best[0] < 2 * STEADY_TURNS:
        return "Let the plate settle and film again."
    low, high = time_s[best[0]], time_s[best[1] - 1]
    return f"It is steady from {low:.1f} s to {high:.1f} s: cut the clip to that part."


def uneven_warning(source: str, history: RateHistory) -> tuple[str, ...]:
    """A word on a rate that changes a little."""
    rate, spread = _forward(history)
    change = _variation(rate)
    if change < max(UNEVEN, spread):
        return ()
    return (
        f"{source}: the rate changes by {change:.2%} within the clip; the figure is its mean, and "
        f"a sensor logged at another time may have seen another rate.",
    )


@dataclass(frozen=True)
class CameraRoll:
    """A camera that rolled while it filmed.

    Attributes
    ----------
    range_rad : float
        How far.
    rate_rad_s : float
        Slope against time, counter-clockwise as filmed: what it adds to the rate of the plate.
    """

    range_rad: float
    rate_rad_s: float


def camera_roll(track: PhaseTrack, time_s: FloatArray) -> CameraRoll | None:
    """The camera's roll; None where it stood still, or where that cannot be seen."""
    seen = np.isfinite(track.roll_rad)
    if seen.sum() < FEWEST:
        return None
    time, roll = time_s[seen], track.roll_rad[seen]
    noise = 1.4826 * float(np.median(np.abs(np.diff(roll, 2)))) / np.sqrt(6.0)
    smooth = np.median(np.lib.stride_tricks.sliding_window_view(roll, SMOOTHED), axis=1)
    range_rad = float(np.ptp(smooth))
    if range_rad < max(ROLLED_RAD, CLEAR * noise):
        return None
    away = time - time.mean()
    return CameraRoll(range_rad, float(away @ roll / (away @ away)))


def lost_pictures(source: str, history: RateHistory, noise_rad: float) -> tuple[str, ...]:
    """Pictures found lost silently, or that none could be found."""
    angle = history.angle
    lost = int(angle.lost.sum())
    if lost:
        return (
            f"{source}: {lost} picture(s) were lost without a trace in the time stamps "
            f"({lost / len(angle.time_s):.1%}): the angle jumps by whole frame times. Their time "
            f"was put back, so the rate stands.",
        )
    step = angle_step(history)
    if noise_rad < HIDING * step:
        return ()
    return (
        f"{source}: the plate turns by {np.degrees(step):.2f}° from picture to picture and the "
        f"angle scatters by {np.degrees(noise_rad):.2f}°: a picture that the recorder lost would "
        f"not be noticed, and one in a hundred makes the rate 1 % too high. With fewer pictures "
        f"per second, or a bold mark, it would be.",
    )


def scattered_angle(source: str, noise_rad: float, rate_rad_s: float) -> tuple[str, ...]:
    """An angle further off an even rotation than a plate goes."""
    if noise_rad < SCATTERED_RAD:
        return ()
    return (
        f"{source}: the angle scatters by {np.degrees(noise_rad):.1f}° about an even rotation, "
        f"where a plate filmed from a stand gives some hundredths: noisy pictures, time stamps "
        f"that are late by {1e3 * noise_rad / abs(rate_rad_s):.0f} ms, a camera that moves, or "
        f"something that is no plate. The uncertainty counts it; see in the annotated picture what "
        f"was followed.",
    )


def rolling_camera(source: str, roll: CameraRoll | None, rate_rad_s: float) -> tuple[str, ...]:
    """A camera that rolled while it filmed."""
    if roll is None:
        return ()
    share = abs(roll.rate_rad_s / rate_rad_s)
    return (
        f"{source}: the camera rolled by {np.degrees(roll.range_rad):.1f}° while it filmed, as "
        f"what lies around the plate shows. Of the rate {share * 1e6:.0f} ppm may be the camera's "
        f"own; the sd has them. Fix the camera to a stand and film again.",
    )
